"""Where the bytes of a mesh come from: files, compressed ones, and pipes."""

from __future__ import annotations

import contextlib
import gzip
import hashlib
import io
import os
import stat
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from ..errors import ReadError, reason
from ..files.ending import temporary_folder
from ..files.sink import PIPE, is_stream, is_zipped
from .sniff import HEAD

_GZIP = b"\x1f\x8b"
_BLOCK = 1 << 20
# What may come out of compressed bytes, where the user sets no limit: so many bytes in any case,
# and else so many times what went in. A mesh of zeros is packed a thousandfold at most.
_LEAST_MOST = 1 << 28
_MOST_TIMES = 1000


def extension(path: Path) -> str:
    """The extension that tells the format, in lower case: that before `.gz`, if it ends so."""
    return (path.with_suffix("") if is_zipped(path) else path).suffix.lower()


class Contents:
    """The bytes of a mesh, out of the compressed file if it is one.

    Parameters
    ----------
    path : Path
        What messages call it.
    max_size : int, optional
        The most bytes that it may have.

    Attributes
    ----------
    head : bytes
        The first `HEAD` bytes, or all that there are.
    """

    def __init__(self, path: Path, source: IO[bytes], max_size: int | None) -> None:
        self._path = path
        self._source = source
        self._max_size = max_size
        self._first = source.read(HEAD)
        self._is_zipped = self._first.startswith(_GZIP)
        self.head = self._unzipped_head() if self._is_zipped else self._first

    def whole(self) -> tuple[bytes, str]:
        """All bytes, and the digest of the file.

        Raises
        ------
        ReadError
            It is compressed, and truncated or damaged; or it has too many bytes.
        """
        if self._source.seekable():
            self._source.seek(0)
            raw = self._source.read()
        else:
            raw = self._first + self._source.read()
        digest = hashlib.sha256(raw).hexdigest()
        if self._is_zipped:
            return self._unzipped(raw), digest
        if self._max_size is not None and len(raw) > self._max_size:
            raise ReadError(f"{self._path}: it has {len(raw):,} bytes: --max-size allows more")
        return raw, digest

    def _unzipped_head(self) -> bytes:
        unzip = zlib.decompressobj(wbits=31)
        try:
            head = unzip.decompress(self._first, HEAD)
        except zlib.error:
            raise self._damaged() from None
        if len(self._first) < HEAD and not (unzip.eof or unzip.unconsumed_tail):
            raise self._damaged()  # it has no end
        return head

    def _unzipped(self, raw: bytes) -> bytes:
        most = self._max_size
        if most is None:
            most = max(_LEAST_MOST, _MOST_TIMES * len(raw))
        parts, size = [], 0
        with gzip.GzipFile(fileobj=io.BytesIO(raw)) as stream:
            try:
                while part := stream.read(_BLOCK):
                    parts.append(part)
                    size += len(part)
                    if size > most:
                        raise ReadError(
                            f"{self._path}: more than {most:,} bytes come out of its "
                            f"{len(raw):,}: --max-size allows more"
                        )
            except (OSError, EOFError, zlib.error):
                raise self._damaged() from None
        return b"".join(parts)

    def _damaged(self) -> ReadError:
        return ReadError(f"{self._path}: truncated or damaged gzip file")


@contextlib.contextmanager
def opened(path: Path, max_size: int | None = None) -> Iterator[Contents]:
    """Open a file or a pipe to read a mesh from.

    Raises
    ------
    OSError
        It cannot be read, or gives no file: terminals and devices do not.
    ReadError
        See `Contents`.
    """
    if path == PIPE:
        if sys.stdin is None:
            raise OSError("it is closed")
        _require_file(sys.stdin.fileno() if hasattr(sys.stdin, "fileno") else None)
        yield Contents(path, sys.stdin.buffer, max_size)
        return
    with open(path, "rb") as stream:
        _require_file(stream.fileno())
        yield Contents(path, stream, max_size)


def _require_file(number: int | None) -> None:
    if number is None or not stat.S_ISCHR(os.fstat(number).st_mode):
        return
    raise OSError("it is a terminal" if os.isatty(number) else "it is a device, and no file")


@contextlib.contextmanager
def as_file(path: Path, data: bytes) -> Iterator[Path]:
    """A plain file with the bytes of a mesh: the one at `path`, if it has just these."""
    if not is_stream(path) and path.stat().st_size == len(data):
        yield path
        return
    with copied(data, "mesh") as copy:
        yield copy


@contextlib.contextmanager
def copied(data: bytes, name: str) -> Iterator[Path]:
    """A temporary file of a name with these bytes.

    Raises
    ------
    ReadError
        There is no room for it.
    """
    with temporary_folder() as folder:
        copy = Path(folder, name)
        try:
            copy.write_bytes(data)
        except OSError as error:
            what = f"no room for a temporary file: {reason(error)}"
            raise ReadError(f"{folder.parent}: {what}") from error
        yield copy
