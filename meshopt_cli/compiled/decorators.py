"""The decorators of the kernels, and how Python calls those that are compiled.

The machine code that the package brings along (see `library`), or else that of an earlier run, is
loaded as it is. Only a kernel that has none brings in numba (see `jit`), whose import takes longer
than loading them all; and where the loader does not work, numba compiles and keeps all of them
(see `plain`).
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import logging
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast, overload

from ..memory import is_limited
from . import cache, library, ways, words
from .marks import Code, Kernel

log = logging.getLogger("meshopt")

F = TypeVar("F", bound=Callable[..., Any])

# Makes arguments of the types that a kernel is called with; see `entry`.
Example = Callable[[Any], tuple[Any, ...]]
# Calls machine code; takes the words of some arguments and the arguments.
Ready = Callable[[words.Words, tuple[Any, ...]], Any]


class Entry:
    """A kernel that Python calls: compiled for every layout of arguments that it is called with.

    Attributes
    ----------
    py_func : callable
    group : str
        Kernels of a group are compiled together, ahead of a run that needs them. "" for those
        that are compiled when they are called.
    example : callable, optional
    """

    def __init__(
        self, function: Callable[..., Any], group: str = "", example: Example | None = None
    ) -> None:
        functools.update_wrapper(self, function)
        self.py_func = function
        self.group = group
        self.example = example
        self._ready: dict[str, Ready] = {}
        self._preparing = threading.Lock()

    def __call__(self, *arguments: Any) -> Any:
        layout, flat = words.flatten(arguments)
        ready = self._ready.get(layout) or self._prepared(layout, flat, arguments)
        return ready(flat, arguments)

    def prepare(self, *arguments: Any) -> None:
        """Do all that a call with such arguments needs, but the call."""
        self._prepared(*words.flatten(arguments), arguments)

    def _prepared(self, layout: str, flat: words.Words, arguments: tuple[Any, ...]) -> Ready:
        with self._preparing:
            ready = self._ready.get(layout)
            if ready is None:
                ready = self._ready[layout] = self._made(layout, flat, arguments)
            return ready

    def _made(self, layout: str, flat: words.Words, arguments: tuple[Any, ...]) -> Ready:
        name = self.name(layout)
        if ways.way() is ways.Way.LIBRARY and (found := library.find(name, flat)):
            return found
        if ways.compiler() is ways.Way.NUMBA:
            return self._plain(name, arguments)
        try:
            return self._native(name, flat, arguments)
        except MemoryError:
            raise
        except Exception as error:
            if is_limited():  # what fails for want of memory says so in many ways
                raise MemoryError from error
            # Inner names of numba may be gone, or mean something else, in more ways than can be
            # foreseen. Where the kernel itself is at fault, numba says so here.
            ready = self._plain(name, arguments)
            ways.give_up_native(error)
            return ready

    def name(self, layout: str) -> str:
        """What the code for arguments of a layout is kept under."""
        digest = hashlib.sha256(layout.encode())
        # An entry need not be among the kernels, whose sources name the folder: tests have some.
        source = self.py_func.__code__.co_filename
        if not source.startswith(str(cache.PACKAGE)):
            with contextlib.suppress(OSError):
                digest.update(Path(source).read_bytes())
        module = self.py_func.__module__.rpartition(".")[2]
        return f"{module}.{self.py_func.__name__}-{digest.hexdigest()[:16]}"

    def _native(self, name: str, flat: words.Words, arguments: tuple[Any, ...]) -> Ready:
        from . import native

        stored = cache.read(f"{name}.o")
        if stored is not None:
            try:
                return native.load(stored, flat, _symbols_of_numba)
            except MemoryError:
                raise
            except Exception:
                # It is damaged, or made by something else: it is made anew.
                log.info("compiled code of %s cannot be loaded: it is compiled again", name)
        return native.load(self._compiled(f"{name}.o", arguments), flat, _symbols_of_numba)

    def _compiled(self, name: str, arguments: tuple[Any, ...]) -> Code:
        """The code for such arguments, compiled now and stored."""
        from . import jit

        code = jit.compile_entry(self.py_func, arguments)
        cache.write(name, code)
        return code

    def _plain(self, name: str, arguments: tuple[Any, ...]) -> Ready:
        from . import plain

        return plain.Plain(self.py_func, arguments, cache.folder() / name)


def _symbols_of_numba() -> dict[str, int]:
    from . import jit

    return jit.symbols_of_numba()


def kernel(function: F) -> F:
    """Compile a function that only other kernels call."""
    return function if ways.INTERPRETED else cast(F, Kernel(function, is_inlined=False))


def inlined(function: F) -> F:
    """Compile a kernel into each of its callers: for formulas, and for the innermost loops.

    A call passes every array of the mesh field by field, which costs more than such a
    function does.
    """
    return function if ways.INTERPRETED else cast(F, Kernel(function, is_inlined=True))


@overload
def entry(function: F, /) -> F: ...
@overload
def entry(*, group: str, example: Example) -> Callable[[F], F]: ...
def entry(
    function: F | None = None, /, *, group: str = "", example: Example | None = None
) -> F | Callable[[F], F]:
    """Compile a kernel that Python calls, and keep it under `cache.folder`.

    Parameters
    ----------
    group : str
        A key of `warmup.GROUPS`: passes and commands name the groups that they need.
    example : callable
        Takes a `warmup.Specimen`; returns arguments of the types that the kernel is called with
        in every run, for which it is compiled. It is not called with them.
    """

    def decorated(function: F) -> F:
        return function if ways.INTERPRETED else cast(F, Entry(function, group, example))

    return decorated if function is None else decorated(function)
