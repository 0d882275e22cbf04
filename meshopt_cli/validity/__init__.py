"""What `check` looks for: the table of rules, and the search for what breaks them.

Every rule is a function of an `Examination`, under a decorator that makes a row of it. It returns
the `Places` where the rule is broken, as arrays, since there may be many.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ..mesh.model import Array, Mesh
from ..quality.gates import NO_GATES, Gates, Limit, limit_of
from . import contact
from .examination import Examination
from .model import (
    ARRAYS,
    ERROR,
    SEARCH,
    WARNING,
    Finding,
    Group,
    Places,
    Report,
    Rule,
)
from .rules import RULES, choose, meant

__all__ = ["ARRAYS", "ERROR", "NO_GATES", "RULES", "SEARCH", "WARNING", "Finding", "Gates"]
__all__ += ["Group", "Limit", "Places", "Report", "Rule", "check", "choose", "limit_of"]
__all__ += ["meant", "vertices_apart"]


def check(
    mesh: Mesh,
    select: Iterable[str] = (),
    ignore: Iterable[str] = (),
    gates: Gates = NO_GATES,
    *,
    extend: Iterable[str] = (),
    tolerance: float | None = None,
    overlaps: bool = True,
    figures: Mapping[str, float] | None = None,
) -> Report:
    """Look for everything that makes a mesh invalid.

    Parameters
    ----------
    mesh : Mesh
        May hold anything; rules that need sound cells look at the sound ones only.
    select : iterable of str
        Codes, or prefixes of codes, of the rules to check; none means all but those on request.
    ignore : iterable of str
        Codes or prefixes to leave out of those.
    gates : Gates
        Limits that the user sets; their rules need not be selected.
    extend : iterable of str
        Codes or prefixes to look for besides those selected.
    tolerance : float, optional
        Relative distance at which points coincide and vertices touch facets.
    overlaps : bool
        Whether to look for solids that overlap (M209), which takes longer than all the rest.
    figures : mapping of str to float, optional
        What the mesh has of `quality.gates.FIGURES`; there is no gate on what is left out.

    Raises
    ------
    ConfigError
        A code or prefix that no rule has, or a gate on a region that the mesh does not have.
    """
    wanted = choose(select, ignore, (*extend, *gates.codes))
    with np.errstate(all="ignore"):
        study = Examination(mesh, gates, tolerance, figures)
        every = overlaps or study.dimension < 3
        found = [Group(row, row.find(study)) for row in wanted if every or row.cost != SEARCH]
    return Report(tuple(group for group in found if len(group)))


def vertices_apart(mesh: Mesh) -> Array:
    """Vertices of cells that meet others without sharing all that they meet in, ascending.

    Those of points in one place, of facets that coincide, and of facets with vertices on them.
    """
    with np.errstate(all="ignore"):
        study = Examination(mesh)
        return contact.vertices_apart(study, study.first_points, study.hanging)
