"""VTK's types of cells, and what becomes of each: the same with XML and without.

A cell of a type that a `Block` has stays as it is, but for the order of its vertices. Pixels,
voxels, strips and polygons become quads, hexahedra and triangles, and cells with several points
become as many vertices. The others are dropped by name; where one of them, other than a poly-line,
is of the greatest dimension there is no mesh without it, and the file is refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np

from ...cells import FAMILIES, dimension_of
from ...mesh.model import Array, Block
from ..sniff import UnreadableError


class Type(NamedTuple):
    """A type of cell: VTK's name, the type of a Block or "", its dimension, its vertices.

    The number of vertices is 0 where cells of the type differ in it.
    """

    name: str
    type: str
    dimension: int
    n: int


class Cells(NamedTuple):
    """Cells as VTK holds them.

    Attributes
    ----------
    connectivity : (m,) integers
        The vertices of all cells in a row.
    offsets : (n + 1,) int64
        Where the vertices of each cell start, and the last ones end.
    types : (n,) uint8
    """

    connectivity: Array
    offsets: Array
    types: Array


# Number, name and type of the cells that a Block has.
_KEPT = """
1 VERTEX vertex, 3 LINE line, 5 TRIANGLE triangle, 9 QUAD quad, 10 TETRA tetra,
12 HEXAHEDRON hexahedron, 13 WEDGE wedge, 14 PYRAMID pyramid, 15 PENTAGONAL_PRISM penta_prism,
16 HEXAGONAL_PRISM hexa_prism, 21 QUADRATIC_EDGE line3, 22 QUADRATIC_TRIANGLE triangle6,
23 QUADRATIC_QUAD quad8, 24 QUADRATIC_TETRA tetra10, 25 QUADRATIC_HEXAHEDRON hexahedron20,
26 QUADRATIC_WEDGE wedge15, 27 QUADRATIC_PYRAMID pyramid13, 28 BIQUADRATIC_QUAD quad9,
29 TRIQUADRATIC_HEXAHEDRON hexahedron27, 30 QUADRATIC_LINEAR_QUAD quad6,
31 QUADRATIC_LINEAR_WEDGE wedge12, 32 BIQUADRATIC_QUADRATIC_WEDGE wedge18,
33 BIQUADRATIC_QUADRATIC_HEXAHEDRON hexahedron24, 34 BIQUADRATIC_TRIANGLE triangle7,
35 CUBIC_LINE line4"""
# Number, name and dimension of the others.
_OTHERS = """
0 EMPTY_CELL -1, 2 POLY_VERTEX 0, 4 POLY_LINE 1, 6 TRIANGLE_STRIP 2, 7 POLYGON 2, 8 PIXEL 2,
11 VOXEL 3, 36 QUADRATIC_POLYGON 2, 37 TRIQUADRATIC_PYRAMID 3, 41 CONVEX_POINT_SET 3,
42 POLYHEDRON 3, 51 PARAMETRIC_CURVE 1, 52 PARAMETRIC_SURFACE 2, 53 PARAMETRIC_TRI_SURFACE 2,
54 PARAMETRIC_QUAD_SURFACE 2, 55 PARAMETRIC_TETRA_REGION 3, 56 PARAMETRIC_HEX_REGION 3,
60 HIGHER_ORDER_EDGE 1, 61 HIGHER_ORDER_TRIANGLE 2, 62 HIGHER_ORDER_QUAD 2,
63 HIGHER_ORDER_POLYGON 2, 64 HIGHER_ORDER_TETRAHEDRON 3, 65 HIGHER_ORDER_WEDGE 3,
66 HIGHER_ORDER_PYRAMID 3, 67 HIGHER_ORDER_HEXAHEDRON 3"""
# Cells of any order start from two numbers, in this order.
_ANY_ORDER = {"CURVE": "line", "TRIANGLE": "triangle", "QUADRILATERAL": "quad"}
_ANY_ORDER |= {"TETRAHEDRON": "tetra", "HEXAHEDRON": "hexahedron", "WEDGE": "wedge"}
_ANY_ORDER |= {"PYRAMID": "pyramid"}
_N_VERTICES = {"penta_prism": 10, "hexa_prism": 12}

EMPTY, POLY_VERTEX, POLY_LINE, STRIP, POLYGON = 0, 2, 4, 6, 7
_QUAD, _PIXEL, _VOXEL, _HEXAHEDRON, _WEDGE = 9, 8, 11, 12, 13
_PIXELS = {_PIXEL: _QUAD, _VOXEL: _HEXAHEDRON}
# By type, where each vertex of the cell of a Block stands. A Block has the first triangle of a
# wedge turned inwards, VTK's documentation outwards.
ORDER = {_PIXEL: [0, 1, 3, 2], _VOXEL: [0, 1, 3, 2, 4, 5, 7, 6], _WEDGE: [0, 2, 1, 3, 5, 4]}


def _n_vertices(cell_type: str) -> int:
    """Vertices of a type: by its family, or the number at its end."""
    digits = re.sub(r"\D", "", cell_type)
    if digits:
        return int(digits)
    return FAMILIES[cell_type].n_corners if cell_type in FAMILIES else _N_VERTICES[cell_type]


def _types() -> dict[int, Type]:
    table = {}
    for number, name, kept in (row.split() for row in _KEPT.split(",")):
        table[int(number)] = Type(f"VTK_{name}", kept, dimension_of(kept), _n_vertices(kept))
    for number, name, dimension in (row.split() for row in _OTHERS.split(",")):
        n = {"PIXEL": 4, "VOXEL": 8}.get(name, 0)
        table[int(number)] = Type(f"VTK_{name}", "", int(dimension), n)
    for first, kind in ((68, "LAGRANGE"), (75, "BEZIER")):
        for code, (shape, linear) in enumerate(_ANY_ORDER.items(), first):
            table[code] = Type(f"VTK_{kind}_{shape}", "", dimension_of(linear), 0)
    return table


TYPES = _types()
NUMBERS = {row.type: number for number, row in TYPES.items() if row.type}
# Cells of any order that are of first order, by their type and number of vertices: they are
# those of the family, in the order that a Block has.
_FIRST_ORDER = {
    (number, FAMILIES[linear].n_corners): linear
    for first in (68, 75)
    for number, linear in enumerate(_ANY_ORDER.values(), first)
}
# What polygons, poly-lines and the like are by their number of vertices.
_SIMPLE = {(POLYGON, 3): "triangle", (POLYGON, 4): "quad", (POLY_LINE, 2): "line"} | _FIRST_ORDER


def title(number: int) -> str:
    """What messages call a type: "VTK_LAGRANGE_TETRAHEDRON (71)"."""
    if number not in TYPES:
        return f"{number}, which VTK does not have"
    name = TYPES[number].name
    return f"polyline, {name} ({number})" if number == POLY_LINE else f"{name} ({number})"


def counted(n: int, what: str) -> str:
    """A number of cells: "1 hidden cell", "3 hidden cells"."""
    return f"{n} {what}{'s' * (n != 1)}"


class Run(NamedTuple):
    """Cells of one type that stand together: their rows, and the cells they were made of.

    Attributes
    ----------
    type : str
        As in a Block; "" for cells that cannot be in one.
    number : int
        VTK's number of the type.
    rows : (n, k) integers
    source : slice or (n,) int64
        For each row, the cell of the file.
    """

    type: str
    number: int
    rows: Array
    source: slice | Array


def checked(connectivity: Array, offsets: Array, types: Array) -> Cells:
    """Put together what a file says of its cells.

    Raises
    ------
    UnreadableError
        It does not fit together.
    """
    if len(types) and (types.min() < 0 or types.max() > 255):
        raise UnreadableError("its cells have types with numbers that no type has")
    if len(types) != len(offsets) - 1:
        raise UnreadableError(f"it has {len(offsets) - 1} cells, and types of {len(types)}")
    offsets = offsets.astype(np.int64)
    if offsets[0] < 0 or (offsets[1:] < offsets[:-1]).any():
        raise UnreadableError("the offsets of its cells do not ascend")
    if offsets[-1] > len(connectivity):
        raise UnreadableError(
            f"its cells have {offsets[-1]} vertices together, and {len(connectivity)} are there"
        )
    return Cells(connectivity, offsets, types.astype(np.uint8))


def blocks_of(cells: Cells, data: dict[str, Array], dropped: list[str]) -> list[Block]:
    """Make blocks of cells, in their order.

    Parameters
    ----------
    cells : Cells
    data : dict of str to (n, ...) array
        Has a row for each of the cells.
    dropped : list of str
        What stays out is added.

    Raises
    ------
    UnreadableError
        A cell has not as many vertices as its type, or a type that stays out is of the
        greatest dimension.
    """
    runs = list(_runs(cells))
    _leave_out([run for run in runs if not run.type], runs, dropped)
    blocks: list[Block] = []
    n = 0
    for cell_type, group in groupby((r for r in runs if r.type), key=lambda run: run.type):
        alike = list(group)
        rows = [np.asarray(run.rows, np.int64) for run in alike]
        block = Block(cell_type, np.concatenate(rows) if len(rows) > 1 else rows[0])
        source = _joined([run.source for run in alike])
        block.data = {name: values[source] for name, values in data.items()}
        end = n + len(block.cells)
        if not (isinstance(source, slice) and (source.start, source.stop) == (n, end)):
            block.numbers = _numbers(source)
        n = end
        blocks.append(block)
    return blocks


def _joined(sources: list[slice | Array]) -> slice | Array:
    """The cells of several runs, as a slice where they follow each other."""
    slices = [source for source in sources if isinstance(source, slice)]
    follow = all(a.stop == b.start for a, b in pairwise(slices))
    if follow and len(slices) == len(sources):
        return slice(slices[0].start, slices[-1].stop)
    return np.concatenate([_numbers(source) for source in sources])


def _numbers(source: slice | Array) -> Array:
    return np.arange(source.start, source.stop) if isinstance(source, slice) else source


def _leave_out(out: list[Run], runs: list[Run], dropped: list[str]) -> None:
    """Name the cells that stay out, or refuse them."""
    if not out:
        return
    top = max(_dimension(run) for run in runs)
    counts: dict[int, int] = {}
    for run in out:
        if _dimension(run) == top and run.number not in (EMPTY, POLY_LINE):
            raise UnreadableError(
                f"its cells of type {title(run.number)} are not supported: convert them to "
                "triangles, quads, tetrahedra or hexahedra"
            )
        counts[run.number] = counts.get(run.number, 0) + len(run.rows)
    for number, n in counts.items():
        dropped.append(f"{counted(n, 'cell')} of type {title(number)}")


def _dimension(run: Run) -> int:
    if run.type:
        return dimension_of(run.type)
    return TYPES[run.number].dimension if run.number in TYPES else 3


def _runs(cells: Cells) -> Iterator[Run]:
    """Cut cells where their type or their number of vertices changes."""
    sizes = np.diff(cells.offsets)
    changes = (cells.types[1:] != cells.types[:-1]) | (sizes[1:] != sizes[:-1])
    starts = np.append(0, np.flatnonzero(changes) + 1)[: len(cells.types)]
    ends = np.append(starts, len(cells.types))[1:]
    table = (starts, ends, cells.offsets[starts], cells.types[starts], sizes[starts])
    for start, end, at, number, size in zip(*(column.tolist() for column in table), strict=True):
        if number in TYPES and TYPES[number].n not in (0, size):
            raise UnreadableError(
                f"cell {start} is of type {title(number)}, "
                f"and has {size} vertices instead of {TYPES[number].n}"
            )
        rows = cells.connectivity[at : at + (end - start) * size].reshape(end - start, size)
        yield _converted(number, rows, start)


def _converted(number: int, rows: Array, start: int) -> Run:
    """Bring cells of one type, the first of them the cell `start`, into that of a Block."""
    n, size = rows.shape
    whole = slice(start, start + n)
    if number in ORDER:
        rows = rows[:, ORDER[number]]
    if number == POLY_VERTEX:
        return Run("vertex", number, rows.reshape(-1, 1), np.repeat(_numbers(whole), size))
    if number == STRIP and size >= 3:
        return Run("triangle", number, _unrolled(rows), np.repeat(_numbers(whole), size - 2))
    known = TYPES.get(_PIXELS.get(number, number))
    return Run(_SIMPLE.get((number, size), known.type if known else ""), number, rows, whole)


def _unrolled(strips: Array) -> Array:
    """The triangles of strips of the same length: every other one runs backwards in its strip."""
    n, size = strips.shape
    triples = np.lib.stride_tricks.sliding_window_view(strips, 3, axis=1).copy()
    triples[:, 1::2] = triples[:, 1::2, [1, 0, 2]]
    return triples.reshape(n * (size - 2), 3)
