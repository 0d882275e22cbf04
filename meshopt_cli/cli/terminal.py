"""What is said besides the product: log lines, progress, notices. All of it on stderr."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import click

from ..errors import shown

if TYPE_CHECKING:
    from rich.console import Console

    from ..passes import Observer


def say(message: str) -> None:
    """Show a line on stderr."""
    click.echo(f"meshopt: {shown(message)}", err=True)


class StderrHandler(logging.Handler):
    """Shows log records as lines such as `warning: ...`."""

    def emit(self, record: logging.LogRecord) -> None:
        level = "" if record.levelno < logging.WARNING else f"{record.levelname.lower()}: "
        say(f"{level}{record.getMessage()}")


def set_up_log(verbosity: int) -> None:
    """Send the log to stderr: errors only (-1), warnings (0), or everything (1)."""
    log = logging.getLogger("meshopt")
    log.handlers[:] = [StderrHandler()]
    log.propagate = False
    levels = {-1: logging.ERROR, 0: logging.WARNING}
    log.setLevel(levels.get(verbosity, logging.INFO))


def is_plain(err: bool = False) -> bool:
    """Whether stdout, or stderr, must do without blocks and colours."""
    encoding = (getattr(sys.stderr if err else sys.stdout, "encoding", None) or "ascii").lower()
    return not encoding.startswith("utf") or os.environ.get("TERM") == "dumb"


def report_console(err: bool = False) -> Console:
    """Where a report goes, with colours on a terminal only, and wide enough in a pipe."""
    from rich.console import Console

    return Console(
        stderr=err,
        width=None if (sys.stderr if err else sys.stdout).isatty() else 120,
        color_system=None if os.environ.get("NO_COLOR") else "auto",
        highlight=False,
        emoji=False,
        markup=False,
    )


class Bars:
    """An observer that shows a bar for each sweep."""

    def __init__(self) -> None:
        self._bar = None

    def started(self, name: str, total: int) -> None:
        from tqdm import tqdm

        self.close()
        self._bar = tqdm(total=total, desc=name, leave=False, file=sys.stderr, unit=" visits")

    def advanced(self, by: int) -> None:
        if self._bar is not None:
            self._bar.update(by)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None


@contextlib.contextmanager
def progress(quiet: bool) -> Iterator[Observer]:
    """Bars on a terminal, nothing elsewhere."""
    from ..passes import Silent

    if quiet or not sys.stderr.isatty():
        yield Silent()
        return
    bars = Bars()
    try:
        yield bars
    finally:
        bars.close()


def compile_kernels(quiet: bool, groups: Iterable[str] = ("basic",)) -> None:
    """Compile what is missing of some groups of kernels, and say so, for it takes a while."""
    from ..compiled.ways import missing

    if not missing(groups):
        return
    if not quiet:
        from ..compiled.cache import is_lasting
        from ..compiled.library import opened
        from ..compiled.ways import Way, way

        time = "under a minute" if way() is Way.NATIVE else "a few minutes"
        often = "once on this machine" if is_lasting() else "for this run alone"
        why = f"; those of this package are not used: {opened().unfit}" if opened().unfit else ""
        click.echo(f"meshopt: compiling kernels, {often} ({time}){why}", err=True)
    from ..warmup import compile_groups

    compile_groups(groups)
