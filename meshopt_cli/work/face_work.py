"""The working state of triangles and quads of a plane, whose connectivity may change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..constraints.model import Constraints
from ..kernels.operators.place import measure_rows
from ..kernels.types import EDITION, Judge
from ..mesh import adjacency, degrees
from ..mesh.adjacency import distinct
from ..mesh.any_cells import AnyCells
from ..mesh.facets import CellSet
from ..mesh.sizes import angles_between
from .cells import CellWork, balls_of
from .faces import Swap, swaps
from .kinds import FACES
from .merges import Merge, meetings, merges

Array = np.ndarray


class FaceWork(CellWork):
    """The working state of faces; rows are cells.

    Attributes
    ----------
    numbers : (nc,) int64
        Number in its source of each cell that is left.
    """

    kind = FACES

    def __init__(
        self, source: AnyCells, judge: Judge, constraints: Constraints | None = None
    ) -> None:
        super().__init__(source, judge, constraints)
        self.numbers = distinct(np.concatenate([group.numbers for group in source.cell_sets]))

    def faces(self) -> Array:
        """Corners of the faces, (nf, 4): the fourth of a triangle is -1."""
        return np.column_stack([self.mesh.cells, self.mesh.fourth])

    def swaps(self) -> Swap:
        """What pairs of faces may become: see `faces.swaps`."""
        return swaps(self.faces(), self.mesh.quality, self._may_meet, self._measured, self._n())

    def merges(self, wanted: Array) -> Merge:
        """What comes of vertices that become one, of which either is wanted: see `merges`."""
        faces, mesh = self.faces(), self.mesh
        found = meetings(faces, mesh.fixed, self._may_meet, self._n(), wanted)
        balls = mesh.ball_start, mesh.ball >> 2
        return merges(found, faces, mesh.points, mesh.quality, balls, self._measured, mesh.single)

    def _n(self) -> int:
        return len(self.mesh.points)

    def _may_meet(self, one: Array, other: Array, edges: Array) -> Array:
        """Which faces are of one region, and not to stay, nor held apart by a declared edge."""
        one, other = self.numbers[one], self.numbers[other]
        region, stays = self.source.region, self.source.stays
        free = (region[one] == region[other]) & ~stays[one] & ~stays[other]
        return free & (adjacency.places_in(self.source.lines, edges, self._n()) < 0)

    def _measured(self, faces: Array, points: Array | None = None) -> Array:
        """q of some faces."""
        quality = np.empty(len(faces))
        rows = self.mesh._replace(
            points=self.mesh.points if points is None else points,
            cells=np.ascontiguousarray(faces[:, :3]), fourth=np.ascontiguousarray(faces[:, 3]),
        )  # fmt: skip
        measure_rows(rows, self.scratch, quality)
        return quality

    # Degrees -------------------------------------------------------------------------

    def edges(self) -> tuple[Array, Array]:
        """The edges, (n, 2), and whether each bounds one face only."""
        faces = self.faces()
        n_corners = np.where(faces[:, 3] < 0, 3, 4)
        row, side = np.nonzero(np.arange(4) < n_corners[:, None])
        ends = np.stack([faces[row, side], faces[row, (side + 1) % n_corners[row]]], axis=1)
        order = np.argsort(adjacency.row_keys(ends, self._n()), kind="stable")
        keys = adjacency.row_keys(ends[order], self._n())
        first = np.flatnonzero(np.diff(keys, prepend=-1))
        return ends[order[first]], np.diff(first, append=len(keys)) == 1

    def degrees(self) -> tuple[Array, Array]:
        """How many edges each vertex has and should have, (np,) float64: see `mesh.degrees`."""
        edges, alone = self.edges()
        n = self._n()
        degree = np.bincount(edges.ravel(), minlength=n).astype(np.float64)
        rim = np.bincount(edges[alone].ravel(), minlength=n)
        faces, points = self.faces(), self.mesh.points
        n_corners = np.where(faces[:, 3] < 0, 3, 4)
        row, side = np.nonzero(np.arange(4) < n_corners[:, None])
        at, after, before = (
            faces[row, (side + k) % n_corners[row]] for k in (0, 1, n_corners[row] - 1)
        )
        angle = np.bincount(
            at, angles_between(points[after] - points[at], points[before] - points[at]), minlength=n
        )
        rows = np.arange(len(faces))
        sets = [
            CellSet(family, faces[rows[is_one], :width], rows[is_one])
            for family, width, is_one in (
                ("triangle", 3, n_corners == 3),
                ("quad", 4, n_corners == 4),
            )
        ]
        return degree, degrees.target_degrees(2, angle, rim, degrees.full_degrees(sets, n))

    # Changing ------------------------------------------------------------------------

    def put(self, rows: Array, faces: Array, gone: Array | None = None) -> None:
        """Put other faces, (n, 4), in the place of some, and take some away."""
        whole = self.faces()
        whole[rows] = faces
        clock = self.mesh.vertex_clock
        clock[faces[faces >= 0]] = self.clock
        if gone is not None:
            kept = np.ones(len(whole), dtype=bool)
            kept[gone] = False
            whole, self.numbers = whole[kept], self.numbers[kept]
            self._first = np.arange(len(whole))
        cells, fourth = np.ascontiguousarray(whole[:, :3]), np.ascontiguousarray(whole[:, 3])
        start, ball = balls_of(cells, fourth, self._n())
        self.n_vertices = int(np.count_nonzero(np.diff(start)))
        self.mesh = self.mesh._replace(
            cells=cells, fourth=fourth, ball_start=start, ball=ball, quality=np.zeros(len(cells)),
            owner=np.arange(len(cells)), shape=np.zeros(len(cells), np.int64),
        )  # fmt: skip
        self.mesh.state[EDITION] += 1
        measure_rows(self.mesh, self.scratch, self.mesh.quality)

    def merge(self, found: Merge, chosen: Array) -> None:
        """Apply some merges, which change no face together."""
        at = np.concatenate([np.arange(found.start[k], found.start[k + 1]) for k in chosen])
        meeting = found.meeting.chosen(chosen)
        self.mesh.points[meeting.onto] = found.place[chosen]
        self.put(found.rows[at], found.faces[at], meeting.gone.ravel())

    def result(self) -> AnyCells:
        """The cells as they are now; those that are gone have no row."""
        faces = self.faces()
        sets = []
        for group in self.source.cell_sets:
            kept = np.isin(group.numbers, self.numbers)
            numbers = group.numbers[kept]
            rows = np.searchsorted(self.numbers, numbers)
            cells = faces[rows, : group.cells.shape[1]]
            sets.append(replace(group, cells=cells, numbers=numbers))
        return replace(self.source, points=self.mesh.points.copy(), cell_sets=sets)


def work_on(source: AnyCells, judge: Judge, told: Constraints | None = None) -> CellWork:
    """The working state of any cells."""
    kind = FaceWork if source.dimension == 2 else CellWork
    return kind(source, judge, told)
