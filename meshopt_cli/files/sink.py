"""Where bytes go to: files, compressed ones, and stdout; all of them, or none."""

from __future__ import annotations

import contextlib
import gzip
import hashlib
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from .atomic import replacing

PIPE = Path("-")  # stdin or stdout
ZIPPED = ".gz"
_LEVEL = 4  # of compression: more takes twice the time for a few percent
_BLOCK = 1 << 20


def is_zipped(path: Path) -> bool:
    """Whether a file is to be compressed, by its name."""
    return path.suffix.lower() == ZIPPED


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
