"""What a run leaves behind, however it ends: whole files, no temporary ones, and the truth.

A signal may come between any two steps, and ends the run where it is. So what is temporary is
noted before it is made, and what was written as soon as it is there.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

PREFIX = "meshopt-run-"  # of folders for temporary files

_temporary: set[Path] = set()
_written: list[Path] = []
_endings: list[Callable[[], object]] = []
_undivided = 0
_waiting: list[Callable[[], None]] = []


def begin() -> None:
    """Note that nothing is written yet."""
    _written.clear()


def note_written(path: Path) -> None:
    """Note that a file is there, whole."""
    _written.append(path)


def is_anything_written() -> bool:
    return bool(_written)


def what_is_written() -> str:
    """What of the run is there, in words."""
    names = " and ".join(map(str, _written))
    return f"{names} {'is' if len(_written) == 1 else 'are'} written" if names else NOTHING


NOTHING = "nothing is written"


@contextlib.contextmanager
def temporary(path: Path) -> Iterator[Path]:
    """See to it that a file or a folder is gone in the end, and when the run is ended."""
    _temporary.add(path)
    try:
        yield path
    finally:
        _remove(path)
        _temporary.discard(path)


@contextlib.contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder for files that nobody else sees, which goes with them."""
    import tempfile
    from pathlib import Path

    from .sweep import hold, sweep

    parent = Path(tempfile.gettempdir())
    sweep(parent, PREFIX)
    with temporary(parent / f"{PREFIX}{os.urandom(8).hex()}") as path:
        path.mkdir(mode=0o700)
        held = os.open(path, os.O_RDONLY) if os.name == "posix" else None
        try:
            if held is not None:
                hold(held)
            yield path
        finally:
            if held is not None:
                os.close(held)


def note_temporary(path: Path) -> None:
    """Note that something is to be gone when the run is ended; it goes by itself else."""
    _temporary.add(path)


@contextlib.contextmanager
def ended_by(action: Callable[[], object]) -> Iterator[None]:
    """Have something done if the run is ended meanwhile."""
    _endings.append(action)
    try:
        yield
    finally:
        _endings.remove(action)


def clean_up() -> None:
    """Do all that is to be done, and remove what is temporary, for a run that ends here."""
    for action in list(_endings):
        action()
    for path in list(_temporary):
        _remove(path)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        import shutil

        shutil.rmtree(path, ignore_errors=True)
    else:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)


@contextlib.contextmanager
def undivided() -> Iterator[None]:
    """Steps that nothing comes between: what a signal wants done waits for their end."""
    global _undivided  # noqa: PLW0603
    _undivided += 1
    try:
        yield
    finally:
        _undivided -= 1
        if not _undivided and _waiting:
            _waiting.pop()()


def between_steps(action: Callable[[], None]) -> None:
    """Do something now, or after the steps that must not be divided."""
    if _undivided:
        _waiting.append(action)
    else:
        action()
