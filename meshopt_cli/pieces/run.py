"""One optimization of a mesh in pieces, from files to files."""

from __future__ import annotations

import hashlib
import logging
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ..boundary.policy import Fixed
from ..errors import ConfigError, InvariantError, ReadError
from ..formats.vtk.parallel import is_index, sources_of
from ..jobs.optimize_mesh import Task, accepted
from ..jobs.split_file import require_index
from ..mesh.tags import Regions
from ..reports.model import FileFacts, Report
from ..version import __version__
from .course import ROUNDING, Course, Told
from .engines import Engine
from .figures import Figures
from .steps import Job
from .store import Store

log = logging.getLogger("meshopt")

MOST_TURNS = 12
IN_VAIN = 3  # turns for the worst cells in a row that gain nothing
GAIN = 0.999


@dataclass(frozen=True)
class PiecesTask:
    """A mesh in pieces, and where the result goes.

    Attributes
    ----------
    input, output : Path
        Called `.pvtu`.
    task : Task
        What to make of it.
    fail_above : float, optional
        Write nothing where a cell stays worse than this Q.
    """

    input: Path
    output: Path
    task: Task
    fail_above: float | None = None

    @property
    def store(self) -> Store:
        """Where it is worked on: beside the output, so that all machines see it."""
        return Store(self.output.with_suffix(".work"))


def are_pieces(input: Path, output: Path | None) -> bool:
    """Whether a run goes from pieces to pieces."""
    return output is not None and is_index(input) and is_index(output)


def require_piecewise(task: Task) -> None:
    """Refuse what needs the whole mesh at once.

    Raises
    ------
    ConfigError
    """
    wrong = ""
    request = task.request
    if not isinstance(task.policy, Fixed):
        wrong = f"--boundary {task.policy.name}"
    elif task.metric is not None:
        wrong = "a metric"
    elif task.keep_off:
        wrong = "--keep-off"
    elif request.only or request.freeze or request.below is not None:
        wrong = "--only, --freeze and --below"
    elif accepted(task).plan.pipeline.time_limit < math.inf:
        wrong = "a time limit"
    elif accepted(task).plan.pipeline.repairs:
        wrong = "the pass repair"
    elif task.write_quality or task.no_data:
        wrong = "--write-quality" if task.write_quality else "--no-data"
    if wrong:
        raise ConfigError(f"{wrong}: not for meshes in pieces; meshopt join makes one of them")


def optimize_pieces(task: PiecesTask, engine: Engine, told: Told = lambda *_: None) -> Report:
    """Optimize a mesh in pieces.

    What is done of it is kept in a folder beside the output until all is: the same call goes on
    from there, and ends with the same bytes. So does any number of processes.

    Raises
    ------
    ConfigError, ReadError, WriteError, BadMeshError, UnsupportedMeshError
    StepError
        What a step raised in another process.
    """
    require_index(task.output)
    require_piecewise(task.task)
    sources = sources_of(task.input)
    start = time.perf_counter()
    job = Job(tuple(sources), task.store, task.task)
    if task.store.begin(_fingerprint(task, sources)):
        log.warning("%s: goes on where it was ended", task.store.folder)
    course = Course(job, engine, told)
    surveyed = course.survey()
    course.improve(0)
    before, after = course.figures("before"), course.figures("after")
    in_vain = 0
    for turn in range(1, MOST_TURNS):
        if not len(course.shared.ids) or in_vain == IN_VAIN:
            break
        course.give()
        course.forget()
        course.improve(turn)
        last, after = after, course.figures("after")
        in_vain = in_vain + 1 if not course.near_shared and after.worst > GAIN * last.worst else 0
    _require_no_worse(before, after)
    report = partial(
        Report, __version__, _facts(task.input), before.summary(course.target),
        after=after.summary(course.target), stopped="pieces are done",
        regions=Regions(course.job.regions, course.n_regions),
    )  # fmt: skip
    if task.fail_above is not None and after.worst > task.fail_above:
        return report(seconds={"optimize": time.perf_counter() - start})
    course.publish(task.output, surveyed)
    task.store.remove()
    return report(
        output=_facts(task.output), seconds={"optimize": time.perf_counter() - start}
    )  # fmt: skip


def _require_no_worse(before: Figures, after: Figures) -> None:
    """Raises InvariantError if a mesh got worse."""
    if after.n_invalid or after.worst > before.worst * (1 + ROUNDING):
        raise InvariantError(f"the worst Q rose from {before.worst} to {after.worst}")


def _fingerprint(task: PiecesTask, sources: Sequence[Path]) -> dict[str, Any]:
    """What a job is: the same words make the same bytes."""
    files = []
    for path in sources:
        try:
            stat = path.stat()
        except OSError as error:
            raise ReadError(f"{path}: this piece cannot be read") from error
        files.append([str(path.resolve()), stat.st_size, stat.st_mtime_ns])
    words = repr((accepted(task.task).holds.values, task.task.regions))
    return {
        "meshopt": __version__,
        "options": hashlib.sha256(words.encode()).hexdigest(),
        "pieces": files,
    }


def _facts(path: Path) -> FileFacts:
    return FileFacts(str(path), "pvtu", hashlib.sha256(path.read_bytes()).hexdigest())
