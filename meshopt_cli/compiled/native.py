"""Calls of machine code: arguments as words, and the code that reads them.

The code of an entry is a C function `int call(const int64_t *words, int64_t *results)`. A word is
an integer or the bits of a double. An array takes a word for its address and one for each
extent, a tuple the words of its items. The function returns 0 when the kernel did not fail.

A layout is a list of items: a letter for a scalar, the type of an array, `name( ... )` for a tuple.
"""

from __future__ import annotations

import ctypes
import functools
import itertools
import os
import pkgutil
import struct
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from .cache import Code

SYMBOL = "call"

# C types of the function. A call lets go of Python's lock.
CALL = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_char_p, ctypes.c_void_p)

# Letters of scalars in a layout, and in the formats of `struct`.
SCALARS = {bool: "?", np.bool_: "?", int: "q", np.int64: "q", float: "d", np.float64: "d"}

_number = itertools.count()


def flatten(arguments: tuple[Any, ...]) -> tuple[str, list[int | float]]:
    """The layout of some arguments and their words.

    Arguments are C-contiguous arrays, scalars of the types that numpy has by default, and tuples
    of these.

    Returns
    -------
    layout : str
        Equal for arguments that the same machine code can take.
    words : list

    Raises
    ------
    TypeError
        Some argument is none of these.
    """
    layout: list[str] = []
    words: list[int | float] = []
    _append(arguments, layout, words)
    return " ".join(layout), words


def _append(values: tuple[Any, ...], layout: list[str], words: list[int | float]) -> None:
    for value in values:
        if isinstance(value, np.ndarray):
            flags = value.flags
            if not (flags.c_contiguous and flags.aligned and value.dtype.isnative):
                raise TypeError("kernels take C-contiguous arrays in native byte order only")
            access = "" if flags.writeable else "r"
            layout.append(f"{value.dtype.str}{value.ndim}{access}")
            words.append(value.ctypes.data)
            words.extend(value.shape)
        elif isinstance(value, tuple):
            layout.append(f"{type(value).__name__}(")
            _append(value, layout, words)
            layout.append(")")
        elif letter := SCALARS.get(type(value)):
            layout.append(letter)
            words.append(float(value) if letter == "d" else int(value))
        else:
            raise TypeError(f"kernels take no {type(value).__name__}")


@functools.cache
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
    builder = llvm.JITLibraryBuilder()
    builder.add_object_img(image).add_current_process().export_symbol(SYMBOL)
    for name, address in symbols.items():
        builder.import_symbol(name, address)
    return builder.link(_linker(), f"kernel {next(_number)}")


def _linked(image: bytes) -> llvm.ResourceTracker:
    """The code of an object file, there as long as this is."""
    try:
        return _link(image, {})
    except RuntimeError:
        # Some functions of libm are no part of a process on every platform; numba brings its own.
        from .jit import symbols_of_numba

        return _link(image, symbols_of_numba())


# What makes a result of its items, and these; the letter of a scalar.
Template = tuple[Callable[[list[Any]], Any], list[Any]] | str


def _templates(layout: Iterator[str]) -> list[Template]:
    """The items of a layout of results, up to the end of the tuple that they are in."""
    items: list[Template] = []
    for item in itertools.takewhile(lambda item: item != ")", layout):
        if item.endswith("("):
            named = pkgutil.resolve_name(item[:-1])
            items.append((getattr(named, "_make", named), _templates(layout)))
        else:
            items.append(item)
    return items


def _assembled(template: Template, values: Iterator[Any]) -> Any:
    if isinstance(template, str):
        return bool(next(values)) if template == "?" else next(values)
    make, items = template
    return make([_assembled(item, values) for item in items])


class Native:
    """Machine code that is ready to run.

    Parameters
    ----------
    words : list
        Of some arguments of the layout that the code is for.
    """

    def __init__(self, code: Code, words: list[int | float]) -> None:
        self._library = _linked(code.image)
        self._call = CALL(self._library[SYMBOL])
        letters = ("d" if isinstance(word, float) else "q" for word in words)
        self._pack = struct.Struct("".join(letters)).pack
        layout = code.results.split()
        self._templates = _templates(iter(layout))
        scalars = ["d" if item == "d" else "q" for item in layout if item in SCALARS.values()]
        self._unpack = struct.Struct("".join(scalars)).unpack_from
        self._new_results = ctypes.c_int64 * len(scalars)

    def __call__(self, words: list[int | float]) -> Any:
        """Run it with the words of arguments of that layout.

        Raises
        ------
        RuntimeError
            The kernel raised an exception, which none does unless bounds are checked.
        """
        results = self._new_results()
        if self._call(self._pack(*words), results):
            raise RuntimeError("a compiled kernel failed: NUMBA_DISABLE_JIT=1 tells where")
        values = iter(self._unpack(results))
        # None is a result without a word.
        return _assembled(self._templates[0], values) if self._templates else None
