"""The files that a user means by names of files, folders and patterns."""

from __future__ import annotations

import glob
from collections.abc import Iterable
from pathlib import Path

from ..errors import ReadError
from ..files.atomic import PREFIX
from ..formats import FORMATS, extension


def files_in(paths: Iterable[Path]) -> list[Path]:
    """The files that paths stand for: those of folders, and those that patterns match.

    Raises
    ------
    ReadError
        A folder without meshes, or a pattern that nothing matches.
    """
    found: dict[Path, None] = {}
    for path in paths:
        if path.is_dir():
            inside = [p for p in sorted(path.rglob("*")) if _is_mesh(p)]
            if not inside:
                raise ReadError(f"{path}: the folder holds no mesh file")
        elif glob.has_magic(str(path)) and not path.exists():
            inside = [Path(name) for name in sorted(glob.glob(str(path), recursive=True))]
            inside = [p for p in inside if p.is_file()]
            if not inside:
                raise ReadError(f"{path}: no file matches")
        else:
            inside = [path]
        found.update(dict.fromkeys(inside))
    return list(found)


def _is_mesh(path: Path) -> bool:
    """Whether a file is named like a mesh, compressed or not, and no run is just writing it."""
    known = any(extension(path) in row.extensions for row in FORMATS.whole().values())
    return known and path.is_file() and not path.name.startswith(PREFIX)
