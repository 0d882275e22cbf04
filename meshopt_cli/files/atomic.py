"""Files that are there as a whole, or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
from collections.abc import Iterator
from pathlib import Path


def target_of(path: Path) -> Path:
    """The file that is to be written or replaced, behind symbolic links.

    Raises
    ------
    OSError
        It, or its folder, cannot be written to.
    """
    target = Path(os.path.realpath(path))
    if target.exists():
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
    and group where that is allowed. It stays as it
    was if anything fails, with an OSError if it or its folder cannot be written to.
    """
    target = target_of(path)
    temporary = target.with_name(f".meshopt-{os.urandom(8).hex()}")
    try:
        temporary.open("xb").close()
        yield temporary
        with temporary.open("rb+") as stream:
            os.fsync(stream.fileno())
        if target.exists():
            old = target.stat()
            with contextlib.suppress(OSError):
                os.chown(temporary, old.st_uid, old.st_gid)
            shutil.copymode(target, temporary)
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
