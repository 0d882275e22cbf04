"""Where the bytes of a mesh come from and go to: files, compressed ones, and pipes."""

from __future__ import annotations

import contextlib
import gzip
import hashlib
import shutil
import sys
import tempfile
import zlib
from collections.abc import Iterator
from pathlib import Path

from ..errors import ReadError
from .atomic import replacing

PIPE = Path("-")  # stdin or stdout
ZIPPED = ".gz"
_GZIP = b"\x1f\x8b"
_LEVEL = 4  # of compression: more takes twice the time for a few percent
_BLOCK = 1 << 20


def is_zipped(path: Path) -> bool:
    """Whether a file is to be compressed, by its name."""
    return path.suffix.lower() == ZIPPED


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
    if path != PIPE and path.stat().st_size == len(data):
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, "mesh")
        copy.write_bytes(data)
        yield copy


@contextlib.contextmanager
def written(path: Path, digest: list[str]) -> Iterator[Path]:
    """Give the path of an empty file to write to, whose content then goes where it belongs.

    Parameters
    ----------
    path : Path
        Compressed if it ends in `.gz`; `PIPE` stands for stdout. Files are replaced as
        `atomic.replacing` does it.
    digest : list of str
        The digest of what was written is put there.
    """
    if path == PIPE:
        with tempfile.TemporaryDirectory() as folder:
            whole = Path(folder, "mesh")
            whole.touch()
            yield whole
            digest.append(_digest(whole))
            with whole.open("rb") as source:
                shutil.copyfileobj(source, sys.stdout.buffer, _BLOCK)
            sys.stdout.buffer.flush()
        return
    with replacing(path) as temporary:
        yield temporary
        if is_zipped(path):
            _compress(temporary)
        digest.append(_digest(temporary))


def _compress(path: Path) -> None:
    """Compress a file in its place; the same bytes give the same bytes."""
    with tempfile.TemporaryFile(dir=path.parent) as packed:
        with (
            path.open("rb") as source,
            gzip.GzipFile("", "wb", _LEVEL, packed, mtime=0) as target,
        ):
            shutil.copyfileobj(source, target, _BLOCK)
        packed.seek(0)
        with path.open("wb") as target:
            shutil.copyfileobj(packed, target, _BLOCK)


def _digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
