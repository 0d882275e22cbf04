"""repair: what is wrong with the mesh of a file, mended before it is taken to be worked on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ..work.session import Workspace
from .base import Pass, option
from .run import Run

YES = "yes"


def _asked(what: str) -> Any:
    return option(YES, f"whether to {what}", choices=(YES, "no"))


@dataclass(frozen=True)
class Repair(Pass):
    """Mend the mesh that was read, once, wherever the pass stands in a pipeline.

    Its options are the mends of `repair.MENDS`, by their names. What is worked on is whole: there
    is nothing in it to mend.
    """

    name: ClassVar[str] = "repair"
    summary: ClassVar[str] = "mends the mesh that was read, before all other passes"

    merge: str = _asked("make one of the points in one place")
    duplicates: str = _asked("drop cells with the vertices of another")
    flat: str = _asked("drop cells without content")
    orientation: str = _asked("turn cells so that neighbours agree")
    fill: str = _asked("add cells where one cell is missing")
    facets: str = _asked("drop declared facets that bound no cell")
    unused: str = _asked("drop points that no cell has")
    tolerance: float = option(
        0.0, "part of the extent within which points are in one place; 0: what the precision of "
        "the coordinates says", least=0.0, most=0.1,
    )  # fmt: skip

    def asks_for(self, mend: str) -> bool:
        """Whether one of the mends is to be made."""
        return bool(getattr(self, mend) == YES)

    def sweep(self, work: Workspace, run: Run) -> None:
        """Leave the working mesh as it is."""
