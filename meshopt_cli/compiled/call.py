"""How Python calls machine code, whoever loaded it.

The code of an entry is a C function `int call(const int64_t *words, int64_t *results)`, of words
as in `words`. It returns 0 when the kernel did not fail.
"""

from __future__ import annotations

import ctypes
from typing import Any

from .words import Results, Words, packing

# C types of the function. A call lets go of Python's lock.
_CALL = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_char_p, ctypes.c_void_p)


class Call:
    """Machine code that is ready to run.

    Parameters
    ----------
    address : int
        Of the function.
    owner : object
        What the code is there with: it is kept for as long as this.
    words : list
        Of some arguments of the layout that the code is for.
    results : str
        The layout of what it returns.
    """

    def __init__(self, address: int, owner: object, words: Words, results: str) -> None:
        self._owner = owner
        self._call = _CALL(address)
        self._pack = packing(words)
        self._results = Results(results)

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
