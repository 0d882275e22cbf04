"""Files of options in TOML: reading them, and what is said of a key that is none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import ConfigError

LARGEST = 10_000_000  # bytes; devices have no end


def read_text(path: Path) -> str:
    """The text of a file of options.

    Raises
    ------
    ConfigError
        It cannot be read, or is no text.
    """
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise ConfigError(f"{path}: larger than any file of options ({LARGEST:,} bytes)")
        # Some editors put a mark before the first letter.
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not UTF-8 text") from error


def tables_of(path: Path, text: str) -> dict[str, Any]:
    """All that the text of a file says.

    Raises
    ------
    ConfigError
        It is not TOML.
    """
    import tomllib

    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: not valid TOML: {error}") from error
    except ValueError as error:
        raise ConfigError(f"{path}: not valid TOML: a number has too many digits") from error
    except RecursionError as error:
        raise ConfigError(f"{path}: not valid TOML: lists or tables lie too deep") from error


def read_toml(path: Path) -> dict[str, Any]:
    """All that a file says; errors as those of `read_text` and `tables_of`."""
    return tables_of(path, read_text(path))


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
            if not is_file(path):
                continue
            table: Any = read_toml(path)
            for key in keys:
                table = table.get(key) if isinstance(table, dict) else None
            if isinstance(table, dict):
                return path, table
            if table is not None:
                raise ConfigError(f"{path}: [{'.'.join(keys)}] must be a table")
    return None


def is_file(path: Path) -> bool:
    """Whether there is a file that may be looked at."""
    try:
        return path.is_file()
    except OSError:  # what may not be looked at is not there
        return False
