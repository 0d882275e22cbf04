"""The decorators that compile the kernels, and where the machine code is kept.

numba decides whether a stored kernel is fresh by the time stamp of the kernel's own
file. A change in a helper of another file would leave stale machine code behind, so the
cache lives in a folder named by the digest of all kernel sources.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.typed_passes import NativeLowering


def _digest() -> str:
    """Digest of all kernel sources and of what compiles them."""
    digest = hashlib.sha256(f"{sys.version} {numba.__version__}".encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    return digest.hexdigest()[:16]


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _cache_root() -> Path:
    """A folder for machine code that can be written to, private to the user.

    In this order: `MESHOPT_CACHE_DIR`, `XDG_CACHE_HOME`, the home's `.cache`, and where
    none can be written a temporary folder that goes with the process.
    """
    roots = []
    if own := os.environ.get("MESHOPT_CACHE_DIR"):
        roots.append(Path(own))
    if xdg := os.environ.get("XDG_CACHE_HOME"):
        roots.append(Path(xdg) / "meshopt")
    elif home := os.environ.get("HOME") or os.environ.get("USERPROFILE"):
        roots.append(Path(home) / ".cache" / "meshopt")
    for root in roots:
        if _is_writable(root / DIGEST):
            return root
    private = tempfile.mkdtemp(prefix="meshopt-kernels-")
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    return Path(private)


DIGEST = _digest()
CACHE_ROOT = _cache_root()
CACHE_FOLDER = CACHE_ROOT / DIGEST


def missing(groups: Iterable[str]) -> list[str]:
    """Groups of kernels (see `warmup.TASKS`) that no run has compiled from these sources yet."""
    if numba.config.DISABLE_JIT:
        return []
    return [group for group in groups if not _mark_of(group).exists()]


def note(group: str) -> None:
    """Note that a group of kernels is compiled."""
    with contextlib.suppress(OSError):
        CACHE_FOLDER.mkdir(parents=True, exist_ok=True)
        _mark_of(group).touch()


def _mark_of(group: str) -> Path:
    return CACHE_FOLDER / f"{group}.compiled"


class Bitcode(JITCodeLibrary):
    """The code of a kernel in the form that its callers link, and no other.

    numba turns every function into machine code together with all that it calls, before it
    compiles the caller. A kernel is called by other kernels only, so that this is never run;
    without it, compiling takes half the time.
    """

    def finalize(self) -> None:
        """Link what the kernel calls; the entry that calls it optimizes everything at once."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class BitcodeLowering(NativeLowering):
    """Lower a function to `Bitcode`."""

    _name = "bitcode_lowering"

    def run_pass(self, state: Any) -> bool:
        state.library = Bitcode(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.flags.no_compile = True
        NativeLowering.run_pass(self, state)
        # Callers find the code by the function that Python would call: any one of its own does.
        never_called = list[None]().append
        state.targetctx.insert_user_function(never_called, state.cr.fndesc, [state.library])
        state.cr = state.cr._replace(cfunc=never_called)
        return True


class KernelFlags(Flags):
    """numba's options of one compilation, quick to look up.

    They are part of the key under which it looks for the code of every operation, tens of
    thousands of times; its own class goes over all options each time.
    """

    def __hash__(self) -> int:
        return len(self._values)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Flags) and self._values == other._values


class KernelCompiler(CompilerBase):
    """numba's compiler, ending in `Bitcode`."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.state.flags = KernelFlags(self.state.flags)

    def define_pipelines(self) -> list[PassManager]:
        usual = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes = PassManager("kernel")
        for step, why in usual.passes:
            passes.add_pass(BitcodeLowering if step is NativeLowering else step, why)
        passes.finalize()
        return [passes]


# IEEE arithmetic: division by zero gives inf or nan, as in numpy, and there is no fastmath, so
# that the bits are the same compiled, interpreted and bounds-checked. No kernel allocates: it
# needs no reference counts of arrays.
COMMON: dict[str, Any] = {
    "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True, "_nrt": False
}  # fmt: skip
LINKED = {**COMMON, "no_cpython_wrapper": True, "pipeline_class": KernelCompiler}


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that only other kernels call."""
    return numba.njit(**LINKED)(function)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a kernel into each of its callers: for formulas, and for the innermost loops.

    A call passes every array of the mesh field by field, which costs more than such a
    function does.
    """
    return numba.njit(**LINKED, forceinline=True)(function)


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a kernel that Python calls, and keep it under `CACHE_FOLDER`."""
    outer = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(CACHE_FOLDER)
    try:
        return numba.njit(**COMMON, cache=True)(function)
    finally:
        numba.config.CACHE_DIR = outer
