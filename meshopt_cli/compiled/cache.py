"""Where the machine code of the kernels is kept.

A folder is named by the digest of all that the code depends on: every source that kernels are
made of, because helpers are compiled into their callers, what compiles them, and the processor
they run on.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import os
import shutil
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from .marks import Code
from .once import once

PACKAGE = Path(__file__).parent.parent
# What is compiled, and what compiles it, below the package.
PATTERNS = ("cells.py", "handles.py", "compiled/**/*.py", "kernels/**/*.py")


def sources() -> list[Path]:
    """The files of the package that machine code depends on, in a fixed order."""
    return [path for pattern in PATTERNS for path in sorted(PACKAGE.glob(pattern))]


def _digest() -> str:
    """Digest of all kernel sources and of what compiles them."""
    import llvmlite
    from llvmlite.binding import get_host_cpu_features, get_host_cpu_name

    digest = hashlib.sha256()
    compilers = (sys.version, _version_of_numba(), llvmlite.__version__)
    machine = (get_host_cpu_name(), get_host_cpu_features().flatten())
    settings = sorted(item for item in os.environ.items() if item[0].startswith("NUMBA_"))
    digest.update(repr((compilers, machine, settings)).encode())
    for source in sources():
        digest.update(source.relative_to(PACKAGE).as_posix().encode() + source.read_bytes())
    return digest.hexdigest()[:16]


def _version_of_numba() -> bytes:
    """What tells numba's version; importing it for that would take longer than all the rest."""
    spec = find_spec("numba")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).with_name("_version.py").read_bytes()


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


@once
def folder() -> Path:
    """The folder for machine code, writable and private to the user.

    It lies in one of these: `MESHOPT_CACHE_DIR`, `XDG_CACHE_HOME`, the home's `.cache`, and where
    none can be written a temporary folder that goes with the process.
    """
    digest = _digest()
    roots = []
    if own := os.environ.get("MESHOPT_CACHE_DIR"):
        roots.append(Path(own))
    if xdg := os.environ.get("XDG_CACHE_HOME"):
        roots.append(Path(xdg) / "meshopt")
    elif home := os.environ.get("HOME") or os.environ.get("USERPROFILE"):
        roots.append(Path(home) / ".cache" / "meshopt")
    for root in roots:
        if _is_writable(root / digest):
            return root / digest
    private = tempfile.mkdtemp(prefix="meshopt-kernels-")
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    return Path(private) / digest


def read(name: str) -> Code | None:
    """Code that `write` stored; None where there is none, or not all of it as it was."""
    try:
        stored = (folder() / name).read_bytes()
    except OSError:
        return None
    checked, _, checksum = stored.rpartition(b"\n")
    if hashlib.sha256(checked).hexdigest().encode() != checksum:
        return None
    image, _, results = checked.rpartition(b"\n")
    return Code(image, results.decode())


def write(name: str, code: Code) -> None:
    """Store code, all of it or none; where nothing can be written, it is compiled each time."""
    # Object files end where their tables say: tools that read them pass over the last two lines.
    checked = code.image + b"\n" + code.results.encode()
    stored = checked + b"\n" + hashlib.sha256(checked).hexdigest().encode()
    place = folder() / name
    # The permissions are those of any new file, which a folder that users share needs.
    temporary = place.with_name(f"{name}.{os.urandom(8).hex()}")
    with contextlib.suppress(OSError):
        place.parent.mkdir(parents=True, exist_ok=True)
        try:
            temporary.write_bytes(stored)
            temporary.replace(place)
        finally:
            temporary.unlink(missing_ok=True)
