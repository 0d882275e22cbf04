"""The places that a run writes to: whether they can be written, each for itself."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from ..errors import ConfigError, WriteError, reason
from .sink import PIPE, is_stream, require_place


def require_places(
    outputs: Iterable[Path], inputs: Iterable[Path], replaced: Iterable[Path] = ()
) -> None:
    """Find out before anything is read whether all outputs can be written.

    Parameters
    ----------
    replaced : iterable of Path
        Inputs that may be written over.

    Raises
    ------
    ConfigError
        An output is an input, or the same file as another one.
    WriteError
        One cannot be written.
    """
    inputs, replaced, seen = list(inputs), list(replaced), list[Path]()
    for path in outputs:
        for other in seen:
            if _is_one(path, other):
                name = "stdout" if path == PIPE else str(path)
                raise ConfigError(f"{name}: two things cannot be written to one place")
        if not any(_is_one(path, other) for other in replaced):
            for other in inputs:
                if _is_one(path, other) and not is_stream(path):
                    raise ConfigError(f"{path} is an input itself: choose another name")
        require_writable(path)
        seen.append(path)


def require_writable(path: Path) -> None:
    """Find out ahead whether something can be written, as far as that can be told.

    Raises
    ------
    WriteError
        With one line that says what is wrong.
    """
    try:
        require_place(path)
    except OSError as error:
        raise WriteError(f"{path}: cannot be written: {reason(error)}") from error


def _is_one(a: Path, b: Path) -> bool:
    """Whether two paths are one file, behind links and whether it exists or not."""
    if PIPE in (a, b):
        return a == b
    if a == b:
        return not str(a).startswith("/dev/null")
    try:
        if os.path.exists(a) and os.path.exists(b):
            return os.path.samefile(a, b) and not is_stream(a)
        return os.path.realpath(a) == os.path.realpath(b)
    except OSError:
        return False
