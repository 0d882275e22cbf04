"""Where vertices may go that were told where to stay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kernels.guide import LINE, PLANE, SPACE, STAYS, TOLD

Array = np.ndarray

# Sine of the angle within which two directions are the same.
SAME = 1e-6
ROUNDING = 8.0  # so many times the spacing of the coordinates, points may be off by rounding


@dataclass(frozen=True)
class Constraints:
    """Where vertices may go, in the coordinates of what is worked on.

    Attributes
    ----------
    guide : (np, 4) float64
        What each vertex may move along: 0 where it was told nothing, or 1 and the direction of a
        line (of no length: it stays), 2 and the normal of a plane, 3 where only half-spaces bound
        it.
    start : (np + 1,) int64
        Where the half-spaces of each vertex begin.
    limits : (n, 4) float64
        Unit normals and offsets of half-spaces `normal . x >= offset`.
    """

    guide: Array
    start: Array
    limits: Array

    @property
    def told(self) -> Array:
        """Which vertices were told anything, (np,) bool."""
        return self.guide[:, 0] > STAYS

    def of_rows(self, origin: Array) -> Constraints:
        """The same of vertices in another order: row i is vertex `origin[i]`, (n,) int64."""
        count = np.diff(self.start)[origin]
        start = np.zeros(len(origin) + 1, dtype=np.int64)
        np.cumsum(count, out=start[1:])
        rows = np.arange(start[-1]) + np.repeat(self.start[origin] - start[:-1], count)
        return Constraints(self.guide[origin], start, self.limits[rows])

    def guides(self, fixed: Array, sliding: Array | None) -> Array:
        """Guides of the kernels, (np, 6).

        Parameters
        ----------
        fixed : (np,) bool
            Vertices that stay, those of the boundary among them.
        sliding : (np, 4) float64, optional
            What some of these may move along all the same.
        """
        guide = np.zeros((len(self.guide), 6))
        if sliding is not None:
            guide[:, :4] = sliding
        told = np.flatnonzero(self.told & (~fixed | (guide[:, 0] > STAYS)))
        free = told[~fixed[told]]
        guide[free, 0] = SPACE
        found = meet(guide[told, :4], self.guide[told])
        guide[told, :4] = found
        guide[told, 0] += np.where(found[:, 0] > STAYS, TOLD, 0.0)
        told = told[found[:, 0] > STAYS]
        guide[told, 4], guide[told, 5] = self.start[told], self.start[told + 1]
        return guide


def meet(one: Array, other: Array) -> Array:
    """What is in common of lines, planes and all of space through the same points, (n, 4) each."""
    found = one.copy()
    anywhere = one[:, 0] == SPACE
    found[anywhere] = other[anywhere]
    both = np.flatnonzero(~anywhere & (one[:, 0] > STAYS) & (other[:, 0] != SPACE))
    a, b = one[both], other[both]
    across = np.cross(a[:, 1:], b[:, 1:])
    sine = np.linalg.norm(across, axis=1)
    cosine = np.abs(np.einsum("ij,ij->i", a[:, 1:], b[:, 1:]))
    alike = a[:, 0] == b[:, 0]
    within = np.where(alike, sine <= SAME, cosine <= SAME)
    line = np.where((a[:, 0] == LINE)[:, None], a, b)
    result = np.where((within & ~alike)[:, None], line, a)
    crossing = alike & (a[:, 0] == PLANE) & ~within
    result[crossing, 0] = LINE
    result[crossing, 1:] = across[crossing] / sine[crossing, None]
    nothing = ~a[:, 1:].any(axis=1) | ~b[:, 1:].any(axis=1)
    result[nothing | (~within & ~crossing)] = STAYS
    found[both] = result
    return found


def slacks(points: Array, guide: Array, limits: Array) -> tuple[Array, Array]:
    """How far inside its half-spaces each vertex is; negative outside.

    Parameters
    ----------
    guide : (np, 6) float64
        As `Constraints.guides` gives it.

    Returns
    -------
    vertices : (m,) int64
        One for each half-space.
    slack : (m,) float64
    """
    first, stop = guide[:, 4].astype(np.int64), guide[:, 5].astype(np.int64)
    count = stop - first
    vertices = np.repeat(np.arange(len(guide)), count)
    rows = np.arange(len(vertices)) + np.repeat(first - (np.cumsum(count) - count), count)
    slack = np.einsum("ij,ij->i", points[vertices], limits[rows, :3]) - limits[rows, 3]
    return vertices, slack


def noise_of(points: Array, single: bool) -> float:
    """How far points may be off by rounding."""
    precision = float(np.finfo(np.float32 if single else np.float64).eps)
    return ROUNDING * precision * float(np.abs(points).max(initial=0.0))
