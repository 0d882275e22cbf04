"""Machine code of an earlier run, linked and called without numba.

The code of an entry is a C function `int call(const int64_t *words, int64_t *results)`, of words
as in `words`. It returns 0 when the kernel did not fail.
"""

from __future__ import annotations

import ctypes
import itertools
import os
from collections.abc import Callable, Mapping
from typing import Any

import llvmlite.binding as llvm

from ..memory import FOR_LLVM, require_memory
from .marks import SYMBOL, Code
from .once import once
from .words import Results, Words, packing

# C types of the function. A call lets go of Python's lock.
CALL = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_char_p, ctypes.c_void_p)

_number = itertools.count()


@once
def _linker() -> llvm.LLJIT:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.create_lljit_compiler(use_jit_link=os.name != "nt", suppress_errors=True)


def _link(image: bytes, symbols: Mapping[str, int]) -> llvm.ResourceTracker:
    """Link an object file to functions of this process, and to some given by their addresses.

    Raises
    ------
    RuntimeError
        It needs others.
    """
    require_memory(FOR_LLVM)
    builder = llvm.JITLibraryBuilder()
    builder.add_object_img(image).add_current_process().export_symbol(SYMBOL)
    for name, address in symbols.items():
        builder.import_symbol(name, address)
    return builder.link(_linker(), f"kernel {next(_number)}")


class Native:
    """Machine code that is ready to run.

    Parameters
    ----------
    words : list
        Of some arguments of the layout that the code is for.
    symbols : callable
        Returns addresses of functions by their names. It is called where the code needs some
        that are no part of the process, as functions of libm are not on every platform.
    """

    def __init__(self, code: Code, words: Words, symbols: Callable[[], Mapping[str, int]]) -> None:
        try:
            library = _link(code.image, {})
        except RuntimeError:
            library = _link(code.image, symbols())
        self._library = library  # the code is there as long as this is
        self._call = CALL(library[SYMBOL])
        self._pack = packing(words)
        self._results = Results(code.results)

    def __call__(self, words: Words, _arguments: tuple[Any, ...]) -> Any:
        """Run it with the words of arguments of that layout.

        Raises
        ------
        RuntimeError
            The kernel raised an exception, which none does unless bounds are checked.
        """
        results = self._results.room()
        if self._call(self._pack(*words), results):
            raise RuntimeError("a compiled kernel failed: NUMBA_DISABLE_JIT=1 tells where")
        return self._results.value(results)
