"""Arguments and results as machine words, and how their layouts are written down.

A word is an integer or the bits of a double. An array takes a word for its address and one for
each extent, a tuple the words of its items. A layout is a list of items: a letter for a scalar,
the type of an array, `name( ... )` for a tuple; in that of a result the name is the full one of a
class.
"""

from __future__ import annotations

import ctypes
import itertools
import pkgutil
import struct
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

# Letters of scalars in a layout, and in the formats of `struct`.
SCALARS = {bool: "?", np.bool_: "?", int: "q", np.int64: "q", float: "d", np.float64: "d"}

Words = list[int | float]


def flatten(arguments: tuple[Any, ...]) -> tuple[str, Words]:
    """The layout of some arguments and their words.

    Arguments are C-contiguous arrays, scalars of the types that numpy has by default, and tuples
    of these.

    Returns
    -------
    layout : str
        Equal for arguments that the same machine code can take.
    words : list

    Raises
    ------
    TypeError
        Some argument is none of these.
    """
    layout: list[str] = []
    words: Words = []
    _append(arguments, layout, words)
    return " ".join(layout), words


def _append(values: tuple[Any, ...], layout: list[str], words: Words) -> None:
    for value in values:
        if isinstance(value, np.ndarray):
            flags = value.flags
            if not (flags.c_contiguous and flags.aligned and value.dtype.isnative):
                raise TypeError("kernels take C-contiguous arrays in native byte order only")
            access = "" if flags.writeable else "r"
            layout.append(f"{value.dtype.str}{value.ndim}{access}")
            words.append(value.ctypes.data)
            words.extend(value.shape)
        elif isinstance(value, tuple):
            layout.append(f"{type(value).__name__}(")
            _append(value, layout, words)
            layout.append(")")
        elif letter := SCALARS.get(type(value)):
            layout.append(letter)
            words.append(float(value) if letter == "d" else int(value))
        else:
            raise TypeError(f"kernels take no {type(value).__name__}")


def packing(words: Words) -> Callable[..., bytes]:
    """What puts the words of arguments of one layout, such as these, one behind the other."""
    letters = ("d" if isinstance(word, float) else "q" for word in words)
    return struct.Struct("".join(letters)).pack


# What makes a result of its items, and these; the letter of a scalar.
Template = tuple[Callable[[list[Any]], Any], list[Any]] | str


class Results:
    """What code of one layout of results returns.

    Attributes
    ----------
    room : callable
        Makes an array for the words of one call.
    """

    def __init__(self, layout: str) -> None:
        items = layout.split()
        self._templates = _templates(iter(items))
        letters = ["d" if item == "d" else "q" for item in items if item in SCALARS.values()]
        self._unpack = struct.Struct("".join(letters)).unpack_from
        self.room = ctypes.c_int64 * len(letters)

    def value(self, words: ctypes.Array[ctypes.c_int64]) -> Any:
        """The result that a call wrote as words."""
        # None is a result without a word.
        if not self._templates:
            return None
        return _assembled(self._templates[0], iter(self._unpack(words)))


def _templates(layout: Iterator[str]) -> list[Template]:
    """The items of a layout of results, up to the end of the tuple that they are in."""
    items: list[Template] = []
    for item in itertools.takewhile(lambda item: item != ")", layout):
        if item.endswith("("):
            named = pkgutil.resolve_name(item[:-1])
            items.append((getattr(named, "_make", named), _templates(layout)))
        else:
            items.append(item)
    return items


def _assembled(template: Template, values: Iterator[Any]) -> Any:
    if isinstance(template, str):
        return bool(next(values)) if template == "?" else next(values)
    make, items = template
    return make([_assembled(item, values) for item in items])
