"""Machine code of an earlier run, linked without numba."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Mapping

import llvmlite.binding as llvm

from ..memory import FOR_LLVM, require_memory
from .call import Call
from .marks import SYMBOL, Code
from .once import once
from .words import Words

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


def load(code: Code, words: Words, symbols: Callable[[], Mapping[str, int]]) -> Call:
    """Machine code, ready to run.

    Parameters
    ----------
    words : list
        Of some arguments of the layout that the code is for.
    symbols : callable
        Returns addresses of functions by their names. It is called where the code needs some
        that are no part of the process, as functions of libm are not on every platform.
    """
    try:
        linked = _link(code.image, {})
    except RuntimeError:
        linked = _link(code.image, symbols())
    return Call(linked[SYMBOL], linked, words, code.results)
