"""Reads VTK's files with XML: `.vtu`, `.vtp`, `.vti`, `.vtr`, `.vts`, and those of pieces.

A file has one piece or several; a parallel one (`.pvtu`, ...) names files that have them. All of
them become one mesh.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...mesh.model import Array, Mesh
from ..sniff import Encoding, UnreadableError
from . import grids
from .arrays import Decoder
from .cells import Cells, checked
from .dataset import Dataset, keep, mesh_of
from .pieces import join
from .surface import NO_CELLS, surface
from .tree import Element, parse

_GRIDS = ("ImageData", "RectilinearGrid", "StructuredGrid")
_KINDS = ("UnstructuredGrid", "PolyData", *_GRIDS)
# The sections of cells in PolyData, in the order of `surface.SURFACE`.
_SURFACE = ("Verts", "Lines", "Polys", "Strips")
_PARALLEL = "P"
# Of a field: a few bytes can say that it has any number of equal ones.
MOST_ROWS = 1 << 20


def read(path: Path, data: bytes, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Read a file, with the files of its pieces, and what of them is left out."""
    dropped: list[str] = []
    root, appended = parse(data)
    kind = root.get("type")
    if kind.removeprefix(_PARALLEL) in _KINDS and kind not in _KINDS:
        files = _files_beside(path, root, kind, dropped)
    else:
        files = [_File(data, root, appended, dropped)]
    mesh = mesh_of(join([piece for file in files for piece in file.pieces], dropped), dropped)
    for file in reversed(files):  # of several values, the first counts
        mesh.fields |= file.fields
    return mesh, dropped


def _files_beside(path: Path, root: Element, kind: str, dropped: list[str]) -> list[_File]:
    """The files of pieces that a parallel file names."""
    body = root.first(kind)
    sources = [piece.get("Source") for piece in body.all("Piece")] if body else []
    if not all(sources) or not sources:
        raise UnreadableError("it names no files of pieces")
    files = []
    for source in dict.fromkeys(sources):
        try:
            data = (path.parent / source.replace("\\", "/")).read_bytes()
            part, appended = parse(data)
            if part.get("type") != kind.removeprefix(_PARALLEL):
                raise UnreadableError(f"it has {part.get('type')!r} in it")
            files.append(_File(data, part, appended, dropped))
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise UnreadableError(f"its piece {source} cannot be read: {reason}") from None
        except UnreadableError as error:
            raise UnreadableError(f"its piece {source}: {error}") from None
    return files


