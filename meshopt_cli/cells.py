"""Families of cells: what is known of a triangle, a wedge or a hexahedron before any mesh is read.

`FAMILIES` has one row a family. Local vertices are numbered as meshio and VTK number them. Types
of higher order belong to the family of their corners: "tetra10" is a tetra.

Formats keep what is theirs (codes, other orders of vertices) by the names of this table.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import permutations

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Family:
    """A row of `FAMILIES`.

    Attributes
    ----------
    name : str
        The type of the cells of first order, as meshio spells it.
    plural : str
        What people call several of them.
    dimension : int
    reference : (n_corners, 3) float64
        The ideal cell: all its edges have length 1.
    facets : tuple of (n, w) int64
        Facets by their number of vertices, turned outwards: seen from outside, those of a solid
        run anticlockwise; those of a face run as its outline does. None below dimension 2, where
        facets are points and have no direction.
    edges : (n, 2) int64
        Each once, the lower end first, in order.
    hinges : (n, 2) int64
        Pairs of facets of a solid that have an edge in common, by their place in `facets`.
    corners : (n, dimension + 1) int64
        For each vertex, the apex, itself and its neighbours along the edges: a simplex that is
        positive where the cell is valid. The apex of a pyramid has four edges, and is left out;
        the corners of a simplex are all the simplex itself, which is there once.
    partitions : tuple of (n, dimension + 1) int64
        Ways to divide the cell into positive simplices (Figures 18.1 to 18.4): a quad and the
        base of a pyramid by either diagonal; a wedge into three in all six ways; a hexahedron
        into two wedges of three each, around each of its four long diagonals (here in such a way
        that both see the same on the face between them), and into five in both ways.
    """

    name: str
    plural: str
    dimension: int
    reference: Array
    facets: tuple[Array, ...]
    edges: Array
    hinges: Array
    corners: Array
    partitions: tuple[Array, ...]

    def counted(self, n: int) -> str:
        """So many cells in words: "1 tetrahedron", "3,920 tetrahedra"."""
        one = "tetrahedron" if self.name == "tetra" else self.name
        return f"{n:,} {one if n == 1 else self.plural}"

    @property
    def n_corners(self) -> int:
        return len(self.reference)

    @property
    def is_simplex(self) -> bool:
        return self.n_corners == self.dimension + 1

    @property
    def has_flat_facets(self) -> bool:
        """Whether the facets are simplices, which lie in a plane wherever their vertices are."""
        return all(table.shape[1] == self.dimension for table in self.facets)


def _ring(facet: Iterable[int]) -> list[tuple[int, int]]:
    """The ends of the sides of a facet, in its direction; an edge is its only side."""
    around = list(facet)
    if len(around) == 2:
        return [(around[0], around[1])]
    return list(zip(around, around[1:] + around[:1], strict=True))


def _edges(facets: list[list[int]]) -> list[tuple[int, ...]]:
    return sorted({tuple(sorted(side)) for facet in facets for side in _ring(facet)})


def _hinges(facets: list[list[int]]) -> list[tuple[int, int]]:
    sides = [{frozenset(side) for side in _ring(facet)} for facet in facets]
    return [(i, j) for j in range(len(sides)) for i in range(j) if sides[i] & sides[j]]


def _positive(simplices: Iterable[Iterable[int]], reference: Array) -> Array:
    """Simplices of a reference cell, their last two vertices exchanged where they are negative."""
    rows = np.array([list(simplex) for simplex in simplices], dtype=np.int64)
    d = rows.shape[1] - 1
    edges = reference[rows[:, 1:], :d] - reference[rows[:, :1], :d]
    negative = np.linalg.det(edges) < 0
    rows[negative, -2:] = rows[negative, :-3:-1]
    return rows


def _stairs(low: tuple[int, ...], high: tuple[int, ...]) -> list[tuple[int, ...]]:
    """A wedge in three: each part has some vertices below, and of those above the ones that
    stand over its last, or come later."""
    return [low[: k + 1] + high[k:] for k in range(3)]


def _around_diagonal(reference: Array, first: int) -> list[list[int]]:
    """A hexahedron in six, around its diagonal from a vertex.

    Each part goes from end to end of the diagonal along three edges. Those that set out along
    one of the two faces beside a plane through the diagonal fill a wedge.
    """
    paths = []
    for order in permutations(range(3)):
        place, path = reference[first].copy(), [first]
        for axis in order:
            place[axis] = 1.0 - place[axis]
            path.append(int(np.argmin(np.abs(reference - place).sum(axis=1))))
        paths.append(path)
    return paths


def _five(reference: Array, odd: int) -> list[list[int]]:
    """A hexahedron in five: one on every other vertex, and one at each of the rest."""
    every_other = np.flatnonzero(reference.sum(axis=1) % 2 == odd).tolist()
    apart = np.abs(reference[:, None] - reference).sum(axis=2)
    rest = [v for v in range(len(reference)) if v not in every_other]
    return [every_other, *([v, *np.flatnonzero(apart[v] == 1.0).tolist()] for v in rest)]


def _family(
    name: str,
    plural: str,
    dimension: int,
    reference: list[tuple[float, float, float]],
    facets: list[list[int]],
    corners: list[list[int]] | None = None,
    partitions: Iterable[Iterable[Iterable[int]]] | None = None,
) -> Family:
    """A row of the table, with what follows from its facets; simplices have nothing more."""
    ideal = np.array(reference)
    whole = [list(range(len(reference)))]
    widths = sorted({len(facet) for facet in facets})
    by_width = [[facet for facet in facets if len(facet) == width] for width in widths]
    in_order = [facet for table in by_width for facet in table]
    hinges = _hinges(in_order) if dimension == 3 else []
    edges = _edges(in_order) if facets else [(0, 1)][:dimension]
    return Family(
        name,
        plural,
        dimension,
        ideal,
        tuple(np.array(table, dtype=np.int64) for table in by_width),
        np.array(edges, dtype=np.int64).reshape(-1, 2),
        np.array(hinges, dtype=np.int64).reshape(-1, 2),
        np.array(corners or whole, dtype=np.int64),
        tuple(_positive(parts, ideal) for parts in partitions or [whole]),
    )


_HEIGHT = math.sqrt(3.0) / 2.0  # of a triangle with edges of length 1
_TRIANGLE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, _HEIGHT, 0.0)]
_SQUARE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
_PRISM = [(x, y, z) for z in (0.0, 1.0) for x, y, _ in _TRIANGLE]
_CUBE = [(x, y, z) for z in (0.0, 1.0) for x, y, _ in _SQUARE]
_DIAGONALS = [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]]

FAMILIES: dict[str, Family] = {
    row.name: row
    for row in (
        _family("vertex", "vertices", 0, _TRIANGLE[:1], []),
        _family("line", "lines", 1, _TRIANGLE[:2], []),
        _family("triangle", "triangles", 2, _TRIANGLE, [[1, 2], [2, 0], [0, 1]]),
        _family(
            "quad", "quads", 2, _SQUARE,
            facets=[[0, 1], [1, 2], [2, 3], [3, 0]],
            corners=[[0, 1, 3], [1, 2, 0], [2, 3, 1], [3, 0, 2]],
            partitions=_DIAGONALS,
        ),
        _family(
            "tetra", "tetrahedra", 3,
            [*_TRIANGLE, (0.5, _HEIGHT / 3.0, math.sqrt(2.0 / 3.0))],
            facets=[[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]],
        ),
        _family(
            "pyramid", "pyramids", 3, [*_SQUARE, (0.5, 0.5, math.sqrt(0.5))],
            facets=[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [0, 3, 2, 1]],
            corners=[[0, 1, 3, 4], [1, 2, 0, 4], [2, 3, 1, 4], [3, 0, 2, 4]],
            partitions=[[[*half, 4] for half in halves] for halves in _DIAGONALS],
        ),
        _family(
            "wedge", "wedges", 3, _PRISM,
            facets=[[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
            corners=[[0, 1, 2, 3], [1, 2, 0, 4], [2, 0, 1, 5],
                     [3, 5, 4, 0], [4, 3, 5, 1], [5, 4, 3, 2]],
            partitions=[
                _stairs(low, tuple(v + 3 for v in low)) for low in permutations(range(3))
            ],
        ),
        _family(
            "hexahedron", "hexahedra", 3, _CUBE,
            facets=[[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4],
                    [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
            corners=[[0, 1, 3, 4], [1, 2, 0, 5], [2, 3, 1, 6], [3, 0, 2, 7],
                     [4, 7, 5, 0], [5, 4, 6, 1], [6, 5, 7, 2], [7, 6, 4, 3]],
            partitions=[
                *(_around_diagonal(np.array(_CUBE), first) for first in range(4)),
                *(_five(np.array(_CUBE), odd) for odd in range(2)),
            ],
        ),
    )
}  # fmt: skip

# Of (18.10): Q of the square is 1.
QUAD_ALPHA = math.sqrt(2.0) / 8.0

# The simplex of each dimension.
SIMPLICES = tuple(name for name, family in FAMILIES.items() if family.is_simplex)


def family_of(cell_type: str) -> Family | None:
    """The family of a type of any order: that of a tetra for "tetra10"; None if it is unknown."""
    return FAMILIES.get(cell_type.rstrip("0123456789"))


def dimension_of(cell_type: str) -> int:
    """Dimension of a type of any order; 3 for unknown ones, which then are not overlooked."""
    family = family_of(cell_type)
    return 3 if family is None else family.dimension


def stretch_of(family: str, simplex: Array) -> Array:
    """What makes a simplex of an ideal cell regular without a turn, (d, d).

    Row i says how much of each edge from the first vertex of the simplex its edge i becomes. The
    map is symmetric in space, so that it does not matter which vertex comes first.
    """
    row = FAMILIES[family]
    d = row.dimension
    ideal = _edges_of(row.reference[simplex], d)
    along = np.linalg.inv(ideal) @ _edges_of(FAMILIES[SIMPLICES[d]].reference, d)
    squares, axes = np.linalg.eigh(along @ along.T)
    return ideal @ ((axes * np.sqrt(squares)) @ axes.T) @ np.linalg.inv(ideal)


def _edges_of(corners: Array, d: int) -> Array:
    return (corners[1:] - corners[0])[:, :d]


# Local numbering of the kernels. A cell of dimension d has the vertices 0..d and is positive when
# the last one lies to the left of (above) the others. Facet i is the one opposite vertex i. A
# handle packs a cell and a local number: `4 * cell + local`, in both dimensions. Results depend
# on the order of all rows.

# Facet i of a tetrahedron, turned so that (facet, i) is a positive cell: inwards.
TET_FACETS = np.ascontiguousarray(FAMILIES["tetra"].facets[0][:, [0, 2, 1]])

# Facet i of a triangle, turned so that (facet, i) is a positive cell.
TRI_FACETS = FAMILIES["triangle"].facets[0]

# Edge i j of a tetrahedron with its opposite edge k l, turned so that (i, j, k, l) is positive.
TET_EDGES = _positive(
    [[i, j, *({0, 1, 2, 3} - {i, j})] for i, j in FAMILIES["tetra"].edges.tolist()],
    FAMILIES["tetra"].reference,
)

# Edges of a triangle: the ends of each, and the vertex opposite.
TRI_EDGES = np.column_stack([TRI_FACETS, np.arange(3)])
