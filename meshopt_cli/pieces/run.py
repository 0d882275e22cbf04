"""One optimization of a mesh in pieces, from files to files."""

from __future__ import annotations

import hashlib
import logging
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .. import formats
from ..boundary.policy import Fixed
from ..errors import ConfigError, InvariantError, ReadError, UnsupportedMeshError
from ..files.folders import replacing_folder
from ..formats import FORMATS, Encoding
from ..formats.vtk.parallel import folder_of, is_index, names_of, sources_of, write_index
from ..jobs.optimize_mesh import Task, accepted
from ..jobs.split_file import require_index
from ..mesh.model import Array
from ..mesh.tags import Regions, tags_among
from ..reports.model import FileFacts, Report
from ..version import __version__
from . import steps
from .engines import Engine, Facts, Step
from .figures import Figures, from_json, together
from .numbering import NEW, numbered_in_all
from .shared import Shared, faces_among, shared_by
from .steps import Job
from .store import Store

log = logging.getLogger("meshopt")

# Turns: at first all of each piece; then, twice, what is near the places where pieces met, with
# the first and then with the last of those that met as the owner; then what is worse than the worst
# cell of the best piece, while that gains.
LEAST_TURNS, MOST_TURNS = 3, 8
ENOUGH = 1.02  # of the worst Q of the best piece
GAIN = 0.999
ROUNDING = 1e-9

# Called with what is done, how many pieces are done of how many, and the worst Q so far.
Told = Callable[[str, int, int, float], None]


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
    elif accepted(task).plan.pipeline.repairs:
        wrong = "the pass repair"
    elif task.write_quality:
        wrong = "--write-quality"
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
    run = _Run(job, engine, told)
    surveyed = run.surveyed()
    run.improve(0)
    before, after = run.figures("before"), run.figures("after")
    if not run.has_shared:
        run.target = max(one["target"] for one in run.facts)
    for turn in range(1, MOST_TURNS):
        if not run.has_shared or (turn >= LEAST_TURNS and after.worst <= ENOUGH * run.bad):
            break
        run.give(turn - 1)
        run.improve(turn)
        last, after = after, run.figures("after")
        if turn >= LEAST_TURNS and after.worst > GAIN * last.worst:
            break
    _require_no_worse(before, after)
    report = partial(
        Report, __version__, _facts(task.input), before.summary(run.target),
        after=after.summary(run.target), stopped="pieces are done",
        regions=Regions(run.job.regions, run.n_regions),
    )  # fmt: skip
    if task.fail_above is not None and after.worst > task.fail_above:
        return report(seconds={"optimize": time.perf_counter() - start})
    run.publish(task.output, surveyed)
    task.store.remove()
    return report(
        output=_facts(task.output), seconds={"optimize": time.perf_counter() - start}
    )  # fmt: skip


