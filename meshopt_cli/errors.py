"""The errors that a user can cause, each with the exit status it stands for.

Every one of them is shown as a single line; anything else that reaches the
command line is a bug of ours and ends with `EXIT_INVARIANT`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from pathlib import Path

EXIT_DONE = 0
EXIT_BAD_MESH = 1
EXIT_USAGE = 2
EXIT_FILES = 3
EXIT_INVARIANT = 4
EXIT_HUNG_UP = 129
EXIT_INTERRUPTED = 130
EXIT_PIPE = 141
EXIT_TERMINATED = 143


class MeshoptError(Exception):
    """Base of all errors with a message meant for the user."""

    exit_status = EXIT_INVARIANT


class BadMeshError(MeshoptError):
    """The file was read, and the mesh in it is not one that can be worked on."""

    exit_status = EXIT_BAD_MESH


class ConfigError(MeshoptError):
    """A wrong option, pipeline file, or combination of them."""

    exit_status = EXIT_USAGE


class ReadError(MeshoptError):
    """A file cannot be read, or holds no kind of mesh this tool knows."""

    exit_status = EXIT_FILES


class UnsupportedMeshError(ReadError):
    """The file was read, and its cells are of a kind that cannot be optimized."""


class WriteError(MeshoptError):
    """A file cannot be written."""

    exit_status = EXIT_FILES


class NoReaderError(WriteError):
    """Whoever read stdout went away."""


class InterruptError(MeshoptError):
    """The user stopped the run: nothing is written."""

    exit_status = EXIT_INTERRUPTED


class InvariantError(MeshoptError):
    """A promise of this tool broke: nothing is written."""

    exit_status = EXIT_INVARIANT


Row = TypeVar("Row")


def chosen(table: Mapping[str, Row], name: str, what: str) -> Row:
    """The row of a table that a user names.

    Parameters
    ----------
    what : str
        What its rows are: "preset", "measure".

    Raises
    ------
    ConfigError
        There is none of this name: the message says which one may be meant.
    """
    if name not in table:
        raise ConfigError(f"no {what} {name!r}{hint(name, table)}")
    return table[name]


def shown(text: str) -> str:
    """A text with names out of files, or of them, without what a terminal would obey."""
    return (
        text
        if text.isprintable()
        else "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
    )


def reason(error: OSError) -> str:
    """What is wrong with a file, in words."""
    if error.errno is None and str(error).endswith(" written"):  # so says numpy of a part
        return "no space left on device, or a limit reached"
    return (error.strerror or str(error)).lower()


def near(name: str, known: Iterable[str]) -> str | None:
    """The name that somebody may have meant, if one of those that are known is near."""
    import difflib

    names = list(known)
    begun = [one for one in names if len(name) > 2 and one.startswith(name)]
    close = begun or difflib.get_close_matches(name, names, 1)
    return close[0] if close else None


def hint(name: str, known: Iterable[str]) -> str:
    """What somebody may have meant who gave an unknown name, to follow what is said of it."""
    choices = list(known)
    close = near(name, choices)
    return f": did you mean {close!r}?" if close else f": choose one of {', '.join(choices)}"


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Put the name of the file before what is said of the mesh in it."""
    try:
        yield
    except (BadMeshError, ConfigError, UnsupportedMeshError, InvariantError) as error:
        error.args = (f"{path}: {error}", *error.args[1:])
        raise
