"""Where bytes go to: files, compressed ones, pipes and devices; all of them, or none."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path

from .atomic import replacing, target_of
from .ending import note_written, temporary_folder

PIPE = Path("-")  # stdin or stdout
ZIPPED = ".gz"
# Names that systems have for what `PIPE` stands for, by its descriptor.
_STANDARD = {
    0: ("/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"),
    1: ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"),
}
_DESCRIPTORS = ("/dev/fd/", "/proc/self/fd/", "/dev/stderr")
_LEVEL = 4  # of compression: more takes twice the time for a few percent
_BLOCK = 1 << 20


def is_zipped(path: Path) -> bool:
    """Whether a file is to be compressed, by its name."""
    return path.suffix.lower() == ZIPPED


def as_pipe(path: Path, descriptor: int) -> Path:
    """`PIPE` for what is another name of stdin (0) or stdout (1); else the path itself."""
    return PIPE if str(path) in _STANDARD[descriptor] else path


def is_stream(path: Path) -> bool:
    """Whether it is no file that could be replaced, but a pipe or a device."""
    if path == PIPE or str(path).startswith(_DESCRIPTORS):
        return True
    try:
        return path.exists() and not path.is_file() and not path.is_dir()
    except OSError:
        return False


def require_place(path: Path) -> None:
    """Find out ahead whether something can be written, as far as that can be told.

    Raises
    ------
    OSError
        It cannot.
    """
    if not is_stream(path):
        target_of(path)


@contextlib.contextmanager
def written(path: Path, digest: list[str]) -> Iterator[Path]:
    """Give the path of an empty file to write to, whose content then goes where it belongs.

    Parameters
    ----------
    path : Path
        Compressed if it ends in `.gz`; `PIPE` stands for stdout. Files are replaced as
        `atomic.replacing` does it; pipes and devices get all of it at once.
    digest : list of str
        The digest of what was written is put there.
    """
    import shutil

    if not is_stream(path):
        with replacing(path) as temporary:
            yield temporary
            _finish(path, temporary, digest)
        return
    with temporary_folder() as folder:
        whole = Path(folder, "whole")
        whole.touch()
        yield whole
        _finish(path, whole, digest)
        with whole.open("rb") as source:
            if path == PIPE:
                shutil.copyfileobj(source, sys.stdout.buffer, _BLOCK)
                sys.stdout.buffer.flush()
            else:
                with path.open("wb") as target:
                    shutil.copyfileobj(source, target, _BLOCK)
        note_written(path)


def _finish(path: Path, whole: Path, digest: list[str]) -> None:
    if is_zipped(path):
        _compress(whole)
    digest.append(_digest(whole))


def _compress(path: Path) -> None:
    """Compress a file in its place; the same bytes give the same bytes."""
    import gzip
    import shutil
    import tempfile

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
    import hashlib

    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
