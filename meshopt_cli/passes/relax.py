"""relax: vertex degrees nearer to the best (18.4.2, Remark 18.15)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..kernels.operators import relocate
from ..kernels.operators.collapse import Collapsing, sweep_collapse
from ..kernels.operators.relax import sweep_relax
from ..kernels.operators.swap import Swapping
from ..kernels.shape.angles import angle_sums
from ..mesh import degrees
from ..work.session import Workspace
from .base import Operator, option
from .run import Run
from .smooth import RELAXATION

Array = np.ndarray


def target_degrees(work: Workspace) -> Array:
    """The degree each vertex should have, (np,) float64: see `degrees.target_degrees`."""
    angle = np.zeros(len(work.mesh.points))
    angle_sums(work.mesh.points, work.corners(work.living()), angle)
    # An interface ends nothing: there are cells all around its vertices.
    rim = work.facets_at(outer=True)
    return degrees.target_degrees(work.dimension, angle, rim, degrees.FULL[work.dimension])


@dataclass(frozen=True)
class Relax(Operator):
    """Bring degrees nearer to 6 (triangles) or 12 (tetrahedra)."""

    name: ClassVar[str] = "relax"
    summary: ClassVar[str] = "brings vertex degrees nearer to 6 or 12 (18.4.2)"
    kernels: ClassVar[tuple[str, ...]] = ("relax", "collapse", "relocation")

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

    def sweep(self, work: Workspace, run: Run) -> None:
        self._collapse(work, run)
        self._swap(work, run)
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

    def _relocate(self, work: Workspace, run: Run) -> None:
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
        run.visit(work, order, relocate.sweep_relocation, how)
