"""A pass made of others: swaps and moves that lower the mean, in turns."""

from dataclasses import dataclass, replace
from typing import ClassVar

from meshopt_cli.plugins import PASSES, Pass, Run, Work, option


@dataclass(frozen=True)
class Polish(Pass):
    """Swap and smooth by the mean of what changes, until neither does anything."""

    name: ClassVar[str] = "polish"
    summary: ClassVar[str] = "swap and smooth in turns by the mean Q"
    kernels: ClassVar[tuple[str, ...]] = (*PASSES["swap"].kernels, *PASSES["smooth"].kernels)

    turns: int = option(3, "turns at most", least=1, most=100)

    def sweep(self, work: Work, run: Run) -> None:
        for _ in range(self.turns):
            applied = run.tally.applied
            for name in ("swap", "smooth"):
                replace(PASSES[name](), accept="mean", least_quality=0.1).sweep(work, run)
            if run.tally.applied == applied:
                break
