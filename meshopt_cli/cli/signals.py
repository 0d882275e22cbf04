"""What signals do: they end a run, remove what is temporary, and say what is written.

They end it where it is. An exception could be lost on the way out, in a callback or while a
module is imported, or be taken for an error of what it comes through.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
from typing import TYPE_CHECKING

# All that is needed when a signal comes: it may come while another module is half imported.
from ..errors import EXIT_HUNG_UP, EXIT_INTERRUPTED, EXIT_TERMINATED
from ..files.ending import between_steps, clean_up, what_is_written

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import FrameType

# What ends a run, the status it leaves, and how it is called.
ENDING = {
    name: (status, what)
    for name, status, what in (
        ("SIGINT", EXIT_INTERRUPTED, "interrupted"),
        ("SIGTERM", EXIT_TERMINATED, "terminated"),
        ("SIGHUP", EXIT_HUNG_UP, "the terminal hung up"),
    )
    if hasattr(signal, name)
}


MOMENT = 0.3  # seconds

_instead: list[Callable[[], bool]] = []


def install() -> None:
    """Let signals end the run, but those that are ignored already, as by nohup."""
    for name in ENDING:
        number = getattr(signal, name)
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _end)


@contextlib.contextmanager
def interrupted_by(action: Callable[[], bool]) -> Iterator[None]:
    """Have the first interrupt do something else, if that is so good as to tell that it did."""
    _instead.append(action)
    try:
        yield
    finally:
        _instead.remove(action)


def ignore() -> None:
    """Let nothing end the run any more, which has ended."""
    for name in ENDING:
        signal.signal(getattr(signal, name), signal.SIG_IGN)


def _end(number: int, _: FrameType | None) -> None:
    if signal.Signals(number).name == "SIGINT" and any(action() for action in _instead):
        return
    between_steps(lambda: _leave(number))


def _leave(number: int) -> None:
    ignore()
    status, what = ENDING[signal.Signals(number).name]
    _end_children()
    clean_up()
    with contextlib.suppress(OSError):
        start = "\r\x1b[K" if os.isatty(2) else ""  # over a bar that is drawn there
        line = f"{start}meshopt: {what}: {what_is_written()}\n"
        os.write(2, line.encode(errors="backslashreplace"))
    os._exit(status)


def _end_children() -> None:
    """End other processes of the run: they may take a moment to remove what is temporary."""
    if (processes := sys.modules.get("multiprocessing")) is not None:
        children = processes.active_children()
        for child in children:
            child.terminate()
        end = time.monotonic() + MOMENT
        for child in children:
            child.join(max(0.0, end - time.monotonic()))
            child.kill()
