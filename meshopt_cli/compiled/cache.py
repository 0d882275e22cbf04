"""Where the machine code of the kernels is kept.

A folder is named by the digest of all that the code depends on: every source that kernels are
made of, because helpers are compiled into their callers, what compiles them, and the processor
they run on.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import re
import sys
import time
from importlib.util import find_spec
from pathlib import Path

from ..files import ending, sweep
from . import trust
from .marks import Code
from .once import once

log = logging.getLogger("meshopt")

VARIABLE = "MESHOPT_CACHE_DIR"
PREFIX = "meshopt-kernels-"  # of folders that go with the process
PACKAGE = Path(__file__).parent.parent
# What is compiled, and what compiles it, below the package.
PATTERNS = ("cells.py", "handles.py", "compiled/**/*.py", "kernels/**/*.py")
# Variables by which numba makes other code; its many others change what it says and keeps.
SETTINGS = (
    "NUMBA_BOUNDSCHECK", "NUMBA_CPU_FEATURES", "NUMBA_CPU_NAME", "NUMBA_DEBUGINFO",
    "NUMBA_DEBUG_NRT", "NUMBA_DISABLE_INTEL_SVML", "NUMBA_ENABLE_AVX", "NUMBA_ENABLE_PROFILING",
    "NUMBA_EXTEND_VARIABLE_LIFETIMES", "NUMBA_LLVM_REFPRUNE_FLAGS", "NUMBA_LLVM_REFPRUNE_PASS",
    "NUMBA_LOOP_VECTORIZE", "NUMBA_NRT_STATS", "NUMBA_OPT", "NUMBA_SLP_VECTORIZE",
)  # fmt: skip

_DAY, _MONTH = 86_400.0, 30 * 86_400.0  # seconds
_FOLDER = re.compile(r"[0-9a-f]{16}")
_TEMPORARY = re.compile(r"\.[0-9a-f]{16}$")
# Names in a folder for machine code: of objects and marks, finished or not, and of numba's folders.
_STORED = re.compile(r".+\.(o|native|numba|not)(\.[0-9a-f]{16})?|.+-[0-9a-f]{16}")
_incomplete: set[Path] = set()  # folders in which something could not be stored


def sources() -> list[Path]:
    """The files of the package that machine code depends on, in a fixed order."""
    return [path for pattern in PATTERNS for path in sorted(PACKAGE.glob(pattern))]


def settings() -> list[tuple[str, str]]:
    """What the environment sets of `SETTINGS`."""
    return [(name, os.environ[name]) for name in SETTINGS if name in os.environ]


def digest_of_sources() -> str:
    """Digest of all kernel sources, wherever they lie."""
    digest = hashlib.sha256()
    start = len(str(PACKAGE)) + 1
    for source in map(str, sources()):
        digest.update(source[start:].replace(os.sep, "/").encode())
        with open(source, "rb", buffering=0) as stream:
            digest.update(stream.read())
    return digest.hexdigest()


def _digest() -> str:
    """Digest of all kernel sources and of what compiles them."""
    import llvmlite
    from llvmlite.binding import get_host_cpu_features, get_host_cpu_name

    compilers = (sys.version, _version_of_numba(), llvmlite.__version__)
    machine = (get_host_cpu_name(), get_host_cpu_features().flatten())
    made_by = repr((compilers, machine, settings(), digest_of_sources()))
    return hashlib.sha256(made_by.encode()).hexdigest()[:16]


def _version_of_numba() -> bytes:
    """What tells numba's version; importing it for that would take longer than all the rest."""
    spec = find_spec("numba")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).with_name("_version.py").read_bytes()


def _roots() -> list[Path]:
    """Where folders for machine code may lie, the first choice first."""
    roots = []
    if own := os.environ.get(VARIABLE):
        with contextlib.suppress(OSError):  # the working folder is gone
            roots.append(Path(own).absolute())
    xdg = os.environ.get("XDG_CACHE_HOME", "")
    home = os.environ.get("HOME") or os.environ.get("USERPROFILE") or ""
    if os.path.isabs(xdg):  # what is not is to be ignored, says its specification
        roots.append(Path(xdg) / "meshopt")
    elif os.path.isabs(home):
        roots.append(Path(home) / ".cache" / "meshopt")
    return roots


@once
def folders() -> tuple[Path, list[Path]]:
    """The folder to write machine code to, and all that it may be read from, that one included.

    The first is private to the user: see `trust`. Where there is none that can be written, it is
    a temporary one that goes with the process; what was compiled before is read all the same.
    """
    digest = _digest()
    readable: list[Path] = []
    for root in _roots():
        place = root / digest
        # Nothing is made in the home of a user for whom root runs this, nor in a folder for all.
        if not trust.is_safe(place):
            _warn_of(root)
            continue
        with contextlib.suppress(OSError):
            make(place)
        # Looked at again: others may have been quicker.
        if not os.path.isdir(place) or not trust.is_safe(place):
            continue
        readable.append(place)
        if _is_writable(place):
            return place, readable
    private = _private()
    return private / digest, [*readable, private / digest]