@dataclass
class _Run:
    """A run as far as it came.

    Attributes
    ----------
    taken : list of str
        Whether each piece is as it came into the last turn ("in") or out of it ("out").
    givers : list of list of int
        The pieces that gave cells to each in the turn before.
    firsts : list of int
        The first number of what is new of each step so far.
    n_new : list of dict of str to int
        How many new ones of each array that numbers something there are of them.
    target : float
        What the boundary allows, as far as it was looked at.
    bad : float
        The worst Q of the best piece: where others are worse, there is work to do.
    """

    job: Job
    engine: Engine
    told: Told
    turn: int = 0
    taken: list[str] = field(default_factory=list)
    givers: list[list[int]] = field(default_factory=list)
    firsts: list[int] = field(default_factory=list)
    n_new: list[dict[str, int]] = field(default_factory=list)
    target: float = math.nan
    facts: list[Facts] = field(default_factory=list)
    shared: Shared | None = None
    worst: float = math.nan
    bad: float = math.inf

    def surveyed(self) -> list[Facts]:
        """Look at all pieces, and number their points through all of them where they are not."""
        job = self.job
        found = self._all(0, "survey", steps.survey, [(job, i) for i in range(len(job))])
        for path, one in zip(job.sources, found, strict=True):
            if one["arrays"] != found[0]["arrays"] or one["n_cells"] == 0:
                what = "has no cells" if one["n_cells"] == 0 else "has other arrays than the first"
                raise ReadError(f"{path}: this piece {what}")
        types = sorted({name for one in found for name in one["types"]})
        if len(types) > 1:
            raise UnsupportedMeshError(
                f"{job.sources[0].parent}: the pieces have cells of several types, "
                f"{' and '.join(types)}: meshopt join makes one mesh of them"
            )
        if not all(one["has_ids"] for one in found):
            found = [one | more for one, more in zip(found, self._number(found), strict=True)]
        tables = [
            {n: None if v is None else np.array(v) for n, v in one["labels"].items()}
            for one in found
        ]
        regions = job.task.regions or tags_among(tables, sum(one["n_cells"] for one in found))
        numbered = numbered_in_all([one["numbered"] for one in found])
        self.job = replace(job, regions=regions, numbered=tuple(numbered))
        self.givers = [[] for _ in found]
        return found

    def _number(self, found: list[Facts]) -> list[Facts]:
        """Number points: those on borders alike where they agree in every bit of their place."""
        store = self.job.store
        if any(one["has_ids"] for one in found):
            raise ReadError("some of the pieces number their points, others do not")
        places = [store.array(0, f"border{i}") for i in range(len(found))]
        _, number = np.unique(np.concatenate(places) + 0.0, axis=0, return_inverse=True)
        ends = np.cumsum([len(one) for one in places])
        for i, own in enumerate(np.split(number.ravel(), ends[:-1])):
            store.put_array(0, f"numbers{i}", own)
        inside = [one["n_points"] - one["n_border"] for one in found]
        first = int(number.max(initial=-1)) + 1 + np.cumsum([0, *inside[:-1]])
        calls = [(self.job, i, int(one)) for i, one in enumerate(first)]
        return self._all(0, "number", steps.number, calls)

    def improve(self, turn: int) -> None:
        """Optimize all pieces, and see which of them to take."""
        job, n = self.job, len(self.job)
        self.turn = turn
        first = [NEW * (1 + turn * n + i) for i in range(n)]
        calls = [
            (job, turn, i, self.givers[i], first[i], self.bad, turn < LEAST_TURNS) for i in range(n)
        ]
        self.facts = self._all(turn, "improve", steps.improve, calls)
        outs = [from_json(one["after"]) for one in self.facts]
        worst, self.bad = max(one.worst for one in outs), min(one.worst for one in outs)
        self.taken = [
            "out" if _pays(from_json(one["before"]), out, worst) else "in"
            for one, out in zip(self.facts, outs, strict=True)
        ]
        self.firsts += first
        self.n_new += [
            {key: n if taken == "out" else 0 for key, n in one["n_new"].items()}
            for one, taken in zip(self.facts, self.taken, strict=True)
        ]
        self.shared = shared_by([job.store.array(turn, f"border{i}") for i in range(n)])

    def figures(self, which: str) -> Figures:
        """The figures of all pieces, before or after the last turn."""
        assert self.shared is not None
        keys = [which if taken == "out" else "before" for taken in self.taken]
        all_of = [from_json(one[key]) for key, one in zip(keys, self.facts, strict=True)]
        return together(all_of, self.shared.n_again)

    @property
    def n_regions(self) -> int:
        """How many regions the whole has."""
        return len({tuple(row) for one in self.facts for row in one["regions"]})

    @property
    def has_shared(self) -> bool:
        """Whether pieces have points in common."""
        return self.shared is not None and len(self.shared.ids) > 0

    def give(self, turn: int) -> None:
        """Let pieces give cells to others, so that what they share comes to lie inside of one."""
        assert self.shared is not None
        calls: list[tuple[Any, ...]] = []
        for i, taken in enumerate(self.taken):
            ids = np.intersect1d(self._border(i), self.shared.ids)
            owner = np.stack([ids, self.shared.owners(ids, turn)], axis=1)
            calls.append((self.job, turn, i, taken, owner))
        self._match_faces()
        found = self._all(turn, "give", steps.give, calls)
        self.target = np.fmax(self.target, max(one["target"] for one in found)).item()
        self.givers = [[] for _ in found]
        for i, one in enumerate(found):
            for j in one["others"]:
                self.givers[j].append(i)
        if turn:
            self.job.store.drop(turn - 1)

    def _match_faces(self) -> None:
        """Find out which faces several pieces have; the others are the boundary of the whole."""
        store, pieces = self.job.store, range(len(self.job))
        faces = [store.array(self.turn, f"faces{i}") for i in pieces]
        for i, among in enumerate(faces_among(faces)):
            store.put_array(self.turn, f"among{i}", among)

    def _border(self, i: int) -> Array:
        return self.job.store.array(self.turn, f"border{i}")

    def publish(self, output: Path, surveyed: list[Facts]) -> None:
        """Write all pieces to their place, and the index."""
        names = names_of(output, len(self.job))
        firsts = np.array(self.firsts)
        counts = {one.key: np.array([n[one.key] for n in self.n_new]) for one in self.job.numbered}
        one = surveyed[0]
        encoding = Encoding("vtu", FORMATS["vtu"].default.version, one["binary"], one["compressed"])
        folder = folder_of(output)
        with replacing_folder(folder) as place:
            calls = [
                (self.job, self.turn, i, taken, firsts, counts, place / names[i], encoding)
                for i, taken in enumerate(self.taken)
            ]
            for _ in self._done("writing", steps.publish, calls):
                pass
            like = formats.read(place / names[0])[0]
        write_index(output, names, like)

    def _all(
        self, turn: int, name: str, step: Step, calls: Sequence[tuple[Any, ...]]
    ) -> list[Facts]:
        """What a step says of each piece, done where it was not before."""
        store = self.job.store
        found = [store.facts(turn, f"{name}{i}") for i in range(len(calls))]
        left = [i for i, facts in enumerate(found) if facts is None]
        waiting = [(store, turn, f"{name}{i}", step, calls[i]) for i in left]
        done = len(calls) - len(left)
        for k, facts in self._done(f"turn {turn + 1}: {name}", noted, waiting, done):
            found[left[k]] = facts
        return [facts for facts in found if facts is not None]

    def _done(
        self, what: str, step: Step, calls: Sequence[tuple[Any, ...]], n_before: int = 0
    ) -> Iterator[tuple[int, Facts]]:
        """Do a step, and tell of it."""
        n = len(calls) + n_before
        for k, (i, facts) in enumerate(self.engine.map(step, calls), n_before + 1):
            if "after" in facts:
                self.worst = max(facts["after"]["worst"], 0.0 if k == 1 else self.worst)
            self.told(what, k, n, self.worst)
            yield i, facts


def noted(store: Store, turn: int, name: str, step: Step, call: tuple[Any, ...]) -> Facts:
    """Do a step, and note in the store that it is done."""
    facts = step(*call)
    store.say(turn, name, facts)
    return facts


def _pays(before: Figures, after: Figures, worst: float) -> bool:
    """Whether what became of a piece is better for the whole, whose worst Q is so much.

    A piece may pay with its mean for its worst cell, which pays for the whole only where it would
    have been the worst of all.
    """
    if after.mean <= before.mean * (1 + ROUNDING):
        return True
    return before.worst > worst


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
    words = repr((accepted(task.task).holds.values, task.task.regions, task.task.no_data))
    return {
        "meshopt": __version__,
        "options": hashlib.sha256(words.encode()).hexdigest(),
        "pieces": files,
    }


def _facts(path: Path) -> FileFacts:
    return FileFacts(str(path), "pvtu", hashlib.sha256(path.read_bytes()).hexdigest())
