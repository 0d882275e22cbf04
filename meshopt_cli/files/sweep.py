"""What runs that were killed left behind, told by that nobody holds it, and removed."""

from __future__ import annotations

import contextlib
import os
import stat
import time
from pathlib import Path

try:
    import fcntl
except ImportError:  # not on Windows, where what dead runs left stays
    fcntl = None  # type: ignore[assignment]

NEWBORN = 5.0  # seconds in which what is empty may be about to be held
_LOOK = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)


def hold(file: int) -> bool:
    """Hold a file or a folder for as long as it is open; whether no other run does."""
    if fcntl is None:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def sweep(folder: Path, prefix: str) -> None:
    """Remove from a folder files and folders of this user, of a prefix, that no run holds."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for path in [entry.path for entry in entries if entry.name.startswith(prefix)]:
            with contextlib.suppress(OSError):
                _remove_if_left(path)


def _remove_if_left(path: str) -> None:
    file = os.open(path, _LOOK)
    try:
        found = os.fstat(file)
        is_folder = stat.S_ISDIR(found.st_mode)
        if found.st_uid != os.geteuid() or not (is_folder or stat.S_ISREG(found.st_mode)):
            return
        is_empty = not os.listdir(file) if is_folder else not found.st_size
        newborn = is_empty and abs(time.time() - found.st_mtime) < NEWBORN
        if newborn or not hold(file):
            return
        if is_folder:
            import shutil

            shutil.rmtree(path, ignore_errors=True)
        else:
            os.unlink(path)
    finally:
        os.close(file)
