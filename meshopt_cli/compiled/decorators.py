"""The decorators of the kernels, and how Python calls those that are compiled.

The machine code of an earlier run is loaded as it is. Only a kernel that has none brings in
numba (see `jit`), whose import takes longer than loading them all.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import cache

if TYPE_CHECKING:
    from . import native


class Kernel:
    """A function that kernels call; Python runs it uncompiled.

    Attributes
    ----------
    py_func : callable
    is_inlined : bool
        Whether it is compiled into each of its callers.
    """

    def __init__(self, function: Callable[..., Any], is_inlined: bool) -> None:
        functools.update_wrapper(self, function)
        self.py_func = function
        self.is_inlined = is_inlined

    def __call__(self, *arguments: Any) -> Any:
        return self.py_func(*arguments)


class Entry:
    """A kernel that Python calls: compiled for every layout of arguments that it is called with.

    Attributes
    ----------
    py_func : callable
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        functools.update_wrapper(self, function)
        self.py_func = function
        self._loaded: dict[str, native.Native] = {}

    def __call__(self, *arguments: Any) -> Any:
        from . import native

        layout, words = native.flatten(arguments)
        loaded = self._loaded.get(layout)
        if loaded is None:
            loaded = native.Native(self._code(layout, arguments), words)
            self._loaded[layout] = loaded
        return loaded(words)

    def _code(self, layout: str, arguments: tuple[Any, ...]) -> cache.Code:
        """The code for such arguments: what is stored, or else compiled now and stored."""
        digest = hashlib.sha256(layout.encode())
        # An entry need not be among the kernels, whose sources name the folder: tests have some.
        with contextlib.suppress(OSError):
            digest.update(Path(self.py_func.__code__.co_filename).read_bytes())
        module = self.py_func.__module__.rpartition(".")[2]
        name = f"{module}.{self.py_func.__name__}-{digest.hexdigest()[:16]}.o"
        code = cache.read(name)
        if code is None:
            from . import jit

            code = jit.compile_entry(self.py_func, arguments)
            cache.write(name, code)
        return code


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function that only other kernels call."""
    return function if cache.INTERPRETED else Kernel(function, is_inlined=False)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a kernel into each of its callers: for formulas, and for the innermost loops.

    A call passes every array of the mesh field by field, which costs more than such a
    function does.
    """
    return function if cache.INTERPRETED else Kernel(function, is_inlined=True)


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a kernel that Python calls, and keep it under `cache.folder`."""
    return function if cache.INTERPRETED else Entry(function)
