"""Files of options in TOML: reading them, and what is said of a key that is none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import ConfigError


def read_toml(path: Path) -> dict[str, Any]:
    """All that a file holds.

    Raises
    ------
    ConfigError
        It cannot be read, or is not TOML.
    """
    import tomllib

    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "is not UTF-8 text"
        raise ConfigError(f"{path}: {reason}") from error
    except ValueError as error:  # TOMLDecodeError, and that of a number too long for Python
        raise ConfigError(f"{path}: not valid TOML: {error}") from error


def nearest_table(
    folder: Path, places: Mapping[str, tuple[str, ...]]
) -> tuple[Path, dict[str, Any]] | None:
    """The nearest file with a table of options, from a folder upwards, and that table.

    Parameters
    ----------
    places : mapping of str to tuple of str
        Where the table stands in the files of each name; in one folder the first name wins.

    Raises
    ------
    ConfigError
        A file on the way cannot be read, is not TOML, or has something else in that place.
    """
    for place in (folder, *folder.parents):
        for name, keys in places.items():
            path = place / name
            if not path.is_file():
                continue
            table: Any = read_toml(path)
            for key in keys:
                table = table.get(key) if isinstance(table, dict) else None
            if isinstance(table, dict):
                return path, table
            if table is not None:
                raise ConfigError(f"{path}: [{'.'.join(keys)}] must be a table")
    return None
