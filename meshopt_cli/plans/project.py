"""The files of a project that say what holds for its meshes."""

from __future__ import annotations

from pathlib import Path

from .presets import parts_of
from .sources import Settled, read_source
from .toml import is_file

# Where the table stands in each; of two in one folder the later wins.
FILES: dict[str, tuple[str, ...]] = {"meshopt.toml": (), "pyproject.toml": ("tool", "meshopt")}


def found_in(folder: Path) -> Settled:
    """What the nearest files say, from a folder upwards; those that say nothing are passed over.

    Raises
    ------
    ConfigError
        A file on the way cannot be read, or something in its table is wrong.
    """
    for place in (folder, *folder.parents):
        holds = Settled()
        for name, keys in FILES.items():
            if is_file(place / name):
                holds = holds.then(read_source(place / name, parts_of, keys) or Settled())
        if holds.values:
            return holds
    return Settled()
