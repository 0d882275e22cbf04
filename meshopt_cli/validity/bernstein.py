"""Polynomials over reference cells by their Bernstein coefficients, which bound them.

A reference cell is a product of simplices: a square is that of two segments, a wedge that of a
triangle and a segment. A polynomial of some degree over each is no less than the least of its
coefficients, no more than the greatest, and equals those at the corners. On the parts of a cell
that is divided the bounds are closer, by the square of the size.

Source: A. Johnen, J.-F. Remacle, C. Geuzaine, "Geometrical validity of curvilinear finite
elements", J. Comput. Phys. 233 (2013) 359-372.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, cached_property, reduce
from itertools import product
from math import factorial, prod

import numpy as np

from ..mesh.model import Array

# What the search for a decision may take: patches of one cell, and numbers at a time.
MOST_PATCHES = 4096
MOST_DEPTH = 40
BATCH = 1 << 21

# What is known of a polynomial: that it is above a bound everywhere, that it is not, or neither.
ABOVE, NOT_ABOVE, UNDECIDED = 0, 1, 2


class Basis:
    """Bernstein polynomials over a product of simplices.

    Parameters
    ----------
    factors : tuple of int
        Dimension of each simplex.
    degrees : tuple of int
        Degree over each.
    """

    def __init__(self, factors: tuple[int, ...], degrees: tuple[int, ...]) -> None:
        self._lattices = [_lattice(*pair) for pair in zip(factors, degrees, strict=True)]
        self._inverses = [
            np.linalg.inv(_polynomials(lattice, _places(lattice))) for lattice in self._lattices
        ]
        self.shape = tuple(len(lattice) for lattice in self._lattices)

    @cached_property
    def points(self) -> Array:
        """Where a polynomial is to be known, (n, d): its coefficients follow from its values."""
        places = [_places(lattice)[:, 1:] for lattice in self._lattices]
        return np.array([np.concatenate(rows) for rows in product(*places)])

    @cached_property
    def corners(self) -> Array:
        """Rows of `points`, and of coefficients, that are corners of the cell."""
        ends = [lattice.max(axis=1) == max(lattice.sum(axis=1)) for lattice in self._lattices]
        return np.flatnonzero([all(row) for row in product(*ends)])

    @cached_property
    def weights(self) -> Array:
        """Weights of the values at `points` in the mean of a polynomial, (n,): that of the
        coefficients, since all Bernstein polynomials of a degree have the same integral."""
        return reduce(np.kron, [inverse.mean(axis=0) for inverse in self._inverses])

    def coefficients(self, values: Array) -> Array:
        """Coefficients (m, n) of m polynomials from their values at `points`, (m, n).

        One factor after the other, a small product for each polynomial: large ones would be
        shared among threads, which costs more than it gives where these are busy.
        """
        left, result = len(values), values
        for inverse in self._inverses:
            size = len(inverse)
            right = max(1, values.size // max(1, left * size))
            if right == 1:
                result = result.reshape(len(values), -1, size) @ inverse.T
            else:
                result = inverse @ result.reshape(left, size, right)
            left *= size
        return result.reshape(values.shape)

    @cached_property
    def _parts(self) -> list[Array]:
        """For each factor, the matrices to the coefficients on its parts, (parts, n, n)."""
        return [
            _divisions(lattice, inverse)
            for lattice, inverse in zip(self._lattices, self._inverses, strict=True)
        ]

    def divided(self, coefficients: Array) -> Array:
        """Coefficients (m, n) of m polynomials on the parts of the cell, (m, parts, n)."""
        m = len(coefficients)
        result = coefficients.reshape(m, 1, *self.shape)
        for axis, parts in enumerate(self._parts):
            moved = np.moveaxis(result, axis + 2, -1)
            on_parts = np.stack([moved @ part.T for part in parts], axis=2)
            result = np.moveaxis(on_parts, -1, axis + 3)
            result = result.reshape(m, -1, *self.shape)
        return result.reshape(m, result.shape[1], -1)

    def judge(self, coefficients: Array, bound: Array) -> tuple[Array, Array]:
        """Whether polynomials are above bounds everywhere, by dividing the cell where in doubt.

        Parameters
        ----------
        coefficients : (m, n) float64
        bound : (m,) float64

        Returns
        -------
        verdict : (m,) int64
            `ABOVE`, `NOT_ABOVE`, or `UNDECIDED` where the bound is so nearly touched, along a
            line or a surface, that it would take more than `MOST_PATCHES` patches to decide.
        least : (m,) float64
            The least value that was seen.
        """
        verdict = np.full(len(bound), ABOVE)
        least = coefficients[:, self.corners].min(axis=1)
        stack = [(coefficients, np.arange(len(bound)), 0)]
        while stack:
            patches, owners, depth = stack.pop()
            values = patches[:, self.corners].min(axis=1)
            np.minimum.at(least, owners, values)
            verdict[owners[values <= bound[owners]]] = NOT_ABOVE
            open_ = (patches.min(axis=1) <= bound[owners]) & (verdict[owners] != NOT_ABOVE)
            patches, owners = patches[open_], owners[open_]
            crowd = np.bincount(owners, minlength=1)
            hopeless = (crowd[owners] > MOST_PATCHES) | (depth >= MOST_DEPTH)
            verdict[owners[hopeless]] = UNDECIDED
            patches, owners = patches[~hopeless], owners[~hopeless]
            for part, whose in self._batches(patches, owners):
                finer = self.divided(part)
                stack.append(
                    (finer.reshape(-1, part.shape[1]), np.repeat(whose, finer.shape[1]), depth + 1)
                )
        return verdict, least

    def _batches(self, patches: Array, owners: Array) -> Iterator[tuple[Array, Array]]:
        """Patches in parts that can be divided without much memory, each with whole cells."""
        if not len(owners):
            return
        order = np.argsort(owners, kind="stable")
        patches, owners = patches[order], owners[order]
        grown = patches.shape[1] * prod(len(parts) for parts in self._parts)
        place = np.arange(len(owners)) * grown // BATCH
        first = np.flatnonzero(np.diff(owners, prepend=-1))  # of each cell
        batch = place[first][np.cumsum(np.diff(owners, prepend=owners[0]) > 0)]
        edges = np.flatnonzero(np.diff(batch, prepend=-1)).tolist()
        for start, end in zip(edges, [*edges[1:], len(owners)], strict=True):
            yield patches[start:end], owners[start:end]


@cache
def basis(factors: tuple[int, ...], degrees: tuple[int, ...]) -> Basis:
    """The one basis of its kind: its matrices are made once."""
    return Basis(factors, degrees)


def _lattice(dimension: int, degree: int) -> Array:
    """Exponents of the Bernstein polynomials of a simplex, (n, dimension + 1)."""
    rows = product(range(degree + 1), repeat=dimension)
    return np.array([[degree - sum(row), *row] for row in rows if sum(row) <= degree])


def _places(lattice: Array) -> Array:
    """Where the polynomials of a lattice have their greatest value, in barycentric coordinates."""
    degree = lattice[0].sum()
    if not degree:
        return np.full(lattice.shape, 1.0 / lattice.shape[1])
    return lattice / degree


def _polynomials(lattice: Array, at: Array) -> Array:
    """Bernstein polynomials at barycentric coordinates, (places, n)."""
    degree = int(lattice[0].sum())
    ways = [factorial(degree) // prod(factorial(i) for i in row) for row in lattice.tolist()]
    return np.prod(at[:, None, :] ** lattice, axis=2) * np.array(ways)


def _divisions(lattice: Array, inverse: Array) -> Array:
    """Matrices from the coefficients on a simplex to those on its parts, (parts, n, n)."""
    degree, dimension = int(lattice[0].sum()), lattice.shape[1] - 1
    if not degree:
        return np.ones((1, 1, 1))
    matrices = [
        inverse @ _polynomials(lattice, _places(lattice) @ part) for part in _PARTS[dimension]
    ]
    # Weights of de Casteljau's algorithm at middles: whole multiples of this.
    unit = 2.0**-degree
    return np.round(np.array(matrices) / unit) * unit


def _between(*pairs: str) -> Array:
    """A simplex by middles of edges of another: "01" is that of its corners 0 and 1."""
    n = len(pairs)
    return np.array([(np.eye(n)[int(pair[0])] + np.eye(n)[int(pair[1])]) / 2 for pair in pairs])


# Parts of a simplex, half as large, by the barycentric coordinates of their corners. What is left
# of a tetrahedron without its corners is cut around the line from the middle of 02 to that of 13.
_PARTS = {
    1: [_between("00", "01"), _between("01", "11")],
    2: [
        _between("00", "01", "02"),
        _between("01", "11", "12"),
        _between("02", "12", "22"),
        _between("01", "12", "02"),
    ],
    3: [
        _between("00", "01", "02", "03"),
        _between("01", "11", "12", "13"),
        _between("02", "12", "22", "23"),
        _between("03", "13", "23", "33"),
        _between("02", "13", "01", "12"),
        _between("02", "13", "12", "23"),
        _between("02", "13", "23", "03"),
        _between("02", "13", "03", "01"),
    ],
}