def _private() -> Path:
    """A folder that goes with the process, and is told from those of runs that were killed."""
    import atexit
    import shutil
    import tempfile

    try:
        sweep.sweep(Path(tempfile.gettempdir()), PREFIX)
        private = Path(tempfile.mkdtemp(prefix=PREFIX))
    except OSError:
        return Path(os.devnull)  # there is no folder for temporary files: nothing is kept
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    ending.note_temporary(private)
    if os.name == "posix":
        sweep.hold(os.open(private, os.O_RDONLY))
    return private


def is_lasting() -> bool:
    """Whether later runs find what is written."""
    return folder().parent in _roots() and folder() not in _incomplete


def folder() -> Path:
    """The folder to write machine code to."""
    return folders()[0]


def make(place: Path) -> None:
    """Make a folder that nobody else can write, and those above it that are missing."""
    missing = [place, *place.parents]
    for path in reversed([path for path in missing if not path.exists()]):
        path.mkdir(mode=0o700, exist_ok=True)


def _is_writable(place: Path) -> bool:
    """Whether it is; it is in use today, too: see `_sweep`."""
    import tempfile

    try:
        with tempfile.TemporaryFile(dir=place):
            pass
        if time.time() - place.stat().st_mtime > _DAY:
            os.utime(place)
    except OSError:
        return False
    return True


def _warn_of(root: Path) -> None:
    asked = os.environ.get(VARIABLE) == str(root)
    log.log(
        logging.WARNING if asked else logging.INFO,
        "%s: others can write there, or it is another user's: no compiled kernels are taken "
        "from it, nor put there",
        f"{VARIABLE}={root}" if asked else root,
    )


def has(name: str) -> bool:
    """Whether there is a mark of this name."""
    return any(trust.read(place / name) is not None for place in folders()[1])


def mark(name: str, text: str = "") -> None:
    """Leave a mark, unless something else could not be stored."""
    if folder() in _incomplete:
        return
    with contextlib.suppress(OSError):
        _put(folder() / name, text.encode())
        _sweep(folder())


def read(name: str) -> Code | None:
    """Code that `write` stored; None where there is none, or not all of it as it was."""
    for place in folders()[1]:
        stored = trust.read(place / name)
        if stored is None:
            continue
        checked, _, checksum = stored.rpartition(b"\n")
        if _checksum(place / name, checked) == checksum:
            image, _, results = checked.rpartition(b"\n")
            return Code(image, results.decode(errors="replace"))
    return None


def _checksum(place: Path, checked: bytes) -> bytes:
    """Of code in its place: that of another kernel, or of other sources, is damage too."""
    where = f"{place.parent.name}/{place.name}\n".encode()
    return hashlib.sha256(where + checked).hexdigest().encode()


def write(name: str, code: Code) -> None:
    """Store code, all of it or none; where nothing can be written, it is compiled each time."""
    # Object files end where their tables say: tools that read them pass over the last two lines.
    checked = code.image + b"\n" + code.results.encode()
    place = folder() / name
    try:
        _put(place, checked + b"\n" + _checksum(place, checked))
    except OSError:
        note_incomplete()


def note_incomplete() -> None:
    """Note that something could not be stored: there will be no marks."""
    _incomplete.add(folder())


def _put(place: Path, data: bytes) -> None:
    temporary = place.with_name(f"{place.name}.{os.urandom(8).hex()}")
    make(place.parent)
    with ending.temporary(temporary):
        # Whatever the umask is: what others can write is not read.
        with open(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644), "wb") as stream:
            stream.write(data)
        if place.is_dir() and not place.is_symlink():
            import shutil

            shutil.rmtree(place)
        temporary.replace(place)


def _sweep(used: Path) -> None:
    """Remove folders of other versions that were not used for long, and what killed runs left."""
    import shutil

    old = time.time() - _MONTH
    for place in used.parent.iterdir():
        with contextlib.suppress(OSError):
            is_old = place.stat().st_mtime < old and trust.is_ours(place.lstat())
            if _FOLDER.fullmatch(place.name) and place != used and is_old and _is_code(place):
                shutil.rmtree(place, ignore_errors=True)
    for place in used.iterdir():
        with contextlib.suppress(OSError):
            if _TEMPORARY.search(place.name) and place.stat().st_mtime < time.time() - _DAY:
                place.unlink()


def _is_code(folder: Path) -> bool:
    """Whether a folder holds machine code and nothing else: the name alone might be another's."""
    return folder.is_dir() and all(_STORED.fullmatch(path.name) for path in folder.iterdir())
