"""Meshes mended on request: what is wrong with them taken out, put right, or put in.

`MENDS` has one row for each thing that can be asked for; the command line, the pass and the docs
follow it. The rows stand in the order that they are applied in: points are merged first, so that
cells and facets are known by their vertices, and unused points go last.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..errors import BadMeshError
from ..mesh.model import Mesh
from ..validity.examination import Examination
from .cells import drop_duplicates, drop_lost_facets
from .fill import fill
from .flat import drop_flat
from .model import Mend, Mended
from .points import drop_unused, merge
from .turn import turn

__all__ = ["MENDS", "Mend", "Mended", "Repaired", "repair"]

MENDS: dict[str, Mend] = {
    row.name: row
    for row in (
        Mend("merge", "make one of the points in one place", merge),
        Mend("duplicates", "drop cells with the vertices of another", drop_duplicates),
        Mend("flat", "drop cells without content; write those with a vertex twice as the simpler "
             "cells that they are", drop_flat),
        Mend("orientation", "turn cells so that neighbours agree", turn),
        Mend("fill", "add cells where one cell is missing", fill),
        Mend("facets", "drop declared facets that bound no cell", drop_lost_facets),
        Mend("unused", "drop points that no cell has", drop_unused),
    )
}  # fmt: skip

# One mend may make another possible: all are made again until nothing changes.
MOST_ROUNDS = 10


@dataclass(frozen=True)
class Repaired:
    """A mesh after its mends, by their names in the order they were made."""

    mesh: Mesh
    mends: dict[str, Mended]

    @property
    def counts(self) -> dict[str, int]:
        """How many of each thing changed, as messages say it; no zeros."""
        pairs = (pair for one in self.mends.values() for pair in one.counts.items())
        return {what: n for what, n in pairs if n}

    @property
    def notes(self) -> tuple[str, ...]:
        """What could not be mended, or is to be known."""
        return tuple(note for one in self.mends.values() for note in one.notes + one.left)


def repair(mesh: Mesh, names: Iterable[str], tolerance: float | None = None) -> Repaired:
    """Mend what is asked for; the input is left as it is.

    Parameters
    ----------
    mesh : Mesh
        May hold anything.
    names : iterable of str
        Keys of `MENDS`, in any order.
    tolerance : float, optional
        Points nearer to each other than this part of the extent of the mesh are in one place;
        left out, it follows from the precision of the coordinates.

    Raises
    ------
    BadMeshError
        It has no cells, or none would be left.
    """
    if mesh.dimension() < 0:
        raise BadMeshError("there are no cells in it")
    wanted = set(names)
    mends = [mend for mend in MENDS.values() if mend.name in wanted]
    done: dict[str, Mended] = {}
    with np.errstate(all="ignore"):
        study = Examination(mesh, tolerance=tolerance)
        for _ in range(MOST_ROUNDS):
            before = study.mesh
            for mend in mends:
                mended = mend.apply(study)
                known = done.get(mend.name)
                done[mend.name] = mended if known is None else known.followed_by(mended)
                if mended.mesh is not study.mesh:
                    study = Examination(mended.mesh, tolerance=tolerance)
            if study.mesh is before:
                break
    if study.mesh.dimension() < 0:
        raise BadMeshError("no cell of it would be left: nothing written")
    return Repaired(study.mesh, done)
