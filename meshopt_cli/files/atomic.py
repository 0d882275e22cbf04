"""Files that are there as a whole, or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from .ending import note_written, temporary, undivided
from .sweep import hold, sweep

PREFIX = ".meshopt-"


def target_of(path: Path) -> Path:
    """The file that is to be written or replaced, behind symbolic links.

    Raises
    ------
    OSError
        It, or its folder, cannot be written to.
    """
    target = Path(os.path.realpath(path))
    if target.exists():
        if target.is_dir():
            raise OSError("it is a folder")
        if not target.is_file():
            raise OSError("it is not a regular file")
        if not os.access(target, os.W_OK):
            raise OSError("it is write-protected")
    elif not target.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "no such folder")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, "permission denied in its folder")
    return target


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give the path of an empty file to write to, which then takes the place of another.

    That one is found through symbolic links and hands its permissions on, and its owner
    and group where that is allowed: see `_hand_on`. It stays as it
    was if anything fails, with an OSError if it or its folder cannot be written to. What runs
    that were killed left in the folder is removed.
    """
    target = target_of(path)
    sweep(target.parent, PREFIX)
    old = target.stat() if target.exists() else None
    with temporary(target.with_name(f"{PREFIX}{os.urandom(8).hex()}")) as place:
        # Nobody else may read it before it has the permissions of the one it replaces.
        mode = 0o666 if old is None else 0o600
        held = os.open(place, os.O_RDWR | os.O_CREAT | os.O_EXCL, mode)
        try:
            hold(held)
            yield place
            os.fsync(held)
            if old is not None:
                _hand_on(old, held)
            with undivided():
                os.replace(place, target)
                note_written(path)
        finally:
            os.close(held)


def _hand_on(old: os.stat_result, file: int) -> None:
    """Give a new file the owner, the group and the permissions of the one it replaces.

    Where it cannot have them, what these allowed others is not allowed either: writing, where
    the owner is another; and whatever the group might do, where the group is.
    """
    mode = stat.S_IMODE(old.st_mode) & 0o777  # it does not run as somebody else
    if hasattr(os, "fchown"):
        with contextlib.suppress(OSError):
            os.fchown(file, -1, old.st_gid)
        with contextlib.suppress(OSError):
            os.fchown(file, old.st_uid, -1)
        new = os.fstat(file)
        if new.st_uid != old.st_uid:
            mode &= ~0o022
        if new.st_gid != old.st_gid:
            mode &= ~0o070 | mode << 3
    if hasattr(os, "fchmod"):
        os.fchmod(file, mode)
