"""What those who write, compile and load kernels have in common; it imports none of them."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

# Name of the function that Python calls, in the object file of one entry.
SYMBOL = "call"


class Code(NamedTuple):
    """Machine code of an entry for one layout of its arguments."""

    image: bytes  # of an object file
    results: str  # layout of what it returns: see `words`


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
