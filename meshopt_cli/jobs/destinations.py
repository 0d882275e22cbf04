"""Where the results of many inputs go."""

from __future__ import annotations

import string
from collections.abc import Sequence
from pathlib import Path

from ..errors import ConfigError, hint
from ..formats import extension


def _suffix(path: Path) -> str:
    """What a name ends in, that of a compressed file with `.gz`."""
    end = extension(path)
    at = path.name.lower().rfind(end) if end else -1
    return path.name[at:] if at > 0 else ""


# What a pattern may hold, and what it stands for.
PARTS = {
    "stem": lambda path: path.name[: -len(_suffix(path))] if _suffix(path) else path.name,
    "suffix": _suffix,
    "name": lambda path: path.name,
    "parent": lambda path: str(path.parent),
}


def is_pattern(place: Path | None) -> bool:
    """Whether a name of an output has parts of the name of its input in it."""
    return place is not None and "{" in str(place)


def destinations(
    inputs: Sequence[Path], folder: Path | None, pattern: Path | None
) -> list[tuple[Path, Path]]:
    """The place of the result for each of many inputs.

    An input that is the place of another one's result was made by an earlier run, and is left out.

    Parameters
    ----------
    folder : Path, optional
        Where results go by the names of their inputs, or by the pattern.
    pattern : Path, optional
        Such as ``{stem}.opt{suffix}``, with `PARTS`; without a folder in it, beside the input.

    Returns
    -------
    list of (input, place)

    Raises
    ------
    ConfigError
        The pattern has other parts, or two results would have one place.
    """
    places = {path: _place(path, folder, pattern) for path in inputs}
    made = {place for path, place in places.items() if path != place}
    kept = [(path, place) for path, place in places.items() if path not in made]
    seen: dict[Path, Path] = {}
    for path, place in kept:
        if place in seen:
            raise ConfigError(f"{seen[place]} and {path} would both be written to {place}")
        seen[place] = path
    return kept


def _place(path: Path, folder: Path | None, pattern: Path | None) -> Path:
    if pattern is None:
        name = path.name
    else:
        values = {part: value(path) for part, value in PARTS.items()}
        try:
            fields = [field for _, field, _, _ in string.Formatter().parse(str(pattern))]
        except ValueError as error:
            raise ConfigError(f"--output {pattern}: {error}") from None
        for field in fields:
            if field is not None and field not in PARTS:
                raise ConfigError(f"--output {pattern}: no part {field!r}{hint(field, PARTS)}")
        name = str(pattern).format(**values)
    if folder is not None:
        return folder / name
    return path.parent / name if Path(name).name == name else Path(name)
