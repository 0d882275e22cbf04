"""What holds for every kernel, whichever way numba compiles it."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import Any

import numba
from numba import types
from numba.extending import typeof_impl

from .marks import Kernel

# IEEE arithmetic: division by zero gives inf or nan, as in numpy, and there is no fastmath, so
# that the bits are the same compiled, interpreted and bounds-checked.
OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}

# Letters of the scalars that a kernel may return, as in `words.SCALARS`.
RESULTS = {types.int64: "q", types.float64: "d", types.boolean: "?"}

_compiling = threading.RLock()


@contextlib.contextmanager
def compiling(dispatcher_of: Callable[[Kernel], Any]) -> Iterator[None]:
    """For as long as it lasts, this thread alone compiles.

    Parameters
    ----------
    dispatcher_of : callable
        What numba calls a function that it compiles when another one calls it, for a kernel that
        another one calls by its name.
    """
    with _compiling:
        typeof_impl.register(Kernel)(lambda kernel, _context: numba.typeof(dispatcher_of(kernel)))
        yield


def results_of(returned: types.Type) -> str:
    """The layout of what a kernel returns, with the class of each named tuple; see `words`.

    Raises
    ------
    TypeError
        It returns something else than scalars and tuples.
    """
    if isinstance(returned, types.NoneType):
        return ""
    if isinstance(returned, types.BaseTuple):
        named = returned.instance_class if isinstance(returned, types.BaseNamedTuple) else tuple
        items = " ".join(results_of(item) for item in returned)
        return f"{named.__module__}:{named.__qualname__}( {items} )"
    if returned not in RESULTS:
        raise TypeError(f"kernels return no {returned}")
    return RESULTS[returned]
