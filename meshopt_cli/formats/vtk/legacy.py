"""Reads VTK's files without XML (`.vtk`), versions 1.0 to 5.1, text and binary.

A file is a row of sections, each with a keyword, in upper or lower case. They are read in any
order; what they say of each other is compared at the end.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...mesh.model import Array, Mesh
from ..sniff import Encoding, UnreadableError
from . import grids
from .cells import Cells, checked
from .cursor import BIT, Cursor, name_of
from .dataset import Dataset, keep, mesh_of
from .surface import NO_CELLS, SURFACE, surface

_HEADER = re.compile(rb"\s*[^\n]*\n[^\n]*\n\s*\w+[^\n]*")
_OFFSETS = re.compile(rb"\s*OFFSETS\s+(\S+)[ \t]*\r?\n?", re.IGNORECASE)
_CONNECTIVITY = re.compile(rb"\s*CONNECTIVITY\s+(\S+)[ \t]*\r?\n?", re.IGNORECASE)
_COLOURS = re.compile(rb"\s*LOOKUP_TABLE[ \t]+\S+[ \t]*\r?\n", re.IGNORECASE)
_UNSTRUCTURED, _POLYDATA, _IMAGE = "unstructured_grid", "polydata", "structured_points"
_GRID, _RECTILINEAR = "structured_grid", "rectilinear_grid"
_KINDS = (_UNSTRUCTURED, _POLYDATA, _IMAGE, _GRID, _RECTILINEAR)
# Attributes with a name and a type, by the number of their components.
_WIDTHS = {"vectors": 3, "normals": 3, "tensors": 9, "tensors6": 6, "global_ids": 1}
_WIDTHS |= {"pedigree_ids": 1, "edge_flags": 1}


def read(path: Path, data: bytes, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Read a file, and what of it is left out."""
    header = _HEADER.match(data)
    if not header:
        raise UnreadableError("its header is not complete")
    sections = _Sections(Cursor(data, header.end(), encoding.binary))
    dropped = sections.dropped
    dataset = sections.dataset()
    if not encoding.binary and not data.endswith((b"\n", b"\r")):
        n = data.count(b"\n") + 1
        dropped.append(f"what follows line {n}, if anything: the file may be cut off in that line")
    mesh = mesh_of(dataset, dropped)
    mesh.fields = sections.fields
    return mesh, dropped


