"""Isoparametric elements: where the nodes of a cell of first or second order are, and what is
interpolated between them.

`ELEMENTS` has one row a type, by the name that a file's cells of it have. Nodes are numbered as
VTK numbers them: corners first, in the order of their family, then middles of edges, of faces and
of the cell. Types of other orders have no row.

Coordinates of the reference cell are those of the unit cube, but for triangles and tetrahedra,
whose corners are the origin and the unit points. A pyramid is the cube with its top drawn
together: (x, y, z) of the pyramid is (a w, b w, 1 - w), and its shape functions, which are
rational in x, y and z, are polynomials in (a, b, w).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from .cells import family_of

Array = np.ndarray

# Corners of each family in reference coordinates: those of a pyramid in (a, b, w).
_SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
_TRIANGLE = [(0, 0), (1, 0), (0, 1)]
_CORNERS: dict[str, Sequence[tuple[int, ...]]] = {
    "triangle": _TRIANGLE,
    "quad": _SQUARE,
    "tetra": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "pyramid": [*((a, b, 1) for a, b in _SQUARE), (0, 0, 0)],
    "wedge": [(x, y, z) for z in (0, 1) for x, y in _TRIANGLE],
    "hexahedron": [(x, y, z) for z in (0, 1) for x, y in _SQUARE],
}
# The reference cell of each family as a product of simplices, by their dimensions.
_FACTORS = {
    "triangle": (2,),
    "quad": (1, 1),
    "tetra": (3,),
    "pyramid": (1, 1, 1),
    "wedge": (2, 1),
    "hexahedron": (1, 1, 1),
}

Powers = list[tuple[int, ...]]


@dataclass(frozen=True)
class Element:
    """A row of `ELEMENTS`.

    Attributes
    ----------
    name : str
        The type, as meshio spells it.
    family : str
    middles : tuple of tuple of int
        The corners that each node beyond the corners is the middle of, in a straight cell.
    powers : (k, d) int64
        The monomials that span the shape functions, by their powers; as many as nodes.
    """

    name: str
    family: str
    middles: tuple[tuple[int, ...], ...]
    powers: Array

    @property
    def n_nodes(self) -> int:
        return len(self.powers)

    @property
    def factors(self) -> tuple[int, ...]:
        """Dimensions of the simplices that the reference cell is the product of."""
        return _FACTORS[self.family]

    @property
    def is_collapsed(self) -> bool:
        """Whether coordinates are (a, b, w), and a whole face of the cube is one node."""
        return self.family == "pyramid"

    @cached_property
    def nodes(self) -> Array:
        """Reference coordinates of the nodes, (k, d) float64."""
        corners = np.array(_CORNERS[self.family], dtype=float)
        if not self.is_collapsed:
            return np.array([*corners, *(corners[list(m)].mean(axis=0) for m in self.middles)])
        # The middle of an edge to the top has the a and b of its lower end.
        middles = [[corners[c] for c in m if corners[c, 2]] for m in self.middles]
        places = [np.mean(lower, axis=0) * [1, 1, len(lower) / len(m)]
                  for lower, m in zip(middles, self.middles, strict=True)]  # fmt: skip
        return np.array([*corners, *places])

    @cached_property
    def _shapes(self) -> Array:
        """Coefficients of the shape functions by monomials, (k, k): one column a node."""
        return np.linalg.inv(_monomials(self.nodes, self.powers))

    def values(self, at: Array) -> Array:
        """Shape functions at (n, d) reference coordinates, (n, k)."""
        return _monomials(at, self.powers) @ self._shapes

    def slopes(self, at: Array) -> Array:
        """Derivatives of the shape functions at (n, d) reference coordinates, (d, n, k).

        Those of a pyramid are by x, y and w, with x and y for a given w: it is by them that its
        Jacobian is defined, and they are polynomials too.
        """
        found = []
        for axis in range(self.powers.shape[1]):
            lower = self.slope_powers(axis)
            found.append(_monomials(at, lower) * self.powers[:, axis] @ self._shapes)
        if self.is_collapsed:
            found[2] = -found[2]  # the top is where w is 0
        return np.array(found)

    def slope_powers(self, axis: int) -> Array:
        """Powers of the monomials of a derivative, (k, d); -1 becomes 0, with the factor 0."""
        lower = self.powers.copy()
        lower[:, axis] -= 1
        if self.is_collapsed and axis < 2:
            lower[:, 2] -= 1  # a = x / w
        return np.maximum(lower, 0)


def _monomials(at: Array, powers: Array) -> Array:
    """Values of monomials at some coordinates, (n, k)."""
    return np.prod(at[:, None, :] ** powers, axis=2)


def _total(dimension: int, order: int) -> Powers:
    """Monomials of a simplex: up to a sum of powers."""
    return [p for p in product(range(order + 1), repeat=dimension) if sum(p) <= order]


def _box(*orders: int) -> Powers:
    """Monomials of a cube: up to a power along each axis."""
    return list(product(*(range(order + 1) for order in orders)))


def _serendipity(dimension: int, *more: tuple[int, ...]) -> Powers:
    """Those of a cube of second order with one square each, and more by name."""
    return [p for p in _box(*[2] * dimension) if p.count(2) <= 1 or p in more]


def _prism(order: int, along: int, top: int | None = None) -> Powers:
    """Those of a triangle times powers along the axis; of order `top` with the highest of them."""
    return [
        (*p, k)
        for k in range(along + 1)
        for p in _total(2, order if top is None or k < along else top)
    ]


def _pyramid(order: int, *without: tuple[int, ...]) -> Powers:
    """Those of a pyramid: a square of some order times the same power of the size there."""
    powers = [p for p in _box(order, order, order) if max(p[:2]) <= p[2]]
    return [p for p in powers if p not in without]


_RING = [(0, 1), (1, 2), (2, 3), (3, 0)]
_SIDES = [(0, 1), (1, 2), (2, 0)]
_UP_TET = [(0, 3), (1, 3), (2, 3)]
_UP_PYRAMID = [(0, 4), (1, 4), (2, 4), (3, 4)]
_UP_WEDGE = [(0, 3), (1, 4), (2, 5)]
_ENDS_WEDGE = [*_SIDES, (3, 4), (4, 5), (5, 3)]
_EDGES_HEX = [*_RING, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
_AROUND_HEX = [(0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7)]
_LIDS_HEX = [(0, 1, 2, 3), (4, 5, 6, 7)]
_FACES_WEDGE = [(0, 1, 3, 4), (1, 2, 4, 5), (2, 0, 5, 3)]
_BASE = [(0, 1, 2, 3)]
_YZ, _XZ = [(0, 2, 2), (1, 2, 2)], [(2, 0, 2), (2, 1, 2)]


def _element(name: str, powers: Powers, *middles: Iterable[tuple[int, ...]]) -> Element:
    family = family_of(name)
    assert family is not None
    rows = tuple(tuple(middle) for part in middles for middle in part)
    return Element(name, family.name, rows, np.array(powers, dtype=np.int64))


ELEMENTS: dict[str, Element] = {
    row.name: row
    for row in (
        _element("triangle", _total(2, 1)),
        _element("quad", _box(1, 1)),
        _element("tetra", _total(3, 1)),
        _element("pyramid", _pyramid(1)),
        _element("wedge", _prism(1, 1)),
        _element("hexahedron", _box(1, 1, 1)),
        _element("triangle6", _total(2, 2), _SIDES),
        _element("quad6", _box(2, 1), [(0, 1), (2, 3)]),
        _element("quad8", _serendipity(2), _RING),
        _element("quad9", _box(2, 2), _RING, _BASE),
        _element("tetra10", _total(3, 2), _SIDES, _UP_TET),
        _element("pyramid13", _pyramid(2, (2, 2, 2)), _RING, _UP_PYRAMID),
        _element("pyramid14", _pyramid(2), _RING, _UP_PYRAMID, _BASE),
        _element("wedge12", _prism(2, 1), _ENDS_WEDGE),
        _element("wedge15", _prism(2, 2, 1), _ENDS_WEDGE, _UP_WEDGE),
        _element("wedge18", _prism(2, 2), _ENDS_WEDGE, _UP_WEDGE, _FACES_WEDGE),
        _element("hexahedron20", _serendipity(3), _EDGES_HEX),
        _element("hexahedron24", _serendipity(3, *_YZ, *_XZ), _EDGES_HEX, _AROUND_HEX),
        _element("hexahedron27", _box(2, 2, 2), _EDGES_HEX, _AROUND_HEX, _LIDS_HEX,
                 [tuple(range(8))]),
    )
}  # fmt: skip


def element_of(cell_type: str, n_nodes: int) -> Element | None:
    """The row of a type, None where it has none or other cells than its name says."""
    row = ELEMENTS.get(cell_type)
    return row if row is not None and row.n_nodes == n_nodes else None
