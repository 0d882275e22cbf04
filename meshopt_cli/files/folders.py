"""A folder that is there with all its files, or as it was before."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from ..errors import WriteError, reason
from .ending import note_written, temporary, undivided


def require_own_folder(path: Path, is_own: Callable[[str], bool]) -> None:
    """Refuse to replace a folder that has other files than those that are written anew.

    Parameters
    ----------
    is_own : function of a name
        Whether a file that is called so is one of them.

    Raises
    ------
    WriteError
    """
    if path.exists() and not path.is_dir():
        raise WriteError(f"{path}: cannot be written: it is no folder")
    others = sorted(p.name for p in path.iterdir() if not is_own(p.name)) if path.exists() else []
    if others:
        raise WriteError(
            f"{path}: it has other files in it, such as {others[0]}: name another place"
        )


@contextlib.contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """Give a folder to write files to, which then takes the place of another.

    Raises
    ------
    WriteError
    """
    mark = os.urandom(8).hex()
    new, old = (path.with_name(f"{path.name}.{mark}.{end}") for end in ("new", "old"))
    with temporary(new):
        try:
            new.mkdir()
            yield new
            with undivided():
                if path.exists():
                    path.rename(old)
                try:
                    new.rename(path)
                except OSError:
                    if old.exists():
                        old.rename(path)
                    raise
                note_written(path)
        except OSError as error:
            raise WriteError(f"{path}: cannot be written: {reason(error)}") from error
    shutil.rmtree(old, ignore_errors=True)