class _File:
    """One file: its pieces, and its fields, the arrays of all of it."""

    def __init__(
        self, data: bytes, root: Element, appended: bytes | memoryview, dropped: list[str]
    ):
        self.dropped = dropped
        self.kind = root.get("type")
        if root.tag != "VTKFile" or self.kind not in _KINDS:
            raise UnreadableError(
                f"it has {self.kind[:40] or root.tag[:40]!r} in it: known are {', '.join(_KINDS)}; "
                "of files that only name others, give those"
            )
        self.decoder = Decoder(data, root, appended)
        self.body = root.first(self.kind) or Element(self.kind, {})
        self.fields: dict[str, Array] = {}
        self._read_fields(self.body)
        found = list(self.body.all("Piece"))
        if not found:
            raise UnreadableError(f"there is no Piece of {self.kind} in it")
        self.pieces = [self._piece(piece) for piece in found]

    def _read_fields(self, element: Element) -> None:
        for section in element.all("FieldData"):
            for array in section.all("DataArray", "Array"):
                name = array.get("Name", "without a name")
                n = array.count("NumberOfTuples", "1")
                values = self.decoder.array(array, n) if n <= MOST_ROWS else None
                if values is None:
                    self.dropped.append(f"the field {name}")
                else:
                    self.fields.setdefault(name, values)

    def _piece(self, piece: Element) -> Dataset:
        self._read_fields(piece)
        if self.kind in _GRIDS:
            return self._grid(piece)
        n = piece.count("NumberOfPoints")
        points = self._points(piece, n)
        cells = self._surface(piece) if self.kind == "PolyData" else self._cells(piece)
        return self._with_arrays(piece, points, cells)

    def _with_arrays(self, piece: Element, points: Array, cells: Cells) -> Dataset:
        point_data = self._arrays(piece, "PointData", len(points))
        cell_data = self._arrays(piece, "CellData", len(cells.types))
        section = piece.first("PointData")
        return Dataset(
            points, cells, point_data, cell_data, section.get("GlobalIds") if section else ""
        )

    def _arrays(self, piece: Element, tag: str, n: int) -> dict[str, Array]:
        arrays: dict[str, Array] = {}
        section = piece.first(tag)
        for element in section.all("DataArray", "Array") if section else ():
            name = element.get("Name", "without a name")
            values = self.decoder.array(element, n)
            if values is None:
                self.dropped.append(f"the strings {name}")
            else:
                keep(arrays, name, values, n, self.dropped)
        return arrays

    def _points(self, piece: Element, n: int) -> Array:
        section = piece.first("Points")
        element = section.first("DataArray") if section else None
        if element is None:
            if n:
                raise UnreadableError("there are no Points in it")
            return np.empty((0, 3))
        for name, value in (("NumberOfComponents", "3"), ("Name", "Points")):
            element.attributes[name] = element.get(name) or value
        points = self._numbers(element, n, n)
        if points.shape[1:] != (3,):
            raise UnreadableError("its points do not have three coordinates")
        return points

    def _numbers(self, element: Element, n: int | None, distinct: int = 0) -> Array:
        values = self.decoder.array(element, n, distinct)
        if values is None:
            raise UnreadableError(f"the array {element.get('Name')} has strings, no numbers")
        return values

    def _cells(self, piece: Element) -> Cells:
        n = piece.count("NumberOfCells")
        section = piece.first("Cells")
        vertices, offsets = self._lists(section, "Cells", n)
        types = self._named(section, "types")
        if types is None:
            if n:
                raise UnreadableError("there are no types of Cells in it")
            return Cells(*NO_CELLS, np.empty(0, np.uint8))
        return checked(vertices, offsets, self._numbers(types, n))

    def _surface(self, piece: Element) -> Cells:
        return surface(
            [
                self._lists(piece.first(tag), tag, piece.count(f"NumberOf{tag}", "0"))
                for tag in _SURFACE
            ]
        )

    def _named(self, section: Element | None, name: str) -> Element | None:
        found = section.all("DataArray") if section else ()
        return next((e for e in found if e.get("Name").lower() == name), None)

    def _lists(self, section: Element | None, tag: str, n: int) -> tuple[Array, Array]:
        """Connectivity and offsets of a section of n cells."""
        if not n:
            return NO_CELLS
        vertices, ends = (self._named(section, name) for name in ("connectivity", "offsets"))
        if vertices is None or ends is None:
            raise UnreadableError(f"{tag} has no connectivity, or no offsets")
        connectivity = self._numbers(vertices, None, n).ravel()
        return connectivity, np.append(0, self._numbers(ends, n).astype(np.int64))

    def _grid(self, piece: Element) -> Dataset:
        extent = piece.get("Extent") or self.body.get("WholeExtent")
        bounds = Element("Piece", {"Extent": extent}).numbers("Extent", "", 6)
        if not all(abs(bound) < 2**31 and bound == int(bound) for bound in bounds):
            raise UnreadableError("the Extent of its grid is not of whole numbers")
        x, y, z = (int(low) for low in bounds[::2])
        n = [max(int(high - low) + 1, 0) for low, high in zip(*[iter(bounds)] * 2, strict=True)]
        dimensions = (n[0], n[1], n[2])
        point_data = self._arrays(piece, "PointData", grids.n_points(dimensions))
        cell_data = self._arrays(piece, "CellData", grids.n_cells(dimensions))
        if self.kind == "StructuredGrid":
            points = self._points(piece, grids.n_points(dimensions))
        else:
            grids.require_bounded(dimensions, bool(point_data or cell_data))
            points = self._grid_points(piece, (x, y, z), dimensions)
        section = piece.first("PointData")
        ids = section.get("GlobalIds") if section else ""
        return Dataset(points, grids.cells_of(dimensions), point_data, cell_data, ids)

    def _grid_points(
        self, piece: Element, first: tuple[int, int, int], dimensions: grids.Dimensions
    ) -> Array:
        if self.kind == "RectilinearGrid":
            section = piece.first("Coordinates")
            found = list(section.all("DataArray")) if section else []
            if len(found) != 3:
                raise UnreadableError(f"its grid has {len(found)} rows of coordinates, not 3")
            axes = zip(found, dimensions, strict=True)
            return grids.product([self._numbers(element, n) for element, n in axes])
        origin = np.array(self.body.numbers("Origin", "0 0 0", 3))
        spacing = np.array(self.body.numbers("Spacing", "1 1 1", 3))
        direction = self.body.numbers("Direction", "1 0 0 0 1 0 0 0 1", 9)
        return grids.image(first, dimensions, origin, spacing, np.reshape(direction, (3, 3)))
