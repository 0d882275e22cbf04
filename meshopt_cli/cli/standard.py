"""stdin, stdout and stderr as they may be: closed, full, or with nobody at the other end."""

from __future__ import annotations

import errno
import io
import os
import sys
from typing import Any, TextIO

from ..errors import NoReaderError, WriteError, reason


class _Stdout(io.RawIOBase):
    """What writes to stdout, and says so where it cannot."""

    def __init__(self, file: int | None) -> None:
        self._file = file
        self._has_failed = False

    def writable(self) -> bool:
        return True

    def isatty(self) -> bool:
        return self._file is not None and os.isatty(self._file)

    def fileno(self) -> int:
        if self._file is None:
            raise OSError(errno.EBADF, os.strerror(errno.EBADF))
        return self._file

    def write(self, data: Any, /) -> int:
        if self._has_failed:  # which was said
            return len(data)
        self._has_failed = True
        if self._file is None:
            raise WriteError("stdout: cannot be written: it is closed")
        try:
            written = os.write(self._file, data)
        except BrokenPipeError:
            raise NoReaderError("stdout: cannot be written: nobody reads it") from None
        except OSError as error:
            raise WriteError(f"stdout: cannot be written: {reason(error)}") from error
        self._has_failed = False
        return written


def prepare() -> None:
    """Give a run a stdin, stdout and stderr, whatever it was started with."""
    closed = [number for number in (0, 1, 2) if not _is_open(number)]
    for _ in closed:  # or files that are opened later would get their numbers
        os.open(os.devnull, os.O_RDWR)
    if 2 in closed or sys.stderr is None:
        sys.stderr = _nowhere()
    if sys.stdin is None or 0 in closed:
        sys.stdin = None  # type: ignore[assignment]
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    raw = _Stdout(None if 1 in closed else 1)
    sys.stdout = _text(io.BufferedWriter(raw), encoding, raw.isatty())


def _text(stream: io.BufferedWriter, encoding: str, by_lines: bool) -> TextIO:
    return io.TextIOWrapper(stream, encoding, line_buffering=by_lines)


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True


def forget_stdout() -> None:
    """Let nothing more be written to stdout: what is left to print could not be."""
    sys.stdout = _nowhere()


def _nowhere() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")
