"""Lines that show how far a run is: with tqdm, on terminals and in notebooks, and with rich."""

from __future__ import annotations

import contextlib
import math
import sys
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, TextIO

from .watch import Progress, Told

if TYPE_CHECKING:
    from tqdm import tqdm

LATE = 0.5  # seconds; what is done sooner shows nothing
PARTS = 100  # of a bar


def words(progress: Progress) -> str:
    """What is said before the bar: the stage, or the pass and its round, and the worst Q."""
    if not progress.step:
        return progress.stage
    told = f"round {progress.round}  " if progress.round else ""
    return f"{told}{progress.step}  worst Q {progress.worst:.4g}"


@contextlib.contextmanager
def tqdm_progress(file: TextIO | None = None, plain: bool = False) -> Iterator[Told]:
    """One line by tqdm, which is gone at the end: stage, pass, worst Q, share done, what is left.

    Parameters
    ----------
    file : text file, optional
        Where it goes, instead of stderr.
    plain : bool
        Whether the bar is made of ASCII characters alone.

    Examples
    --------
    >>> with tqdm_progress() as progress:  # doctest: +SKIP
    ...     meshopt.optimize("in.vtu", progress=progress)
    """
    bar: tqdm | None = None
    latest: Progress | None = None
    is_late = False

    def told(progress: Progress) -> None:
        nonlocal bar, latest
        latest = progress
        if not is_late:
            return
        form = "{desc} ..."
        if progress.step:
            form = f"{{desc}}  {{percentage:3.0f}}%|{{bar:20}}|{_left(progress)}"
        if bar is None:
            from tqdm import tqdm

            bar = tqdm(total=PARTS, leave=False, file=file or sys.stderr, dynamic_ncols=True,
                       ascii=plain or None, bar_format=form, desc=words(progress))  # fmt: skip
        bar.bar_format = form
        bar.n = PARTS * progress.share
        bar.set_description_str(words(progress), refresh=False)
        bar.refresh()

    def begin() -> None:
        """Show what goes on by now, of which nothing else may be told for a while."""
        nonlocal is_late
        is_late = True
        if latest is not None:
            told(latest)

    timer = threading.Timer(LATE, begin)
    timer.daemon = True
    timer.start()
    try:
        yield told
    finally:
        timer.cancel()
        timer.join()
        if bar is not None:
            bar.close()


@contextlib.contextmanager
def tqdm_pieces(file: TextIO, plain: bool) -> Iterator[Callable[[str, int, int, float], None]]:
    """One line by tqdm for a mesh in pieces: the step, how many pieces are done of how many, how
    many a second, what is left, and the worst Q."""
    bar: tqdm | None = None

    def told(what: str, done: int, n: int, worst: float) -> None:
        nonlocal bar
        if bar is None or bar.desc != f"{what}: ":
            from tqdm import tqdm

            if bar is not None:
                bar.close()
            bar = tqdm(total=n, initial=done - 1, desc=what, file=file, unit="piece", leave=False,
                       ascii=plain or None, dynamic_ncols=True)  # fmt: skip
        bar.n = done
        bar.set_postfix_str("" if math.isnan(worst) else f"worst Q {worst:.4g}", refresh=False)
        bar.refresh()

    try:
        yield told
    finally:
        if bar is not None:
            bar.close()


@contextlib.contextmanager
def rich_progress() -> Iterator[Told]:
    """A bar by rich, which stays at the end: stage, pass, worst Q, share done, what is left.

    Examples
    --------
    >>> with rich_progress() as progress:  # doctest: +SKIP
    ...     meshopt.optimize("in.vtu", progress=progress)
    """
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn
    from rich.progress import Progress as Bars

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
    with Bars(*columns, TextColumn("{task.fields[left]}")) as bars:
        task = bars.add_task("", total=PARTS, left="")

        def told(progress: Progress) -> None:
            done = PARTS * progress.share
            bars.update(task, description=words(progress), completed=done, left=_left(progress))

        yield told


def _left(progress: Progress) -> str:
    """How long the sweep takes still, in words."""
    if math.isnan(progress.left):
        return ""
    minutes, seconds = divmod(round(progress.left), 60)
    return f" {minutes}:{seconds:02d} left"
