"""Where the bytes of a mesh come from: files, compressed ones, and pipes."""

from __future__ import annotations

import contextlib
import gzip
import hashlib
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path

from ..errors import ReadError
from ..files.ending import temporary_folder
from ..files.places import reason
from ..files.sink import PIPE, is_stream, is_zipped

_GZIP = b"\x1f\x8b"


def extension(path: Path) -> str:
    """The extension that tells the format, in lower case: that before `.gz`, if it ends so."""
    return (path.with_suffix("") if is_zipped(path) else path).suffix.lower()


def contents(path: Path, size: int = -1) -> tuple[bytes, str]:
    """The bytes of a mesh, out of the compressed file if it is one, and the digest of the file.

    Parameters
    ----------
    path : Path
        `PIPE` stands for stdin.
    size : int
        So many bytes from the beginning are enough; the digest is then none.

    Raises
    ------
    OSError
        It cannot be read.
    ReadError
        It is compressed, and truncated or damaged.
    """
    if path == PIPE:
        if sys.stdin is None:
            raise OSError("it is closed")
        raw = sys.stdin.buffer.read()
    else:
        with open(path, "rb") as stream:
            raw = stream.read(size)
    digest = hashlib.sha256(raw).hexdigest() if size < 0 else ""
    if not raw.startswith(_GZIP):
        return raw, digest
    try:
        if size >= 0:  # the end may be missing
            return zlib.decompressobj(wbits=31).decompress(raw, size), digest
        return gzip.decompress(raw), digest
    except (OSError, EOFError, zlib.error) as error:
        reason = " ".join(str(error).split())
        raise ReadError(f"{path}: truncated or damaged gzip file ({reason})") from error


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
