"""The course of a run in pieces: which step is next for which piece, and what came of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import formats
from ..errors import ReadError, UnsupportedMeshError
from ..files.folders import replacing_folder
from ..formats import FORMATS, Encoding
from ..formats.vtk.parallel import folder_of, names_of, write_index
from ..mesh.tags import tags_among
from . import steps
from .engines import Engine, Facts, Step
from .figures import Figures, from_json, together
from .numbering import NEW, numbered_in_all
from .shared import Shared, faces_among, shared_by
from .steps import Job
from .store import Store

# Turns: at first all of each piece; then, twice, what is near the places where pieces met, with
# other pieces as the owners of these; then what is near the worst cells.
WHOLE_TURNS = 3
WORST = 0.95  # of the worst Q: what is nearly as bad is worked on, too
ROUNDING = 1e-9

# Called with what is done, how many pieces are done of how many, and the worst Q so far.
Told = Callable[[str, int, int, float], None]


@dataclass
class Course:
    """A run as far as it came.

    Attributes
    ----------
    turn : int
    facts : list of dict
        What was said of each piece in the last turn.
    taken : list of str
        Whether each piece is as it came into this turn ("in") or out of it ("out").
    shared : Shared
        What pieces have in common since then.
    givers : dict of int to list of int
        The pieces that gave cells to those that are to be worked on next; all others rest.
    firsts : list of int
        The first number of what is new of each step so far.
    n_new : list of dict of str to int
        How many new ones of each array that numbers something there are of them.
    target : float
        What the boundary allows.
    apart : float
        The worst Q of the cells that were not near other pieces at first.
    """

    job: Job
    engine: Engine
    told: Told
    turn: int = 0
    facts: list[Facts] = field(default_factory=list)
    taken: list[str] = field(default_factory=list)
    shared: Shared = field(default_factory=lambda: shared_by([np.empty(0, np.int64)]))
    givers: dict[int, list[int]] = field(default_factory=dict)
    firsts: list[int] = field(default_factory=list)
    n_new: list[dict[str, int]] = field(default_factory=list)
    target: float = math.nan
    apart: float = math.inf
    worst: float = math.nan

    def survey(self) -> list[Facts]:
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
        self.givers = {i: [] for i in range(len(job))}
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

    @property
    def near_shared(self) -> bool:
        """Whether this turn is for what is near the places where pieces met."""
        return self.turn < WHOLE_TURNS

    def improve(self, turn: int) -> None:
        """Optimize the pieces whose turn it is, and see which of them to take."""
        job, n = self.job, len(self.job)
        limit = self.limit if turn else math.inf
        self.turn = turn
        first = [NEW * (1 + turn * n + i) for i in range(n)]
        calls = {
            i: (job, turn, i, givers, first[i], limit, self.near_shared)
            for i, givers in self.givers.items()
        }
        done = self._some(turn, "improve", steps.improve, calls)
        self.facts = [done[i] if i in done else self._at_rest(i) for i in range(n)]
        outs = [from_json(one["after"]) for one in self.facts]
        worst = max(one.worst for one in outs)
        self.taken = [
            "out" if i in done and _pays(from_json(one["before"]), out, worst) else "in"
            for i, (one, out) in enumerate(zip(self.facts, outs, strict=True))
        ]
        self.firsts += first
        self.n_new += [
            {key: n if taken == "out" else 0 for key, n in one["n_new"].items()}
            for one, taken in zip(self.facts, self.taken, strict=True)
        ]
        self.shared = shared_by([job.store.array(turn, f"border{i}") for i in range(n)])
        if turn == 0 and not len(self.shared.ids):
            self.target = max(one["target"] for one in self.facts)

    def _at_rest(self, i: int) -> Facts:
        """What is to be said of a piece that is as it was in the turn before."""
        store = self.job.store
        store.keep(self.turn - 1, f"{self.taken[i]}{i}.vtu", self.turn, f"in{i}.vtu")
        for name in (f"border{i}.npy", f"faces{i}.npy"):
            store.keep(self.turn - 1, name, self.turn, name)
        now = self.facts[i]["after" if self.taken[i] == "out" else "before"]
        none = dict.fromkeys(self.facts[i]["n_new"], 0)
        return self.facts[i] | {"before": now, "after": now, "n_new": none}

    @property
    def limit(self) -> float:
        """Q above which cells are worked on in the next turn."""
        return min(self.apart, WORST * self.figures("after").worst)

    def figures(self, which: str) -> Figures:
        """The figures of all pieces, before or after the last turn."""
        return together(self._figures(which), self.shared.n_again)

    def _figures(self, which: str) -> list[Figures]:
        keys = [which if taken == "out" else "before" for taken in self.taken]
        return [from_json(one[key]) for key, one in zip(keys, self.facts, strict=True)]

    @property
    def n_regions(self) -> int:
        """How many regions the whole has."""
        return len({tuple(row) for one in self.facts for row in one["regions"]})

    def give(self) -> None:
        """Let pieces give cells to others, so that what they share comes to lie inside of one: all
        of it at first, later what is near the worst cells, with no turn for other pieces."""
        job, turn, shared = self.job, self.turn, self.shared
        borders = [job.store.array(turn, f"border{i}") for i in range(len(job))]
        if turn + 1 >= WHOLE_TURNS:
            shared = shared.among(self._near_worst())
        owners = {}
        for i, border in enumerate(borders):
            ids = np.intersect1d(border, shared.ids)
            if len(ids) or turn + 1 < WHOLE_TURNS or self._is_bad(i):
                owners[i] = np.stack([ids, shared.owners(ids, turn)], axis=1)
        if self.near_shared:
            self._match_faces()
        calls = {
            i: (job, turn, i, self.taken[i], owner, self.near_shared) for i, owner in owners.items()
        }
        found = self._some(turn, "give", steps.give, calls)
        self.target = np.fmax(self.target, max(one["target"] for one in found.values())).item()
        if turn == 0:
            self.apart = max(one["apart"] for one in found.values())
        self.givers = {i: [] for i in found}
        for i, one in found.items():
            for j in one["others"]:
                self.givers[j].append(i)

    def _is_bad(self, i: int) -> bool:
        return self._figures("after")[i].worst > self.limit

    def _near_worst(self) -> np.ndarray:
        """The shared points that are near the worst cells."""
        calls = {
            i: (self.job, self.turn, i, self.taken[i], self.limit)
            for i in range(len(self.job))
            if self._is_bad(i)
        }
        self._some(self.turn, "bad", steps.near_bad, calls)
        rows = [self.job.store.array(self.turn, f"bad{i}") for i in calls]
        return np.unique(np.concatenate([np.empty(0, np.int64), *rows]))

    def _match_faces(self) -> None:
        """Find out which faces several pieces have; the others are the boundary of the whole."""
        store, pieces = self.job.store, range(len(self.job))
        faces = [store.array(self.turn, f"faces{i}") for i in pieces]
        for i, among in enumerate(faces_among(faces)):
            store.put_array(self.turn, f"among{i}", among)

    def forget(self) -> None:
        """Drop the meshes of the turn before, which are not needed any more."""
        if self.turn:
            self.job.store.drop(self.turn - 1)

    def publish(self, output: Path, surveyed: list[Facts]) -> None:
        """Write all pieces to their place, and the index."""
        names = names_of(output, len(self.job))
        firsts = np.array(self.firsts)
        counts = {one.key: np.array([n[one.key] for n in self.n_new]) for one in self.job.numbered}
        one = surveyed[0]
        encoding = Encoding("vtu", FORMATS["vtu"].default.version, one["binary"], one["compressed"])
        with replacing_folder(folder_of(output)) as place:
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
        """What a step says of each piece."""
        return list(self._some(turn, name, step, dict(enumerate(calls))).values())

    def _some(
        self, turn: int, name: str, step: Step, calls: Mapping[int, tuple[Any, ...]]
    ) -> dict[int, Facts]:
        """What a step says of some pieces, done where it was not before."""
        store = self.job.store
        found = {i: store.facts(turn, f"{name}{i}") for i in calls}
        left = [i for i, facts in found.items() if facts is None]
        waiting = [(store, turn, f"{name}{i}", step, calls[i]) for i in left]
        done = len(calls) - len(left)
        for k, facts in self._done(f"turn {turn + 1}: {name}", noted, waiting, done):
            found[left[k]] = facts
        return {i: facts for i, facts in found.items() if facts is not None}

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
