"""check: the audit of the working mesh. The only pass that never changes anything."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import BadMeshError, InvariantError
from ..kernels.audit import NOT_IN_BALL, NOT_MUTUAL, NOT_POSITIVE, NOT_SHARED, WHOLE, audit
from ..kernels.judge import measure_cells
from ..work.kinds import CELLS, FACES, SIMPLICES
from ..work.session import Workspace
from .base import Pass, option
from .run import Run, Work

FAULTS = {
    NOT_POSITIVE: "is flat or inverted",
    NOT_MUTUAL: "has a neighbour that does not lead back",
    NOT_SHARED: "shares no facet with its neighbour",
    NOT_IN_BALL: "has a vertex whose ball is lost",
}


@dataclass(frozen=True)
class Check(Pass):
    """Prove that every cell is positive and knows its neighbours."""

    name: ClassVar[str] = "check"
    summary: ClassVar[str] = "proves that the mesh is whole; changes nothing"
    works_on: ClassVar[tuple[str, ...]] = (SIMPLICES, FACES, CELLS)

    inverted: str = option(
        "refused", "whether cells may be inverted or flat, because a later pass mends them",
        choices=("refused", "allowed"),
    )  # fmt: skip

    def sweep(self, work: Work, run: Run) -> None:
        """Audit the mesh.

        Raises
        ------
        BadMeshError
            The mesh came with inverted or flat cells, and nothing has mended them yet.
        InvariantError
            A cell breaks a promise of the operators.
        """
        refused = self.inverted == "refused"
        if refused and work.came_tangled and work.standing().worst <= 0.0:
            raise BadMeshError(
                "it has inverted or flat cells where the pass check refuses them: put untangle "
                "before it, or set check.inverted=allowed"
            )
        if not isinstance(work, Workspace):
            work.require_fresh()
            return
        rows = work.living()
        fault, cell = audit(work.mesh, 0.0 if refused else -math.inf)
        if fault != WHOLE:
            raise InvariantError(f"cell {cell} of the working mesh {FAULTS[fault]}")
        quality = np.empty(len(rows))
        measure_cells(work.mesh.judge, work.mesh.points, work.corners(rows), quality)
        # The order of a cell's vertices changes the rounding of its q, and nothing more.
        stale = np.flatnonzero(np.abs(quality - work.quality(rows)) > 1e-9)
        if len(stale):
            raise InvariantError(f"cell {rows[stale[0]]} of the working mesh has a stale quality")
