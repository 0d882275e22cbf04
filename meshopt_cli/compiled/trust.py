"""Whose files may be run as machine code: those that nobody else can have put there."""

from __future__ import annotations

import os
import stat
from pathlib import Path

_ROOT = 0
_OTHERS, _GROUP = stat.S_IWOTH, stat.S_IWGRP


def is_ours(found: os.stat_result) -> bool:
    """Whether a file or a folder belongs to this user, or root, and nobody else can write it."""
    if not hasattr(os, "geteuid"):  # Windows has other means, and asks them itself
        return True
    if found.st_uid not in (os.geteuid(), _ROOT) or found.st_mode & _OTHERS:
        return False
    return not found.st_mode & _GROUP or _is_private(found.st_gid)


def is_safe(folder: Path) -> bool:
    """Whether nobody else can put anything into a folder, or another one in its place.

    Of one that is not there yet, it is those above it that count.
    """
    try:
        real = Path(os.path.realpath(folder))
        there = [path for path in (real, *real.parents) if os.path.isdir(path)]
        if there[0] == real and not is_ours(real.stat()):
            return False
        return all(_keeps(path.stat()) for path in there if path != real)
    except (OSError, IndexError):
        return False


def _keeps(parent: os.stat_result) -> bool:
    """Whether what is ours in a folder stays there: in one for all, as /tmp, it does."""
    if is_ours(parent):
        return True
    return bool(parent.st_mode & stat.S_ISVTX) and parent.st_uid in (os.geteuid(), _ROOT)


def _is_private(group: int) -> bool:
    """Whether nobody but this user is in a group, as in those that systems make for each user."""
    import grp
    import pwd

    try:
        found, user = grp.getgrgid(group), pwd.getpwuid(os.geteuid())
    except KeyError:
        return False
    return found.gr_name == user.pw_name and set(found.gr_mem) <= {user.pw_name}


def is_closed(folder: Path) -> bool:
    """Whether a folder is this user's, others may not enter it, and it has no links, pipes, ...

    What they could write in it otherwise is safe from them, and opening it waits for nothing.
    """
    try:
        found = os.lstat(folder)
        mine = not hasattr(os, "geteuid") or (
            found.st_uid == os.geteuid() and not found.st_mode & (stat.S_IRWXG | stat.S_IRWXO)
        )
        return stat.S_ISDIR(found.st_mode) and mine and all(map(_is_plain, folder.rglob("*")))
    except OSError:
        return False


def _is_plain(path: Path) -> bool:
    mode = os.lstat(path).st_mode
    return stat.S_ISREG(mode) or stat.S_ISDIR(mode)


def read(path: Path) -> bytes | None:
    """What a file holds, if it is a regular one and `is_ours`; None without it."""
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    try:
        file = os.open(path, flags | getattr(os, "O_BINARY", 0))
    except OSError:
        return None
    try:
        found = os.fstat(file)
        if not stat.S_ISREG(found.st_mode) or not is_ours(found):
            return None
        with open(file, "rb", closefd=False) as stream:
            return stream.read()
    except OSError:
        return None
    finally:
        os.close(file)
