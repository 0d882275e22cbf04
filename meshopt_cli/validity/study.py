"""A mesh under examination, as far as it is a matter of arrays: sound cells, facets, the plane."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..cells import SIMPLICES, Family, dimension_of, family_of
from ..mesh.adjacency import row_ids
from ..mesh.facets import CellSet, FacetSet, facets_of, joined
from ..mesh.model import Array, Block, Mesh, top_blocks
from ..mesh.plane import InPlane, in_plane, precision_of
from ..mesh.sizes import contents

TOUCH = 1e-7  # a vertex nearer to a facet than this fraction of its longest edge lies on it
MANY = 100_000  # cells from which on compiled code is worth its start


def n_corners(block: Block) -> int:
    """How many vertices of its cells are corners; all of them in types not known."""
    family = family_of(block.type)
    return np.shape(block.cells)[-1] if family is None else family.n_corners


class Study:
    """A mesh under examination: what there is to know of it before any rule is looked at.

    Cells are numbered through all blocks. "Sound" cells have existing, different vertices
    with finite coordinates; only those of the top dimension are looked at by most rules.
    Coordinates are scaled by a power of two, which no rounding goes with.

    Parameters
    ----------
    mesh : Mesh
    tolerance : float, optional
        Points nearer than this part of the extent of the mesh coincide, and a vertex nearer to
        a facet than this part of its longest edge lies on it. Left out, both follow from the
        precision of the coordinates.
    """

    def __init__(self, mesh: Mesh, tolerance: float | None = None) -> None:
        self.mesh = mesh
        self.tolerance = tolerance
        self.touch = TOUCH if tolerance is None else tolerance
        raw = np.asarray(mesh.points)
        self.n_points = len(raw)
        self.eps = precision_of(raw)
        points = np.zeros((self.n_points, 3))
        columns = min(raw.shape[1], 3) if raw.ndim == 2 else 0
        points[:, :columns] = raw[:, :columns] if columns else 0
        self.in_two = columns == 2
        self.finite: Array = np.logical_and.reduce(np.isfinite(points), axis=1)
        points[~self.finite] = 0.0
        largest = np.abs(points[self.used]).max(initial=0.0)
        # A stray point far away must not spoil the scale of all others.
        points = np.clip(points, -2 * largest, 2 * largest) if largest else points
        self.exponent = int(np.frexp(largest)[1])
        self.points = np.ldexp(points, -self.exponent)
        # Of the coordinates as the file has them, with what subtracting them adds.
        self.noise = 4 * self.eps * np.abs(self.points).max(axis=1, initial=0.0)
        self.offsets = np.cumsum([0] + [len(block.cells) for block in mesh.blocks])
        self.n_cells = int(self.offsets[-1])

    @cached_property
    def dimension(self) -> int:
        """Greatest dimension of the cells, -1 if there are none."""
        families = (family_of(b.type) for b in self.mesh.blocks if len(b.cells))
        return max((family.dimension for family in families if family), default=-1)

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
        for family, cells, numbers in self.blocks_of(self.dimension):
            result[numbers] = has_repeated(cells[:, : family.n_corners])
        return result

    @cached_property
    def used(self) -> Array:
        """Which points are vertices of a cell; a mere vertex counts where there is nothing else."""
        used = np.zeros(self.n_points, dtype=bool)
        for block in self.mesh.blocks:
            if block.type != SIMPLICES[0] or self.dimension == 0:
                rows = np.asarray(block.cells).ravel()
                used[rows[(rows >= 0) & (rows < self.n_points)]] = True
        return used

    @cached_property
    def sound_sets(self) -> list[CellSet]:
        """The sound cells of the top dimension, family by family, with the points of the file."""
        parts: dict[str, list[tuple[Array, Array]]] = {}
        for family, cells, all_numbers in self.blocks_of(self.dimension):
            sound = ~(self.out_of_range[all_numbers] | self.repeated[all_numbers])
            numbers, corners = all_numbers[sound], cells[sound, : family.n_corners]
            if not self.finite.all():
                sound = self.finite[corners].all(axis=1)
                numbers, corners = numbers[sound], corners[sound]
            parts.setdefault(family.name, []).append((corners, numbers))
        return [CellSet(family, *joined(rows)) for family, rows in parts.items()]

    @cached_property
    def cell_sets(self) -> list[CellSet]:
        """The sound cells that the rules look at."""
        return self.sound_sets

    def blocks_of(self, dimension: int) -> list[tuple[Family, Array, Array]]:
        """Family, cells and numbers of the blocks of one dimension; none of mere vertices."""
        found = []
        for block, first in zip(self.mesh.blocks, self.offsets, strict=False):
            family, cells = family_of(block.type), np.asarray(block.cells)
            if family is None or family.dimension != dimension or dimension < 1:
                continue
            if np.shape(cells)[-1] >= family.n_corners:
                found.append((family, cells, np.arange(first, first + len(cells))))
        return found

    @cached_property
    def facet_sets(self) -> list[FacetSet]:
        """Facets of the sound cells: edges in a mesh of dimension 2, faces in one of 3."""
        return facets_of(self.cell_sets, self.n_points)

    @cached_property
    def is_whole(self) -> bool:
        """Whether all cells of the top dimension are sound, of types whose facets are known."""
        n_sound = sum(len(group.numbers) for group in self.cell_sets)
        n_top = sum(len(b.cells) for b in top_blocks(self.mesh) if dimension_of(b.type) >= 2)
        return n_sound == n_top

    @cached_property
    def distinct_sets(self) -> list[CellSet]:
        """The sound cells without those that repeat an earlier one."""
        later = self.duplicates[0]
        if not len(later):
            return self.cell_sets
        kept = [(group, ~np.isin(group.numbers, later)) for group in self.cell_sets]
        return [CellSet(g.family, g.cells[mask], g.numbers[mask]) for g, mask in kept]

    @cached_property
    def distinct_facets(self) -> list[FacetSet]:
        """Facets of the cells that repeat no other."""
        if self.distinct_sets is self.cell_sets:
            return self.facet_sets
        return facets_of(self.distinct_sets, self.n_points)

    @cached_property
    def plane(self) -> InPlane | None:
        """The points in the plane of a planar mesh; None if it is not planar."""
        sets = [group for group in self.cell_sets if len(group.cells)]
        if self.dimension != 2 or not sets:
            return None
        if self.in_two:
            return InPlane(self.points[:, :2], self.noise, 2)
        return in_plane(self.points, self.noise, sets, self.eps)

    @cached_property
    def may_branch(self) -> bool:
        """Whether it is a surface in space, in which more than two faces may meet in an edge."""
        return self.dimension == 2 and self.plane is None

    @cached_property
    def flat_points(self) -> Array:
        """Points that the planar measures can work on: in the plane with z = 0, (np, 3)."""
        if self.plane is None:
            return self.points
        return np.column_stack([self.plane[0], np.zeros(self.n_points)])

    @cached_property
    def duplicates(self) -> tuple[Array, Array]:
        """Numbers of the cells that repeat an earlier one, and of that one."""
        return duplicates_in(self.cell_sets, self.n_points)

    @cached_property
    def centred(self) -> Array:
        """Points as seen from their middle, in the plane of a planar mesh."""
        points = self.points if self.plane is None else self.plane[0]
        return points - points[self.used].mean(axis=0) if self.used.any() else points

    @cached_property
    def contents(self) -> list[Array]:
        """Signed volume, or area in the plane, of the cells of each of `distinct_sets`."""
        if self.dimension < 2:
            return []
        return [contents(self.centred, g.cells, g.family) for g in self.distinct_sets]

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


def has_repeated(cells: Array) -> Array:
    """Which rows of vertices, (n, k), have one vertex twice."""
    columns = [np.ascontiguousarray(column) for column in cells.T]
    result = np.zeros(len(cells), dtype=bool)
    for i, column in enumerate(columns):
        for other in columns[:i]:
            result |= column == other
    return result


def duplicates_in(cell_sets: list[CellSet], n_points: int) -> tuple[Array, Array]:
    """Numbers of the cells with the vertices of an earlier one of their family, and of that one."""
    later, earlier = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for group in cell_sets:
        rows = _in_doubt(group.cells)
        ids = row_ids(group.cells[rows], n_points)
        numbers = group.numbers[rows]
        _, first, inverse = np.unique(ids, return_index=True, return_inverse=True)
        again = np.flatnonzero(first[inverse] != np.arange(len(ids)))
        later.append(numbers[again])
        earlier.append(numbers[first[inverse[again]]])
    numbers = np.concatenate(later)
    order = np.argsort(numbers)
    return numbers[order], np.concatenate(earlier)[order]


def _in_doubt(cells: Array) -> Array:
    """Rows of cells that may have the same vertices as another, by a sum that forgets order."""
    mixed = cells.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= mixed >> np.uint64(29)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    total = mixed.sum(axis=1)
    ordered = np.sort(total)
    twice = ordered[1:][ordered[1:] == ordered[:-1]]
    return np.flatnonzero(np.isin(total, twice)) if len(twice) else np.empty(0, np.int64)
