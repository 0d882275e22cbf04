"""What every pass is: its options, how it chooses what to visit, and what it reports."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Protocol

import numpy as np

from ..errors import ConfigError
from ..kernels import accept as rules
from ..kernels.types import N_VERDICTS, Verdict
from ..work.workspace import Workspace

Array = np.ndarray

ACCEPT = {
    "strict": rules.STRICT,
    "ratio": rules.RATIO,
    "floor": rules.FLOOR,
    "valid": rules.VALID,
    "mean": rules.MEAN,
}
ORDERS = ("worst-first", "index", "random")


def option(
    default: Any,
    help: str,
    choices: tuple[str, ...] = (),
    least: float | None = None,
    most: float | None = None,
) -> Any:
    """A field of a pass that is at once a config key, a `--set` key and a line of the docs."""
    return field(
        default=default,
        metadata={"help": help, "choices": choices, "least": least, "most": most},
    )


def urgency() -> Any:
    """The option of passes that lift the worst cells at some cost to those around them."""
    return option(
        1.5, "change cells whose Q is below the worst of the mesh over this only where the mean Q "
        "of what changes falls, too", least=1.0,
    )  # fmt: skip


def urgent_q(work: Workspace, times: float) -> float:
    """The q below which a change may raise the mean: so many times the worst of the mesh."""
    worst = work.standing().worst
    return times * worst if worst > 0.0 else math.inf


class Observer(Protocol):
    """Somebody who watches a pass at work: a progress bar, a clock."""

    def start(self, name: str, total: int) -> None:
        """A sweep over so many entities begins."""

    def advance(self, by: int) -> None:
        """So many more were visited. May raise to stop the work: the mesh is whole here."""


class Silent:
    """The observer that does nothing."""

    def start(self, name: str, total: int) -> None:
        pass

    def advance(self, by: int) -> None:
        pass


@dataclass
class Tally:
    """What one run of a pass did."""

    name: str
    counts: Array = field(default_factory=lambda: np.zeros(N_VERDICTS, dtype=np.int64))
    seconds: float = 0.0

    @property
    def visited(self) -> int:
        """Number of attempts."""
        return int(self.counts.sum())

    @property
    def applied(self) -> int:
        return int(self.counts[Verdict.APPLIED])

    @property
    def refused(self) -> dict[str, int]:
        """Number of refusals by verdict, those that occurred."""
        return {
            v.name.lower().replace("_", "-"): int(self.counts[v])
            for v in Verdict
            if v != Verdict.APPLIED and self.counts[v]
        }


@dataclass
class Pass:
    """Base of all passes; the dataclass fields are the options."""

    name: ClassVar[str] = ""
    summary: ClassVar[str] = ""
    kernels: ClassVar[tuple[str, ...]] = ()  # groups that are compiled before it runs

    def __post_init__(self) -> None:
        self._since: dict[str, int] = {}
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
            raise ConfigError(f"{shown}: {value!r} is not one of {choices}")
        least, most = metadata["least"], metadata["most"]
        if (least is not None and not value >= least) or (most is not None and not value <= most):
            limits = f"at least {least}" if most is None else f"from {least} to {most}"
            raise ConfigError(f"{shown}: {value} is out of range, must be {limits}")

    def forget(self) -> None:
        """Visit everything again at the next run: the mesh is another one now."""
        self._since = {}

    def memory(self) -> Any:
        """What it knows of the mesh, to be given to `recall` with the mesh as it is now."""
        return dict(self._since)

    def recall(self, memory: Any) -> None:
        """Go back to what was known."""
        self._since = dict(memory)

    def run(self, work: Workspace, observer: Observer) -> Tally:
        """Apply the pass to the mesh once."""
        tally = Tally(self.name)
        start = time.perf_counter()
        self.sweep(work, tally, observer)
        tally.seconds = time.perf_counter() - start
        return tally

    def sweep(self, work: Workspace, tally: Tally, observer: Observer) -> None:
        raise AssertionError("every pass has a sweep of its own")

    def visit(
        self,
        work: Workspace,
        order: Array,
        kernel: Callable[[Array], None],
        tally: Tally,
        observer: Observer,
    ) -> None:
        """Run a kernel over the entities in chunks, making room for cells when it is short."""
        observer.start(self.name, len(order))
        for chunk in work.chunks(order):
            kernel(chunk)
            while tally.counts[Verdict.FULL]:
                # What found no room is no refusal: it is tried again with more.
                tally.counts[Verdict.FULL] = 0
                work.grow()
                kernel(chunk)
            observer.advance(len(chunk))


@dataclass
class Operator(Pass):
    """A pass that visits entities one by one and may change the mesh at each."""

    below: float = option(
        1.0, "visit only where the worst Q is above this; 1: everywhere", least=1.0
    )
    accept: str = option(
        "strict",
        "when a change is taken: the worst Q of its patch falls (strict), does not rise beyond "
        "1/floor of what it was (ratio), does not rise above 1/floor (floor), all cells stay "
        "positive (valid), or the mean Q falls and the worst does not rise above 1/floor, nor "
        "above that of the mesh where this is less (mean)",
        choices=tuple(ACCEPT),
    )
    floor: float = option(
        0.5, "least quality 1/Q, or part of the quality before, that `accept` allows",
        least=0.0, most=1.0,
    )  # fmt: skip
    order: str = option("worst-first", "order of the visits", choices=ORDERS)
    seed: int = option(0, "seed of the random order", least=0)

    @property
    def limit(self) -> float:
        """The q below which an entity is visited."""
        return 1.0 / self.below

    @property
    def rule(self) -> int:
        return ACCEPT[self.accept]

    def least(self, work: Workspace) -> float:
        """The `floor` that the rule goes by: for the mean, no cell becomes the worst of all."""
        return max(self.floor, work.standing().worst) if self.rule == rules.MEAN else self.floor

    def since(self, work: Workspace, key: str) -> int:
        """Clock of the last sweep of this kind, 0 at the first; starts the next one."""
        last = self._since.get(key, 0)
        self._since[key] = work.next_sweep()
        return last

    def ordered(self, work: Workspace, entities: Array, quality: Array) -> Array:
        """The entities in the order of the visits; ties by number."""
        if self.order == "worst-first":
            return entities[np.argsort(quality, kind="stable")]
        if self.order == "random":
            generator = np.random.default_rng([self.seed, int(work.mesh.state[2])])
            return generator.permutation(entities)
        return entities