class _Sections:
    """What the sections of a file say, read one after another."""

    def __init__(self, cursor: Cursor):
        self.cursor = cursor
        self.dropped: list[str] = []
        self.kind = ""
        self.points: Array | None = None
        self.axes: dict[str, Array] = {}
        self.triples: dict[str, list[float]] = {}
        self.cells: dict[str, tuple[Array, Array]] = {}
        self.types: Array | None = None
        self.arrays: dict[str, dict[str, Array]] = {"point_data": {}, "cell_data": {}}
        self.fields: dict[str, Array] = {}
        self.counts: dict[str, int] = {}
        self.target = ""  # whose arrays follow
        self.ids = ""
        handlers = self._handlers()
        while word := cursor.word():
            if word.startswith("#"):  # a comment: no keyword starts so
                cursor.line()
                continue
            handler = handlers.get(word.lower())
            if handler is None:
                raise cursor.refuse(f"unknown keyword {word[:40]!r}")
            handler(word.lower())

    def _handlers(self) -> dict[str, Callable[[str], None]]:
        table: dict[str, Callable[[str], None]] = {
            "dataset": self._dataset,
            "points": self._points,
            "cell_types": self._types,
            "field": self._field,
            "metadata": lambda _: self.cursor.past_block(),
            "scalars": self._scalars,
            "color_scalars": self._colours,
            "lookup_table": self._lookup_table,
            "texture_coordinates": self._texture,
        }
        table |= dict.fromkeys(("cells", *SURFACE), self._cells)
        table |= dict.fromkeys(("dimensions", "origin", "spacing", "aspect_ratio"), self._triple)
        table |= dict.fromkeys(("x_coordinates", "y_coordinates", "z_coordinates"), self._axis)
        table |= dict.fromkeys(self.arrays, self._arrays_of)
        return table | dict.fromkeys(_WIDTHS, self._attribute)

    # What a section says after its keyword.

    def _words(self, keyword: str, n: int) -> list[str]:
        """The words in the line of a keyword, at least n."""
        start = self.cursor.at
        words = self.cursor.line()
        if len(words) < n:
            self.cursor.at = start
            raise self.cursor.refuse(f"{_said(keyword)} is not complete")
        return words

    def _count(self, word: str, keyword: str) -> int:
        if not re.fullmatch(r"\d{1,18}", word):
            self.cursor.at -= 1  # back into the line
            raise self.cursor.refuse(f"{_said(keyword)} has {word[:40]!r} for a count")
        return int(word)

    def _dataset(self, keyword: str) -> None:
        self.kind = self._words(keyword, 1)[0].lower()
        if self.kind not in _KINDS:
            raise UnreadableError(
                f"its data set is of the kind {self.kind[:40]!r}: known are "
                + ", ".join(kind.upper() for kind in _KINDS)
            )

    def _points(self, keyword: str) -> None:
        n, kind = self._words(keyword, 2)[:2]
        values = self._array("POINTS", kind, 3 * self._count(n, keyword))
        self.points = values.reshape(-1, 3)

    def _axis(self, keyword: str) -> None:
        n, kind = self._words(keyword, 2)[:2]
        self.axes[keyword[0]] = self._array(keyword.upper(), kind, self._count(n, keyword))

    def _triple(self, keyword: str) -> None:
        words = self._words(keyword, 3)[:3]
        try:
            self.triples[keyword] = [float(word) for word in words]
        except ValueError:
            self.cursor.at -= 1
            raise self.cursor.refuse(f"{keyword.upper()} should have three numbers") from None

    def _array(self, what: str, kind: str, n: int) -> Array:
        values = self.cursor.array(what, kind, n)
        if values is None:
            raise self.cursor.refuse(f"{what} should have numbers, and has strings")
        return values

    def _cells(self, keyword: str) -> None:
        n, size = (self._count(word, keyword) for word in self._words(keyword, 2)[:2])
        name = keyword.upper()
        if found := self.cursor.take(_OFFSETS):  # of version 5.1
            offsets = self._array(f"OFFSETS of {name}", found[1].decode("latin-1"), n)
            found = self.cursor.take(_CONNECTIVITY)
            if not found:
                raise self.cursor.refuse(f"{name} has no CONNECTIVITY")
            what, kind = f"CONNECTIVITY of {name}", found[1].decode("latin-1")
            vertices = self._array(what, kind, size)
            self.cells[keyword] = vertices, offsets if n else np.zeros(1, np.int64)
        elif n or size:
            stream = self._array(name, "int", size)
            self.cells[keyword] = _split(name, stream, n)

    def _types(self, keyword: str) -> None:
        n = self._count(self._words(keyword, 1)[0], keyword)
        self.types = self._array("CELL_TYPES", "int", n)

    # Arrays of points and cells.

    def _arrays_of(self, keyword: str) -> None:
        self.counts[keyword] = self._count(self._words(keyword, 1)[0], keyword)
        self.target = keyword

    @property
    def _n_rows(self) -> int:
        if not self.target:
            raise self.cursor.refuse("an array comes before POINT_DATA and CELL_DATA,")
        return self.counts[self.target]

    def _add(self, name: str, kind: str, width: int) -> None:
        """Read an array that has a row for each point or cell."""
        values = self._kept(name, kind, self._n_rows, width)
        if values is not None:
            self._put(name, values, width)

    def _kept(self, name: str, kind: str, n: int, width: int) -> Array | None:
        """Read an array of n rows; what cannot be kept is named."""
        in_part = kind.lower() == BIT and width > 1 and self.cursor.binary
        # of bits, VTK writes one a row, whatever the width
        values = self.cursor.array(name, kind, n if in_part else n * width)
        if in_part:
            self.dropped.append(f"the bits {name}, of which the file has a part")
        elif values is None:
            self.dropped.append(f"the strings {name}")
        return None if in_part else values

    def _put(self, name: str, values: Array, width: int) -> None:
        rows = values if width == 1 else values.reshape(-1, max(width, 1))
        if self.target:
            keep(self.arrays[self.target], name, rows, self._n_rows, self.dropped)
        else:  # of the data set as a whole
            keep(self.fields, name, rows, len(rows), self.dropped)

    def _attribute(self, keyword: str) -> None:
        word, kind = self._words(keyword, 2)[:2]
        self._add(name_of(word), kind, _WIDTHS[keyword])
        if keyword == "global_ids" and self.target == "point_data":
            self.ids = name_of(word)

    def _scalars(self, keyword: str) -> None:
        word, kind, *width = self._words(keyword, 2)
        self.cursor.take(_COLOURS)  # which table of colours, says nothing of the values
        self._add(name_of(word), kind, self._count(width[0], keyword) if width else 1)

    def _texture(self, keyword: str) -> None:
        word, width, kind = self._words(keyword, 3)[:3]
        self._add(name_of(word), kind, self._count(width, keyword))

    def _colours(self, keyword: str) -> None:
        """Colours are bytes, in texts numbers from 0 to 1."""
        word, width = self._words(keyword, 2)[:2]
        n, name = self._count(width, keyword) * self._n_rows, name_of(word)
        values = self._array(name, "unsigned_char" if self.cursor.binary else "float", n)
        if values.dtype.kind == "f" and ((values >= 0) & (values <= 1)).all():
            values = (values * 255 + 0.5).astype(np.uint8)
        self._put(name, values, int(width))

    def _lookup_table(self, keyword: str) -> None:
        name, n = self._words(keyword, 2)[:2]
        kind = "unsigned_char" if self.cursor.binary else "float"
        self._array(f"the lookup table {name}", kind, 4 * self._count(n, keyword))
        self.dropped.append(f"the lookup table {name}")

    def _field(self, keyword: str) -> None:
        _, n = self._words(keyword, 2)[:2]
        for _ in range(self._count(n, keyword)):
            word = self.cursor.word()
            while word.lower() == "metadata":  # of the array before
                self.cursor.past_block()
                word = self.cursor.word()
            if word == "NULL_ARRAY":
                self.cursor.line()
                continue
            if not word:
                raise self.cursor.refuse(f"truncated: FIELD has fewer arrays than its {n},")
            self._array_of_field(name_of(word))

    def _array_of_field(self, name: str) -> None:
        width, n, kind = self._words(f"the array {name}", 3)[:3]
        counts = [self._count(count, f"the array {name}") for count in (width, n)]
        values = self._kept(name, kind, counts[1], counts[0])
        if values is not None:
            self._put(name, values, counts[0])

    # What all of it makes.

    def dataset(self) -> Dataset:
        """Put the sections together.

        Raises
        ------
        UnreadableError
            One of them is missing, or they do not agree on numbers of points and cells.
        """
        if not self.kind:
            raise UnreadableError("there is no DATASET in it")
        make = {_UNSTRUCTURED: self._unstructured, _POLYDATA: self._surface}
        points, cells = make.get(self.kind, self._grid)()
        for keyword, n in (("point_data", len(points)), ("cell_data", len(cells.types))):
            said = self.counts.get(keyword, n)
            if said != n:
                raise UnreadableError(f"{keyword.upper()} has {said} rows, and there are {n}")
        point_data, cell_data = self.arrays.values()
        return Dataset(points, cells, point_data, cell_data, self.ids)

    def _points_there(self) -> Array:
        if self.points is None:
            raise UnreadableError("there are no POINTS in it")
        return self.points

    def _unstructured(self) -> tuple[Array, Cells]:
        points = self._points_there()
        vertices, offsets = self.cells.get("cells", NO_CELLS)
        if self.types is None and len(offsets) > 1:
            raise UnreadableError("truncated: there are no CELL_TYPES in it")
        types = np.empty(0, np.uint8) if self.types is None else self.types
        return points, checked(vertices, offsets, types)

    def _surface(self) -> tuple[Array, Cells]:
        points = self._points_there()
        return points, surface([self.cells.get(name, NO_CELLS) for name in SURFACE])

    def _dimensions(self) -> grids.Dimensions:
        if "dimensions" not in self.triples:
            raise UnreadableError("there are no DIMENSIONS in it")
        x, y, z = self.triples["dimensions"]
        if not all(0 <= n < 2**31 and n == int(n) for n in (x, y, z)):
            raise UnreadableError("its DIMENSIONS are no numbers of points")
        return int(x), int(y), int(z)

    def _grid(self) -> tuple[Array, Cells]:
        dimensions = self._dimensions()
        has_arrays = any(self.arrays.values()) or self.kind == _GRID
        if has_arrays:
            self._require_agreement(dimensions)
        grids.require_bounded(dimensions, has_arrays)
        return self._grid_points(dimensions), grids.cells_of(dimensions)

    def _require_agreement(self, dimensions: grids.Dimensions) -> None:
        """Compare the number of points with the arrays before a grid of that size is made."""
        n = grids.n_points(dimensions)
        if self.kind == _GRID and len(self._points_there()) != n:
            raise UnreadableError(
                f"its DIMENSIONS make {n} points, and it has {len(self._points_there())}"
            )
        for keyword, count in (("point_data", n), ("cell_data", grids.n_cells(dimensions))):
            if self.arrays[keyword] and self.counts[keyword] != count:
                raise UnreadableError(
                    f"{keyword.upper()} has {self.counts[keyword]} rows, and there are {count}"
                )

    def _grid_points(self, dimensions: grids.Dimensions) -> Array:
        if self.kind == _GRID:
            return self._points_there()
        if self.kind == _RECTILINEAR:
            axes = [self.axes.get(axis, np.zeros(1)) for axis in "xyz"]
            if tuple(map(len, axes)) != dimensions:
                lengths = " x ".join(str(len(axis)) for axis in axes)
                raise UnreadableError(f"its coordinates are {lengths}, and not as its DIMENSIONS")
            return grids.product(axes)
        steps = self.triples.get("spacing", self.triples.get("aspect_ratio", [1.0, 1.0, 1.0]))
        origin = np.array(self.triples.get("origin", [0.0, 0.0, 0.0]))
        return grids.image((0, 0, 0), dimensions, origin, np.array(steps), np.eye(3))


def _said(keyword: str) -> str:
    """A keyword as files mostly have it; an array by its own name."""
    return keyword if " " in keyword else keyword.upper()


def _split(name: str, stream: Array, n: int) -> tuple[Array, Array]:
    """Take the counts out of a row of cells, each of which says how many vertices follow.

    Returns
    -------
    connectivity, offsets : as in `Cells`
    """
    width = len(stream) // n if n else 0
    if n and width * n == len(stream):  # as where all are of one type
        table = stream.reshape(n, width)
        if (table[:, 0] == width - 1).all():
            return table[:, 1:].ravel(), np.arange(n + 1) * (width - 1)
    at, starts, values = 0, [], stream.tolist()
    for _ in range(n):
        if at >= len(values) or values[at] < 0:
            break
        starts.append(at)
        at += values[at] + 1
    if len(starts) < n or at != len(values):
        raise UnreadableError(
            f"{name} should have {n} cells in {len(values)} numbers: "
            f"their counts make {len(starts)} cells in {at} numbers"
        )
    counted = np.ones(len(values), bool)
    counted[starts] = False
    sizes = stream[starts].astype(np.int64)
    return stream[counted], np.append(0, np.cumsum(sizes))
