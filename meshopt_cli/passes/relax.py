"""relax: vertex degrees nearer to the best (18.4.2, Remark 18.15)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..blocks.turns import Reach
from ..kernels.accept import is_accepted
from ..kernels.operators import relocate
from ..kernels.operators.collapse import Collapsing, sweep_collapse
from ..kernels.operators.relax import sweep_relax
from ..kernels.operators.swap import Swapping
from ..kernels.shape.angles import angle_sums
from ..kernels.types import Verdict
from ..mesh import degrees
from ..work.kinds import FACES, SIMPLICES
from ..work.session import Workspace
from .apart import apart
from .base import Operator, option
from .collapse import merge_faces
from .run import Run, Work, faces_of
from .smooth import RELAXATION

if TYPE_CHECKING:
    from ..work.face_work import FaceWork

Array = np.ndarray

# Of the squares of what degrees are off, in faces.
LEAST_GAIN = 1.0


def target_degrees(work: Workspace) -> Array:
    """The degree each vertex should have, (np,) float64: see `degrees.target_degrees`."""
    angle = np.zeros(len(work.mesh.points))
    angle_sums(work.mesh.points, work.corners(work.living()), angle)
    # An interface ends nothing: there are cells all around its vertices.
    rim = work.facets_at(outer=True)
    return degrees.target_degrees(work.dimension, angle, rim, degrees.FULL[work.dimension])


@dataclass(frozen=True)
class Relax(Operator):
    """Bring degrees nearer to 6 (triangles), 4 (quads) or 12 (tetrahedra)."""

    name: ClassVar[str] = "relax"
    summary: ClassVar[str] = "brings vertex degrees nearer to 6, 4 of quads, or 12 (18.4.2)"
    kernels: ClassVar[tuple[str, ...]] = ("relax", "collapse", "relocation")
    works_on: ClassVar[tuple[str, ...]] = (SIMPLICES, FACES)

    accept: str = option(
        "floor", "as in swap; here quality may fall while degrees gain", choices=("floor", "strict")
    )
    least_quality: float = option(
        0.3, "least quality 1/Q of a patch; one that is worse may not get worse still",
        least=0.0, most=1.0,
    )  # fmt: skip
    max_growth: float = option(
        1.2, "as in collapse, for vertices with far too few neighbours", least=0.0, most=1e3
    )

    def sweep(self, work: Work, run: Run) -> None:
        if isinstance(work, Workspace):
            self._collapse(work, run)
            self._swap(work, run)
        else:
            self._merge_faces(faces_of(work), run)
            self._swap_faces(faces_of(work), run)
        self._relocate(work, run)

    def _collapse(self, work: Workspace, run: Run) -> None:
        """Remove internal vertices of degree 3 (plane) or 4 (space): nothing else raises it."""
        rows = work.living()
        cells = work.corners(rows)
        poor = (work.degrees() == work.dimension + 1) & ~work.mesh.fixed
        where, corner = np.nonzero(poor[cells])
        order = np.column_stack([rows[where], cells[where, corner]])
        how = Collapsing(self.rule, self.least_quality, self.max_growth, False)
        work.next_sweep()
        run.visit(work, order, sweep_collapse, how, len(poor))

    def _swap(self, work: Workspace, run: Run) -> None:
        degree = work.degrees().astype(np.float64)
        target = target_degrees(work)
        since = work.since((self, "shells"))
        how = Swapping(self.rule, self.least_quality, False, since)
        rows, quality = work.changed_cells(since, self.limit)
        order = self.ordered(work, rows, quality)
        run.visit(work, order, sweep_relax, how, degree, target)

    def _relocate(self, work: Work, run: Run) -> None:
        """Let the vertices settle where the new degrees draw them."""
        how = relocate.Relocation(
            relocate.QUALITY,
            relocate.DEGRADATION,
            RELAXATION[work.dimension],
            self.rule,
            self.least_quality,
            self.limit,
        )
        vertices, worst = work.changed_vertices(work.since((self, "balls")), self.limit)
        order = self.ordered(work, vertices, worst)
        run.visit(work, order, work.relocation, how, reach=Reach.BALLS)

    def _merge_faces(self, work: FaceWork, run: Run) -> None:
        """Let vertices become one where the degrees around them gain by it, the most first."""
        run.check()
        degree, target = work.degrees()
        found = work.merges(degree != target)
        m = found.meeting
        beside = m.beside.T

        def off(vertices: Array, by: Array | float) -> Array:
            return np.where(vertices < 0, 0.0, (degree[vertices] + by - target[vertices]) ** 2)

        gain = off(m.goes, 0.0) + off(m.onto, 0.0) - off(m.onto, degree[m.goes] - m.loses)
        gain += sum(off(v, 0.0) - off(v, -1.0) for v in beside)
        near = (gain >= LEAST_GAIN) & (found.growth <= self.max_growth)
        chosen = self._of_gain(near, gain, found.before, found.after, found.vertices, len(degree))
        merge_faces(work, run, found, chosen)

    def _swap_faces(self, work: FaceWork, run: Run) -> None:
        """Swap faces where the degrees gain by it, the most first."""
        run.check()
        degree, target = work.degrees()
        found = work.swaps()
        ends = np.concatenate([found.edge, found.other], axis=1)
        # An end of both edges has as many as before.
        shared = found.edge[:, :, None] == found.other[:, None, :]
        by = np.concatenate([-1.0 + shared.any(axis=2), 1.0 - shared.any(axis=1)], axis=1)
        excess = (degree - target)[ends]
        gain = (excess**2 - (excess + by) ** 2).sum(axis=1)
        before, after = found.before.min(axis=1), found.after.min(axis=1)
        near = gain >= LEAST_GAIN
        chosen = self._of_gain(near, gain, before, after, found.vertices, len(degree))
        work.next_sweep()
        if len(chosen):
            work.put(found.rows[chosen].ravel(), found.faces[chosen].reshape(-1, 4))
        run.tally.note("swapped", found.kinds(chosen))
        run.tally.counts[Verdict.APPLIED] += len(chosen)

    def _of_gain(
        self, near: Array, gain: Array, before: Array, after: Array,
        touched: Callable[[int], Array], n: int,
    ) -> Array:  # fmt: skip
        """The changes near that the rule allows and that touch no vertex together."""
        rows = np.flatnonzero(near)
        rows = rows[np.lexsort([-after[rows], -gain[rows]])]
        good = [k for k in rows.tolist()
                if is_accepted(self.rule, self.least_quality, before[k], after[k])]  # fmt: skip
        return apart(good, touched, n)
