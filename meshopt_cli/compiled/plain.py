"""Kernels compiled, kept and called by numba's own means, as it documents them.

It takes longer than `jit` and `native` do, in a first run and at every start. But it works with
any numba, and wherever numba does.
"""

from __future__ import annotations

import functools
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba import config

from . import cache, trust
from .marks import Kernel
from .semantics import OPTIONS, compiling, results_of
from .words import Words

# Without what Python would call a kernel by, which never calls it, compiling takes two thirds of
# the time. numba does not document these options, and may do without them one day.
QUICK = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def nothing() -> None:
    """A function to try options on."""


@functools.cache
def has(**options: bool) -> bool:
    """Whether this numba has some options; it says so when it compiles."""
    try:
        numba.njit(**OPTIONS, **options)(nothing).compile(())
    except KeyError:
        return False
    return True


@functools.cache
def dispatcher_of(kernel: Kernel) -> Any:
    """A kernel as numba compiles it for another one."""
    options = {**QUICK, "forceinline": kernel.is_inlined}
    return numba.njit(**OPTIONS, **(options if has(**options) else {}))(kernel.py_func)


class Plain:
    """A function compiled for arguments of the types of these.

    Parameters
    ----------
    folder : Path
        Where numba keeps the code, of this function and such arguments only: it tells changed
        sources by the file of the function, and processes that write about several at once
        might mix them up.

    Raises
    ------
    TypeError
        It returns something else than scalars and tuples.
    """

    def __init__(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], folder: Path
    ) -> None:
        signature = tuple(numba.typeof(argument) for argument in arguments)
        with compiling(dispatcher_of):
            self._call = _compiled(function, signature, folder)
        results_of(self._call.nopython_signatures[0].return_type)

    def __call__(self, _words: Words, arguments: tuple[Any, ...]) -> Any:
        """Run it with arguments of those types."""
        return self._call(*arguments)


def _compiled(function: Callable[..., Any], signature: tuple[Any, ...], folder: Path) -> Any:
    """A function compiled by numba, and kept where it can be."""
    for _ in range(2):
        if not _is_ready(folder):
            break
        kept = _kept(function, folder)
        try:
            kept.compile(signature)
            return kept
        except MemoryError:
            raise
        except Exception:
            # What is stored may be damaged, or the disk full. Where it is the function, the last
            # attempt ends the same way.
            shutil.rmtree(folder, ignore_errors=True)
    cache.note_incomplete()
    call = numba.njit(**OPTIONS)(function)
    call.compile(signature)
    return call


def _is_ready(folder: Path) -> bool:
    """Make a folder for numba, which sees to nothing itself; whether it is there."""
    try:
        if os.path.lexists(folder) and not trust.is_closed(folder):
            is_folder = folder.is_dir() and not folder.is_symlink()
            (shutil.rmtree if is_folder else os.unlink)(folder)
        cache.make(folder)
    except OSError:
        return False
    return trust.is_closed(folder)


def _kept(function: Callable[..., Any], folder: Path) -> Any:
    """What numba makes of a function, told to keep the code in a folder if it can be written."""
    usual = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        kept = numba.njit(**OPTIONS, cache=True)(function)
        # Elsewhere, as beside the source, might lie code of other versions of the kernels.
        if Path(kept.stats.cache_path).is_relative_to(folder):
            return kept
    except RuntimeError:
        pass  # numba found no place at all
    finally:
        config.CACHE_DIR = usual
    return numba.njit(**OPTIONS)(function)
