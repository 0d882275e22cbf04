"""The work itself: simplices in, better simplices out, and nothing else touched.

It knows no file and no mesh around the simplices, and all that it takes and gives can be sent to
another process: this is what a part of a mesh is given to.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..boundary.patches import Patches
from ..constraints.model import Constraints
from ..kernels.types import Judge
from ..mesh.cast import Simplices
from ..progress.observer import SILENT, Observer
from ..work.background import Background
from ..work.bounds import Bounds
from ..work.session import Workspace
from .pipeline import Pipeline
from .stages import Line


@dataclass(frozen=True)
class Worked:
    """Simplices that were worked on.

    Attributes
    ----------
    part : Simplices
        Regions are numbered as in the input, points that no cell used are there.
    origin : (np',) int64
        The point of the input that each point was, -1 for a new one.
    lines : tuple of Line
        What every pass did.
    stopped : str
        Why the run ended.
    is_untouched : bool
        Whether nothing is other than it was, but for the order of the cells.
    """

    part: Simplices
    origin: np.ndarray
    lines: tuple[Line, ...]
    stopped: str
    is_untouched: bool = False


def improve(
    part: Simplices,
    pipeline: Pipeline,
    judge: Judge,
    target: float = 1.0,
    patches: Patches | None = None,
    splittable: np.ndarray | None = None,
    observer: Observer = SILENT,
    bounds: Bounds | None = None,
    background: Background | None = None,
    constraints: Constraints | None = None,
) -> Worked:
    """Run a pipeline over simplices; these are left as they are.

    Parameters
    ----------
    target : float
        Q of the best cell that the worst facet of the boundary allows; 1 when that is not known.
    patches : Patches, optional
        Where vertices of the boundary may move.
    splittable : (n, 2) int64, optional
        Edges of the boundary that may be split.
    bounds : Bounds, optional
        What the passes hold it against, where it is a part of a larger mesh; itself without.
    constraints : Constraints, optional
        What its vertices were told.

    Raises
    ------
    InvariantError
        An operator broke the mesh.
    """
    work = partial(
        Workspace, part, judge, target, patches=patches, splittable=splittable,
        background=background, constraints=constraints,
    )  # fmt: skip
    # No name holds the working mesh here: the run may go back to a copy, and let go of it.
    outcome = pipeline.run(_bounded(work, bounds), observer)
    assert isinstance(outcome.work, Workspace)
    better, origin = outcome.work.result()
    return Worked(better, origin, tuple(outcome.lines), outcome.stopped, outcome.is_untouched)


def _bounded(make: Callable[[], Workspace], bounds: Bounds | None) -> Workspace:
    work = make()
    if bounds is not None:
        work.bounds = bounds
    return work
