"""The content of a report, whatever it is written as."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ..cells import FAMILIES
from ..errors import shown
from ..mesh.tags import Regions
from ..quality.statistics import Statistic
from ..quality.summary import Summary

if TYPE_CHECKING:  # seldom met
    from ..metric.summary import MetricSummary


@dataclass(frozen=True)
class FileFacts:
    """A file that was read or written."""

    path: str
    format: str
    sha256: str


@dataclass(frozen=True)
class PassFacts:
    """What one pass did in one round, and how the mesh stood after it."""

    round: int
    name: str
    visited: int
    applied: int
    refused: dict[str, int]
    seconds: float
    worst: float
    mean: float
    kinds: dict[str, dict[str, int]] = field(default_factory=dict)  # see `passes.Tally`


@dataclass(frozen=True)
class Picture:
    """A picture of a mesh, or of some of it.

    Attributes
    ----------
    png : bytes
        Transparent where there is nothing.
    width, height : int
        In pixels.
    words : str
        What it shows.
    """

    png: bytes
    width: int
    height: int
    words: str


@dataclass(frozen=True)
class Pictures:
    """What a report shows besides figures.

    Attributes
    ----------
    wholes : tuple of Picture
        Of the mesh, or of it before and after, as many of each.
    worst : tuple of tuples of Picture
        Of each of these, its worst cells with their surroundings, the very worst first.
    title : str
        What colours tell.
    colours : tuple of str
        As "#rrggbb", from the worst to the best.
    ticks : tuple of (float, str)
        Places among them, from 0 to 1, with the values there.
    missing : str
        Why there are none.
    """

    wholes: tuple[Picture, ...] = ()
    worst: tuple[tuple[Picture, ...], ...] = ()
    title: str = ""
    colours: tuple[str, ...] = ()
    ticks: tuple[tuple[float, str], ...] = ()
    missing: str = ""


@dataclass(frozen=True)
class Report:
    """All that is said of one run, or of two meshes that are compared, the one as if it had been
    made of the other; of a mesh that was only looked at, the first part."""

    version: str
    input: FileFacts
    before: Summary
    output: FileFacts | None = None
    after: Summary | None = None
    passes: tuple[PassFacts, ...] = ()
    stopped: str = ""
    seconds: dict[str, float] = field(default_factory=dict)
    regions: Regions = Regions((), 1)  # noqa: RUF009 (a frozen value)
    lost: tuple[str, ...] = ()  # what did not go over, on reading, working or writing
    left_out: tuple[str, ...] = ()  # passes that are for other cells
    statistics: tuple[Statistic, ...] = ()  # of the measures that were asked for
    notes: tuple[str, ...] = ()  # what of a mesh that was looked at is measured otherwise, or not
    command: str = ""  # the words that the program was called with, as a shell takes them
    metric: MetricSummary | None = None  # of a mesh that was judged by one
    statistics_after: tuple[Statistic, ...] = ()  # of the second of two meshes that are compared
    metric_after: MetricSummary | None = None  # and of what was made of it
    pictures: Pictures | None = None  # where they are asked for

    @property
    def is_comparison(self) -> bool:
        """Whether it is on two meshes, and not on a run."""
        return self.after is not None and not (self.stopped or self.seconds)

    @property
    def name(self) -> str:
        """The file, or two that are compared, without their folders."""
        name = shown(Path(self.input.path).name)
        if self.is_comparison and self.output is not None:
            return f"{shown(Path(self.output.path).name)} against {name}"
        return name

    @property
    def title(self) -> str:
        """The line above the table: file, cells, vertices, measure."""
        summary = self.before
        source = f" ({summary.equation})" if summary.equation else ""
        return (
            f"{self.name}: {_cells_of(summary)}, "
            f"{summary.n_points:,} vertices, {summary.measure.replace('-', ' ')}{source}"
        )


def _cells_of(summary: Summary) -> str:
    """How many cells a mesh has, and of which families."""
    if not summary.parts:
        return FAMILIES[summary.family].counted(summary.n_cells)
    return f"{summary.n_cells:,} cells ({', '.join(map(_cells_of, summary.parts))})"
