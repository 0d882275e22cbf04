"""What is said besides the product: log lines, progress, notices. All of it on stderr."""

from __future__ import annotations

import contextlib
import logging
import math
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import WriteError, reason, shown

if TYPE_CHECKING:
    from rich.console import Console

    from ..progress.watch import Watch


SAID = "is_said"  # of records that are printed otherwise
OFTEN = 0.1  # seconds after which a line on a terminal changes


def say(message: str) -> None:
    """Show a line on stderr, above the one that shows how far the run is."""
    line = f"meshopt: {shown(message)}"
    if (tqdm := sys.modules.get("tqdm")) is None:
        click.echo(line, err=True)
    else:
        tqdm.tqdm.write(line, file=sys.stderr)


class StderrHandler(logging.Handler):
    """Shows log records as lines such as `warning: ...`, unless they are said otherwise."""

    def emit(self, record: logging.LogRecord) -> None:
        if getattr(record, SAID, False):
            return
        level = "" if record.levelno < logging.WARNING else f"{record.levelname.lower()}: "
        say(f"{level}{record.getMessage()}")


def set_up_log(verbosity: int, file: Path | None = None) -> None:
    """Send the log to stderr: errors only (-1), warnings (0), or more (1).

    Parameters
    ----------
    file : Path, optional
        Where all of it is added, with the time, and a line for each run of each pass.

    Raises
    ------
    WriteError
        The file cannot be written.
    """
    shown = StderrHandler({-1: logging.ERROR, 0: logging.WARNING}.get(verbosity, logging.INFO))
    handlers: list[logging.Handler] = [shown]
    if file is not None:
        try:
            kept = logging.FileHandler(file, encoding="utf-8", errors="backslashreplace")
        except OSError as error:
            raise WriteError(f"{file}: cannot be written: {reason(error)}") from error
        kept.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
        handlers.append(kept)
    log = logging.getLogger("meshopt")
    for old in log.handlers:
        old.close()
    log.handlers[:] = handlers
    log.propagate = False
    log.setLevel(min(handler.level for handler in handlers) or logging.DEBUG)


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


@contextlib.contextmanager
def progress(quiet: bool) -> Iterator[Watch]:
    """What watches a run: for a line on a terminal, and silently elsewhere."""
    from ..progress.watch import Watch

    if quiet or not sys.stderr.isatty():
        yield Watch(lambda _: None, math.inf)
        return
    from ..progress.lines import tqdm_progress

    with tqdm_progress(sys.stderr, is_plain(err=True)) as told:
        yield Watch(told, OFTEN)


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
