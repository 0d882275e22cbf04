"""The elements of a file of VTK with XML, and where in it the content of each stands.

Numbers make up nearly all of such a file, so they are not made into text on the way: an element
knows where they start and end. Appended data may be raw, which is no XML: it is cut off before.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from ..sniff import UnreadableError

_APPENDED = re.compile(rb"<AppendedData\b[^>]*>")
_TAG = re.compile(rb"<(?:[^\"'>]|\"[^\"]*\"|'[^']*')*>")
_END = b"</AppendedData></VTKFile>"


@dataclass
class Element:
    """An element: its name, attributes and children, and where its text starts and ends.

    The text ends where the first child starts: VTK puts what it knows of an array behind it.
    """

    tag: str
    attributes: dict[str, str]
    start: int = 0
    end: int = 0
    children: list[Element] = field(default_factory=list)

    def all(self, *tags: str) -> Iterator[Element]:
        """The children with one of these names."""
        return (child for child in self.children if child.tag in tags)

    def first(self, tag: str) -> Element | None:
        """The first child with a name."""
        return next(self.all(tag), None)

    def get(self, name: str, otherwise: str = "") -> str:
        """An attribute."""
        return self.attributes.get(name, otherwise)

    def count(self, name: str, otherwise: str = "") -> int:
        """An attribute that is a number, not below 0.

        Raises
        ------
        UnreadableError
            It is missing, or something else.
        """
        value = self.get(name).strip() or otherwise
        if not re.fullmatch(r"\d{1,18}", value):
            raise UnreadableError(f"<{self.tag}> should have a count {name}, and has {value!r}")
        return int(value)

    def numbers(self, name: str, otherwise: str, n: int) -> list[float]:
        """An attribute that has n numbers.

        Raises
        ------
        UnreadableError
            It does not have them.
        """
        words = (self.get(name) or otherwise).split()
        try:
            values = [float(word) for word in words]
        except ValueError:
            values = []
        if len(values) != n:
            raise UnreadableError(f"<{self.tag}> should have {n} numbers as {name}")
        return values


def parse(data: bytes) -> tuple[Element, bytes | memoryview]:
    """Take a file apart.

    Returns
    -------
    root : Element
    appended : bytes-like
        The appended data, after the underscore that starts it.

    Raises
    ------
    UnreadableError
        It is no XML, or a part of its end is missing.
    """
    found = _APPENDED.search(data)
    if not found or found[0].endswith(b"/>"):
        return _elements(data), b""
    end = data.rfind(b"</AppendedData", found.end())
    start = data.find(b"_", found.end()) + 1
    if end < 0 or not found.end() < start <= end:
        raise UnreadableError("truncated: its appended data has no end")
    root = _elements(data[: found.end()] + _END)
    return root, memoryview(data)[start:end]


def _elements(text: bytes) -> Element:
    parser = expat.ParserCreate()
    open_elements: list[Element] = []
    roots: list[Element] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        where = _TAG.match(text, parser.CurrentByteIndex)
        element = Element(tag, attributes, where.end() if where else 0)
        if open_elements:
            parent = open_elements[-1]
            parent.children.append(element)
            parent.end = parent.end or parser.CurrentByteIndex
        else:
            roots.append(element)
        open_elements.append(element)

    def end(_: str) -> None:
        element = open_elements.pop()
        element.end = element.end or max(parser.CurrentByteIndex, element.start)

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    try:
        parser.Parse(text, True)
    except (expat.ExpatError, ValueError) as error:
        raise UnreadableError(f"truncated or malformed XML: {_reason(error)}") from None
    return roots[0]


def _reason(error: Exception) -> str:
    return str(error).removeprefix("XML: ").replace(":", " at", 1)
