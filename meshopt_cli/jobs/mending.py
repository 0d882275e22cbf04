"""What the passes `repair` of a pipeline do to a mesh, before it is worked on."""

from __future__ import annotations

import logging
import time

from ..kernels.types import Verdict
from ..mesh.model import Mesh
from ..passes import Tally
from ..passes.repair import Repair
from ..repairs import MENDS, repair

log = logging.getLogger("meshopt")


def mended(mesh: Mesh, steps: tuple[Repair, ...]) -> tuple[Mesh, list[Tally]]:
    """Mend a mesh as some passes say; each thing that changed is counted in a warning.

    Returns
    -------
    mesh : Mesh
    tallies : list of Tally
        What each of the passes did.

    Raises
    ------
    BadMeshError
        No cell would be left.
    """
    tallies = []
    for step in steps:
        start = time.perf_counter()
        done = repair(mesh, filter(step.asks_for, MENDS), step.tolerance or None)
        for what, n in done.counts.items():
            log.warning("repair: %s: %s", what, f"{n:,}")
        for note in done.notes:
            log.warning("repair: %s", note)
        mesh, tally = done.mesh, Tally(step.name)
        tally.counts[Verdict.APPLIED] = sum(done.counts.values())
        tally.seconds = time.perf_counter() - start
        tallies.append(tally)
    return mesh, tallies
