"""The views of a Gmsh file: values at nodes and elements, at several times."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from ...mesh.model import Array, Mesh, View
from ...mesh.tags import DIM_TAGS, GEOMETRICAL, PARAMETRIC, PARTITION, PHYSICAL
from ..sniff import GmshHeader, UnreadableError
from .names import decoded
from .numbers import INTEGER, REAL, Numbers
from .places import Places
from .sink import Sink

VIEW_WIDTHS = (1, 3, 9)  # components of a value in a view
AT_NODES, AT_ELEMENTS = "NodeData", "ElementData"
_TAKEN = (PHYSICAL, GEOMETRICAL, DIM_TAGS, PARAMETRIC)  # arrays that are no views

_COUNT = re.compile(rb"\s*(\d+)[ \t]*(?:\r?\n|\Z)")
_STRING = re.compile(rb'[ \t]*"([^"]*)"[ \t]*\r?\n|([^\r\n]*)\r?\n')
_NUMBER = re.compile(rb"\s*([^\s$]+)[ \t]*(?:\r?\n|\Z)")


@dataclass
class Values:
    """What stands in one section.

    Attributes
    ----------
    section : str
        `AT_NODES` or `AT_ELEMENTS`.
    view : View
    partition : int
        The part of the mesh that the values are of, 0 where it is not parted.
    scheme : str
        Name of the scheme that interpolates between the values, if there is one.
    rows : (n,) int64
        Nodes or elements as the file numbers them.
    values : (n,) or (n, k) float64
    """

    section: str
    view: View
    partition: int
    scheme: str
    rows: Array
    values: Array


def read_view(section: str, content: bytes, header: GmshHeader, number: int) -> Values:
    """Read $NodeData or $ElementData, which without a name gets that of a running number."""
    at = 0

    def next_of(pattern: re.Pattern[bytes]) -> bytes:
        nonlocal at
        found = pattern.match(content, at)
        if not found:
            raise UnreadableError(f"the section ${section} is truncated or malformed")
        at = found.end()
        return next(text for text in (*found.groups(), b"") if text is not None)

    def several(pattern: re.Pattern[bytes]) -> list[bytes]:
        return [next_of(pattern) for _ in range(int(next_of(_COUNT)))]

    texts, reals, integers = several(_STRING), several(_NUMBER), several(_NUMBER)
    try:
        time = float(reals[0]) if reals else 0.0
        step, width, n, partition = [*map(int, integers[:4]), 0, 0, 0, 0][:4]
    except ValueError:
        raise UnreadableError(f"in the section ${section}, a number was expected") from None
    if len(integers) < 3 or width < 1:
        raise UnreadableError(f"the section ${section} does not say how many values it has")
    rows, values = Numbers(section, content[at:], header).rows(n, (INTEGER, 1), (REAL, width))
    name = decoded(texts[0]).strip() if texts else ""
    scheme = decoded(texts[1]).strip() if len(texts) > 1 else ""
    view = View(name or f"view {number}", time, step)
    values = values[:, 0] if width == 1 else values
    return Values(section, view, partition, scheme, rows[:, 0], values)


def attach_views(mesh: Mesh, found: list[Values], nodes: Places, elements: Places) -> list[str]:
    """Turn views into arrays of a mesh, with NaN where they have no value.

    A view of several steps becomes an array for each, called by its name, @ and the step. The
    parts of a view that belong to partitions of the mesh become one array.

    Returns
    -------
    list of str
        What could not be kept.
    """
    lost = []
    ends = np.cumsum([len(block.cells) for block in mesh.blocks])[:-1]
    for name, parts in _named(mesh, _arrays(found)):
        at_nodes = parts[0].section == AT_NODES
        whole, missing = _whole(parts, nodes if at_nodes else elements)
        if any(part.scheme for part in parts):
            lost.append(f"the interpolation scheme of the view {name}")
        if missing:
            lost.append(f"values of the view {name} at nodes or elements that are not there")
        if at_nodes:
            mesh.point_data[name] = whole
            continue
        for block, values in zip(mesh.blocks, np.split(whole, ends), strict=True):
            if name == PARTITION:
                block.data[name] = np.nan_to_num(values).astype(np.int64)
            elif not np.isnan(values).all():
                block.data[name] = values
    return lost


def _arrays(found: list[Values]) -> list[list[Values]]:
    """Put the sections that make one array together: those of other partitions."""
    arrays: dict[tuple[object, ...], list[Values]] = {}
    for part in found:
        again = 0
        while True:
            key = (part.section, part.view, part.values.shape[1:], again)
            alike = arrays.setdefault(key, [])
            if all(part.partition != other.partition for other in alike):
                alike.append(part)
                break
            again += 1
    return list(arrays.values())


def _named(mesh: Mesh, arrays: list[list[Values]]) -> Iterable[tuple[str, list[Values]]]:
    """Give each array a name of its own, and tell the mesh what view it is."""
    titles = [(parts[0].section, parts[0].view.name) for parts in arrays]
    taken = {(section, name) for section in (AT_NODES, AT_ELEMENTS) for name in _TAKEN}
    for (section, title), parts in zip(titles, arrays, strict=True):
        view, several = parts[0].view, titles.count((section, title)) > 1
        name = base = f"{title}@{view.step}" if several else title
        more = 1
        while (section, name) in taken or mesh.views.get(name, view) != view:
            more += 1
            name = f"{base}@{more}"
        taken.add((section, name))
        if view != View(name):
            mesh.views[name] = view
        yield name, parts


def _whole(parts: list[Values], places: Places) -> tuple[Array, bool]:
    """The values of an array, and whether some are of what is not there."""
    values = np.full((len(places.numbers), *parts[0].values.shape[1:]), np.nan)
    missing = False
    for part in parts:
        at, inside = places.there(part.rows)
        if inside.all():
            values[at] = part.values
        else:
            values[at[inside]] = part.values[inside]
            missing = True
    return values, missing


def write_views(f: BinaryIO, mesh: Mesh, binary: bool, but: tuple[str, ...]) -> None:
    """Write the arrays of a mesh, of a width in `VIEW_WIDTHS`, but tags and some others."""
    for name, values in mesh.point_data.items():
        if name not in _TAKEN:
            rows = np.arange(1, len(values) + 1)
            _write(f, AT_NODES, mesh.views.get(name, View(name)), rows, values, binary)
    for name in dict.fromkeys(name for block in mesh.blocks for name in block.data):
        if name not in (*_TAKEN, *but):
            here = [np.full(len(block.cells), name in block.data) for block in mesh.blocks]
            rows = np.flatnonzero(np.concatenate(here)) + 1
            values = np.concatenate([b.data[name] for b in mesh.blocks if name in b.data])
            _write(f, AT_ELEMENTS, mesh.views.get(name, View(name)), rows, values, binary)


def _write(f: BinaryIO, section: str, view: View, rows: Array, values: Array, binary: bool) -> None:
    values = values.reshape(len(rows), -1).astype(np.float64)
    there = ~np.isnan(values).all(axis=1)
    rows, values = rows[there], values[there]
    title = view.name.replace('"', "'").replace("\n", " ")
    head = f'${section}\n1\n"{title}"\n1\n{view.time}\n3\n{view.step}\n'
    f.write(f"{head}{values.shape[1]}\n{len(rows)}\n".encode(errors="replace"))
    sink = Sink(f, binary)
    sink.rows(("i4", rows), ("f8", values))
    sink.end(section)
