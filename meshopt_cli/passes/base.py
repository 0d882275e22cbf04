"""What every pass is: its options, and how it chooses what to visit."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

import numpy as np

from ..errors import ConfigError
from ..kernels import accept as rules
from ..progress.observer import SILENT, Observer
from ..work.kinds import SIMPLICES
from ..work.session import Workspace
from .run import UNLIMITED, Budget, Run, Tally, Work

Array = np.ndarray

ACCEPT = {
    "strict": rules.STRICT,
    "ratio": rules.RATIO,
    "floor": rules.FLOOR,
    "valid": rules.VALID,
    "mean": rules.MEAN,
}
ORDERS = ("worst-first", "index", "random")
MOST_Q = 1e12  # no cell that is worse is told from a flat one


def option(
    default: Any,
    help: str,
    choices: tuple[str, ...] = (),
    least: float | None = None,
    most: float | None = None,
) -> Any:
    """A field of a pass that is at once a config key, a `--set` key and a line of the docs.

    Parameters
    ----------
    default : str, int or float
        Of its kind are all values.
    choices : tuple of str
        Of a word; a number has limits instead.
    least, most : float
        The limits, both of them allowed.
    """
    return field(
        default=default,
        metadata={
            "help": help,
            "choices": choices,
            "least": least,
            "most": most,
            "kind": type(default),
        },
    )


def bad_enough(default: float, where: str) -> Any:
    """The option that says what is bad enough to be visited."""
    return option(default, f"visit only {where} this; 1: everywhere", least=1.0, most=MOST_Q)


def urgency() -> Any:
    """The option of passes that lift the worst cells at some cost to those around them."""
    return option(
        1.5, "change cells whose Q is below the worst of the mesh over this only where the mean Q "
        "of what changes falls, too", least=1.0, most=1e6,
    )  # fmt: skip


def urgent_q(work: Workspace, factor: float) -> float:
    """The q below which a change may raise the mean: so many times the worst of the mesh."""
    worst = work.worst_of_all
    return factor * worst if worst > 0.0 else math.inf


@dataclass(frozen=True)
class Pass:
    """Base of all passes; the dataclass fields are the options.

    A pass is a value: what was visited is remembered by the mesh (`Workspace.visits`) under the
    pass, so that equal passes share it, and one pass may serve several threads.
    """

    name: ClassVar[str] = ""
    summary: ClassVar[str] = ""
    kernels: ClassVar[tuple[str, ...]] = ()  # groups that its sweeps may call
    mends_tangles: ClassVar[bool] = False
    splits_boundary: ClassVar[bool] = False  # where `--boundary split` lets it
    needs_metric: ClassVar[bool] = False
    takes_metric: ClassVar[bool] = True  # or whether angles have no meaning for it but their own
    works_on: ClassVar[tuple[str, ...]] = (SIMPLICES,)  # kinds of working meshes

    def __post_init__(self) -> None:
        self.validate()

    def validate(self) -> None:
        """Check the options.

        Raises
        ------
        ConfigError
            One is out of range: the message names it.
        """
        for f in fields(self):
            self._check_option(f.name, f.metadata)

    def _check_option(self, name: str, metadata: Any) -> None:
        value = getattr(self, name)
        shown = f"{self.name}.{name.replace('_', '-')}"
        if metadata["choices"] and value not in metadata["choices"]:
            choices = ", ".join(metadata["choices"])
            raise ConfigError(f"{shown}: {value!r:.60} is not one of {choices}")
        least, most = metadata["least"], metadata["most"]
        if not metadata["choices"] and not least <= value <= most:
            limits = f"from {least:.10g} to {most:.10g}"
            raise ConfigError(f"{shown}: {value} is out of range, must be {limits}")

    def needed_kernels(self) -> tuple[str, ...]:
        """Groups of kernels that are compiled before it runs, with these options."""
        return self.kernels

    def run(self, work: Work, observer: Observer = SILENT, budget: Budget = UNLIMITED) -> Tally:
        """Apply the pass to the mesh once.

        Raises
        ------
        CancelledError, OutOfTimeError
            The observer or the budget ends it; the mesh is whole.
        """
        run = Run(Tally(self.name), observer, budget)
        observer.started(self.name, 0)
        start = time.perf_counter()
        before = None if isinstance(work, Workspace) else work.mesh.points.copy()
        self.sweep(work, run)
        if not isinstance(work, Workspace) and before is not None:
            run.tally.note("moved", work.moved_from(before))
        run.tally.seconds = time.perf_counter() - start
        return run.tally

    def left(self, work: Any) -> int:
        """How much there is left to do, for a pass with another aim than quality.

        A run that leaves less is the better one, where the worst Q is no higher for it.
        """
        return 0

    def sweep(self, work: Any, run: Run) -> None:
        raise AssertionError("every pass has a sweep of its own")


@dataclass(frozen=True)
class Operator(Pass):
    """A pass that visits entities one by one and may change the mesh at each."""

    worse_than: float = bad_enough(1.0, "where the worst Q is above")
    accept: str = option(
        "strict",
        "when a change is taken: the worst Q of its patch falls (strict), does not rise beyond "
        "1/least-quality of what it was (ratio), does not rise above 1/least-quality (floor), all "
        "cells stay positive (valid), or the mean Q falls and the worst rises by two thirds at "
        "most, not above 1/least-quality, nor above that of the mesh where this is less, nor "
        "above 2 where it was below (mean)",
        choices=tuple(ACCEPT),
    )
    least_quality: float = option(
        0.5, "least quality 1/Q, or part of the quality before, that `accept` allows",
        least=0.0, most=1.0,
    )  # fmt: skip
    order: str = option("worst-first", "order of the visits", choices=ORDERS)
    seed: int = option(0, "seed of the random order", least=0, most=2**32 - 1)

    @property
    def limit(self) -> float:
        """The q below which an entity is visited."""
        return 1.0 / self.worse_than

    @property
    def rule(self) -> int:
        return ACCEPT[self.accept]

    def least(self, work: Work) -> float:
        """The q that the rule goes by: for the mean, no cell becomes the worst of all."""
        if self.rule == rules.MEAN:
            return max(self.least_quality, work.worst_of_all)
        return self.least_quality

    def ordered(self, work: Work, entities: Array, quality: Array) -> Array:
        """The entities in the order of the visits; ties by number."""
        if self.order == "worst-first":
            return entities[np.argsort(quality, kind="stable")]
        if self.order == "random":
            generator = np.random.default_rng([self.seed, work.clock])
            return generator.permutation(entities)
        return entities

    def takes(self, floor: float, before: float, after: float, means: tuple[float, float]) -> bool:
        """Whether the rule allows a change of worst q, and of mean Q from the first to the second.

        For what is simulated all at once, and not by kernels.
        """
        if not rules.is_accepted(self.rule, floor, before, after):
            return False
        return self.rule != rules.MEAN or rules.mean_falls(*means)
