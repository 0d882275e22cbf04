"""A mesh under examination: what several rules of `check` need, each found once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..adjacency import row_ids
from ..mesh import Array, Block, Mesh
from . import geometry

# Dimension and count of corners of each family of cell types.
FAMILIES = {
    "vertex": (0, 1),
    "line": (1, 2),
    "triangle": (2, 3),
    "quad": (2, 4),
    "tetra": (3, 4),
    "pyramid": (3, 5),
    "wedge": (3, 6),
    "hexahedron": (3, 8),
}


def family_of(block: Block) -> str:
    """Type of the cells of a block without its order: "tetra" for "tetra10"."""
    return block.type.rstrip("0123456789")


def n_corners(block: Block) -> int:
    """How many vertices of its cells are corners; all of them in types not known."""
    return FAMILIES.get(family_of(block), (0, np.shape(block.cells)[-1]))[1]


@dataclass(frozen=True)
class CellSet:
    """Cells of one family by their corners: (n, k) int64, and their (n,) numbers in all."""

    family: str
    cells: Array
    numbers: Array


@dataclass(frozen=True)
class FacetSet:
    """Facets with the same count of vertices, sorted so that equal ones stand together.

    Attributes
    ----------
    rows : (m, w) int64
        Vertices, turned as their cells turn them.
    owners : (m,) int64
        Number of the cell of each.
    order : (m,) int64
        Rows in which equal facets follow each other, first cells first.
    start, count : (r,) int64
        Each run of equal facets is `order[start:start + count]`.
    """

    rows: Array
    owners: Array
    order: Array
    start: Array
    count: Array

    def alone(self) -> Array:
        """Rows of the facets that bound one cell only."""
        return self.order[self.start[self.count == 1]]

    def pairs(self) -> tuple[Array, Array]:
        """Rows of the two facets, wherever exactly two cells meet."""
        start = self.start[self.count == 2]
        return self.order[start], self.order[start + 1]


@dataclass(frozen=True)
class Shape:
    """What the volumes of the cells say: masks over the numbers of all cells."""

    inverted: Array
    partly: Array  # inverted at a corner, but positive on the whole
    flat: Array
    quads: Array  # int64: 0, or 1 + the message of M104
    turned: bool  # the whole mesh has the other orientation


@dataclass(frozen=True)
class Gates:
    """Limits that the user sets; None where there is none.

    Attributes
    ----------
    fail_above : float or None
        Greatest Q allowed.
    measure : str or None
        By which measure; None means the default one.
    """

    fail_above: float | None = None
    measure: str | None = None


NO_GATES = Gates()


class Study:
    """A mesh under examination, with all that several rules need, found once.

    Cells are numbered through all blocks. "Sound" cells have existing, different vertices
    with finite coordinates; only those of the top dimension are looked at by most rules.
    Coordinates are scaled by a power of two, which no rounding goes with.
    """

    def __init__(self, mesh: Mesh, gates: Gates = NO_GATES) -> None:
        self.mesh = mesh
        self.gates = gates
        raw = np.asarray(mesh.points)
        self.n_points = len(raw)
        self.eps = float(np.finfo(raw.dtype if raw.dtype.kind == "f" else float).eps)
        points = np.zeros((self.n_points, 3))
        columns = min(raw.shape[1], 3) if raw.ndim == 2 else 0
        points[:, :columns] = raw[:, :columns] if columns else 0
        self.in_two = columns == 2
        self.finite: Array = np.logical_and.reduce(np.isfinite(points), axis=1)
        points[~self.finite] = 0.0
        largest = np.abs(points[self.used]).max(initial=0.0)
        # A stray point far away must not spoil the scale of all others.
        points = np.clip(points, -2 * largest, 2 * largest) if largest else points
        self.points = np.ldexp(points, -int(np.frexp(largest)[1]))
        # Of the coordinates as the file has them, with what subtracting them adds.
        self.noise = 4 * self.eps * np.abs(self.points).max(axis=1, initial=0.0)
        self.offsets = np.cumsum([0] + [len(block.cells) for block in mesh.blocks])
        self.n_cells = int(self.offsets[-1])

    @cached_property
    def dimension(self) -> int:
        """Greatest dimension of the cells, -1 if there are none."""
        rows = (FAMILIES.get(family_of(b), (-1,))[0] for b in self.mesh.blocks if len(b.cells))
        return max(rows, default=-1)

    @cached_property
    def out_of_range(self) -> Array:
        """Which cells have a vertex that does not exist."""
        result = np.zeros(self.n_cells, dtype=bool)
        for block, first in zip(self.mesh.blocks, self.offsets, strict=False):
            cells = np.asarray(block.cells)
            if cells.size and (cells.min() < 0 or cells.max() >= self.n_points):
                wrong = (cells < 0) | (cells >= self.n_points)
                result[first : first + len(cells)] = wrong.any(axis=1)
        return result

    @cached_property
    def repeated(self) -> Array:
        """Which cells of the top dimension have one vertex twice."""
        result = np.zeros(self.n_cells, dtype=bool)
        for family, cells, numbers in self._top():
            k = FAMILIES[family][1]
            columns = [np.ascontiguousarray(cells[:, i]) for i in range(k)]
            for i in range(k):
                for j in range(i):
                    result[numbers] |= columns[i] == columns[j]
        return result

    @cached_property
    def used(self) -> Array:
        """Which points are vertices of a cell, a mere vertex not counted."""
        used = np.zeros(self.n_points, dtype=bool)
        for block in self.mesh.blocks:
            if family_of(block) != "vertex":
                rows = np.asarray(block.cells).ravel()
                used[rows[(rows >= 0) & (rows < self.n_points)]] = True
        return used

    @cached_property
    def cell_sets(self) -> list[CellSet]:
        """The sound cells of the top dimension, family by family."""
        parts: dict[str, list[tuple[Array, Array]]] = {}
        for family, cells, all_numbers in self._top():
            sound = ~(self.out_of_range[all_numbers] | self.repeated[all_numbers])
            numbers, corners = all_numbers[sound], cells[sound, : FAMILIES[family][1]]
            if not self.finite.all():
                sound = self.finite[corners].all(axis=1)
                numbers, corners = numbers[sound], corners[sound]
            parts.setdefault(family, []).append((corners, numbers))
        return [CellSet(family, *_joined(rows)) for family, rows in parts.items()]

    def _top(self) -> list[tuple[str, Array, Array]]:
        """Family, cells and numbers of the blocks of the top dimension, from 2 on."""
        return [
            (family_of(block), np.asarray(block.cells), np.arange(first, first + len(block.cells)))
            for block, first in zip(self.mesh.blocks, self.offsets, strict=False)
            if self.dimension >= 2
            and FAMILIES.get(family_of(block), (-1,))[0] == self.dimension
            and np.shape(block.cells)[-1] >= n_corners(block)
        ]

    @cached_property
    def facet_sets(self) -> list[FacetSet]:
        """Facets of the sound cells: edges in a mesh of dimension 2, faces in one of 3."""
        parts: dict[int, list[tuple[Array, Array]]] = {}
        for group in self.cell_sets:
            for width, table in geometry.FACETS[group.family].items():
                rows = np.take(group.cells, table, axis=1).reshape(-1, width)
                parts.setdefault(width, []).append((rows, np.repeat(group.numbers, len(table))))
        sets = []
        for lists in parts.values():
            rows, owners = _joined(lists)
            ids = row_ids(rows, self.n_points)
            order = np.argsort(ids, kind="stable")
            ids = ids[order]
            start = np.flatnonzero(np.concatenate([[True], ids[1:] != ids[:-1]])[: len(ids)])
            sets.append(FacetSet(rows, owners, order, start, np.diff(start, append=len(ids))))
        return sets

    @cached_property
    def plane(self) -> tuple[Array, Array, int] | None:
        """Coordinates in the plane of a planar mesh, their noise, the axis it is normal to."""
        used = np.zeros(self.n_points, dtype=bool)
        for group in self.cell_sets:
            used[group.cells.ravel()] = True
        if self.dimension != 2 or not used.any():
            return None
        if self.in_two:
            return self.points[:, :2], self.noise, 2
        points = self.points[used]
        relative = max(1e-6, 100 * self.eps)
        tolerance = relative * np.ptp(points, axis=0).max() + self.noise[used].max()
        plane = geometry.plane_of(points, tolerance)
        if plane is None:
            return None
        axes, normal = plane
        if normal < 0:
            return (self.points - points.mean(axis=0)) @ axes, self.noise, normal
        # How far the plane is from the origin does not matter.
        flat = self.points[:, np.argmax(axes, axis=0)]
        return flat, 4 * self.eps * np.abs(flat).max(axis=1), normal

    @cached_property
    def flat_points(self) -> Array:
        """Points that the planar measures can work on: in the plane with z = 0, (np, 3)."""
        if self.plane is None:
            return self.points
        return np.column_stack([self.plane[0], np.zeros(self.n_points)])

    @cached_property
    def simplices(self) -> list[CellSet]:
        """The sound tetrahedra, or the triangles of a planar mesh."""
        measured = {"tetra"} if self.plane is None else {"triangle"}
        return [one for one in self.cell_sets if one.family in measured]

    @cached_property
    def shape(self) -> Shape:
        """What the volumes, or the areas, of all sound cells say."""
        inverted, partly, flat = np.zeros((3, self.n_cells), dtype=bool)
        quads = np.zeros(self.n_cells, dtype=np.int64)
        shape = Shape(inverted, partly, flat, quads, turned=False)
        if self.dimension == 3:
            return self._shape_of_solids(shape)
        if self.plane is not None:
            return self._shape_in_plane(shape)
        for group in self.cell_sets:
            shape.flat[group.numbers] = geometry.flat_in_space(self.points, self.noise, group.cells)
        return shape

    def _shape_of_solids(self, shape: Shape) -> Shape:
        found = [
            geometry.corner_volumes(self.points, self.noise, group.cells, group.family)
            for group in self.cell_sets
        ]
        total = [np.where(flat, 0, volume).sum(axis=1) for volume, flat in found]
        turned = any((t < 0).any() for t in total) and not any((t > 0).any() for t in total)
        for group, (volume, flat), whole in zip(self.cell_sets, found, total, strict=True):
            sign = -1 if turned else 1
            negative = ((sign * volume < 0) & ~flat).any(axis=1)
            shape.inverted[group.numbers] = negative
            shape.partly[group.numbers] = negative & (sign * whole > 0)
            shape.flat[group.numbers] = flat.any(axis=1) & ~negative
        return replace(shape, turned=turned)

    def _shape_in_plane(self, shape: Shape) -> Shape:
        assert self.plane is not None
        points, noise, normal = self.plane
        found = [geometry.triangle_areas(points, noise, group.cells) for group in self.cell_sets]
        families = {group.family for group in self.cell_sets if len(group.cells)}
        # A plane of triangles may be seen from either side; a quad that runs clockwise in the
        # plane of x and y is negative by definition (Figure 18.5).
        below = sum(float(area.sum()) for area, _ in found) < 0
        sign = -1 if below and not (normal == 2 and "quad" in families) else 1
        for group, (area, flat) in zip(self.cell_sets, found, strict=True):
            n_negative = ((sign * area < 0) & ~flat).sum(axis=1)
            n_positive = ((sign * area > 0) & ~flat).sum(axis=1)
            shape.inverted[group.numbers] = n_negative > n_positive
            shape.flat[group.numbers] = flat.all(axis=1)
            if group.family == "quad":
                shape.quads[group.numbers] = _quad_cases(n_negative, n_positive)
        return shape

    @cached_property
    def duplicates(self) -> tuple[Array, Array]:
        """Numbers of the cells that repeat an earlier one, and of that one."""
        later, earlier = [], []
        for group in self.cell_sets:
            rows = _in_doubt(group.cells)
            ids = row_ids(group.cells[rows], self.n_points)
            numbers = group.numbers[rows]
            _, first, inverse = np.unique(ids, return_index=True, return_inverse=True)
            again = np.flatnonzero(first[inverse] != np.arange(len(ids)))
            later.append(numbers[again])
            earlier.append(numbers[first[inverse[again]]])
        if not later:
            return np.empty(0, np.int64), np.empty(0, np.int64)
        numbers = np.concatenate(later)
        order = np.argsort(numbers)
        return numbers[order], np.concatenate(earlier)[order]

    @cached_property
    def explained(self) -> Array:
        """Mask of the cells whose own shape is found wrong, so that more about them is moot."""
        return self.shape.inverted | self.shape.flat | (self.shape.quads > 0)

    @cached_property
    def disagreeing(self) -> tuple[Array, Array]:
        """Numbers of the cells that run round a common facet in the same direction."""
        ones, others = [], []
        for facets in self.facet_sets:
            one, other = facets.pairs()
            same = geometry.same_direction(facets.rows[one], facets.rows[other])
            ones.append(facets.owners[one[same]])
            others.append(facets.owners[other[same]])
        none = np.empty(0, dtype=np.int64)
        return np.concatenate([none, *ones]), np.concatenate([none, *others])

    @cached_property
    def first_points(self) -> Array:
        """The first point in the same place as each point, itself if there is no other."""
        result = np.arange(self.n_points)
        present = np.flatnonzero(self.finite)
        points = self.points[present]
        if not self.used[present].any():
            return result
        extent = norm_of_extent(self.points[present[self.used[present]]])
        distance = max((1e-12 if self.eps < 1e-10 else 1e-7) * extent, float(self.noise.max()) / 2)
        one, other = geometry.near_pairs(points, distance)
        apart = geometry.norms(points[one] - points[other])
        if apart.any():
            # Fine meshes of wide domains have short edges: coincident means much shorter.
            shortest = self._shortest_edges(np.concatenate([present[one], present[other]]))
            limit = np.minimum(shortest[present[one]], shortest[present[other]]) / 10
            keep = (apart == 0) | (apart <= limit)
            one, other = one[keep], other[keep]
        first = geometry.first_of(len(present), one, other)
        # Stray points in one place are only unused, as long as no cell has a vertex there.
        matters = np.zeros(len(present), dtype=bool)
        matters[first[self.used[present]]] = True
        first = np.where(matters[first], first, np.arange(len(first)))
        result[present] = present[first]
        return result

    def _shortest_edges(self, wanted: Array) -> Array:
        """Least distance of points to a vertex of a cell they are in, infinite for the rest."""
        result = np.full(self.n_points, np.inf)
        is_wanted = np.zeros(self.n_points, dtype=bool)
        is_wanted[wanted] = True
        for group in self.cell_sets:
            cells = group.cells[is_wanted[group.cells].any(axis=1)]
            for i in range(cells.shape[1]):
                for j in range(i):
                    length = geometry.norms(self.points[cells[:, i]] - self.points[cells[:, j]])
                    np.minimum.at(result, cells[:, i], length)
                    np.minimum.at(result, cells[:, j], length)
        return result

    def corners_of(self, numbers: Array) -> Array:
        """Corners of sound cells, (n, 8) int64, -1 where there are fewer."""
        corners = np.full((len(numbers), 8), -1)
        for group in self.cell_sets:
            mine = np.flatnonzero(np.isin(numbers, group.numbers))
            rows = np.searchsorted(group.numbers, numbers[mine])
            corners[mine, : group.cells.shape[1]] = group.cells[rows]
        return corners

    def cells_by(self, numbers: Array) -> Array:
        """Block and row of cells by their numbers, (..., 2); -1 stays -1."""
        block = np.searchsorted(self.offsets, numbers, side="right") - 1
        found = np.stack([block, numbers - self.offsets[block]], axis=-1)
        return np.where(numbers[..., None] < 0, -1, found)


def _joined(parts: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Pairs of arrays, one after the other; the most common single pair is not copied."""
    if len(parts) == 1:
        return parts[0]
    return np.concatenate([one for one, _ in parts]), np.concatenate([two for _, two in parts])


def norm_of_extent(points: Array) -> float:
    """Diagonal of the bounding box."""
    return float(geometry.norms(np.ptp(points, axis=0)))


def _in_doubt(cells: Array) -> Array:
    """Rows of cells that may have the same vertices as another, by a sum that forgets order."""
    mixed = cells.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= mixed >> np.uint64(29)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    total = mixed.sum(axis=1)
    order = np.argsort(total, kind="stable")
    same = np.flatnonzero(np.diff(total[order]) == 0)
    return np.unique(np.concatenate([order[same], order[same + 1]]))


def _quad_cases(n_negative: Array, n_positive: Array) -> Array:
    """0, or 1 + the message of M104, from the signs of the four areas (Figure 18.5)."""
    least = np.minimum(n_negative, n_positive)
    n_zero = 4 - n_negative - n_positive
    crossed = (least == 2) | ((least == 1) & (n_zero == 2))
    degenerate = (least == 0) & (n_zero > 0) & (n_zero < 4)
    return np.select([crossed, least == 1, degenerate], [2, 1, 3], 0)
