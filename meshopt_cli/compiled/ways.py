"""The ways to run the kernels, and which groups of them are ready for the one that is taken."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Iterable
from enum import StrEnum

from ..errors import ConfigError
from . import cache

log = logging.getLogger("meshopt")

# numba's switch: Python runs the kernels itself.
INTERPRETED = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")

VARIABLE = "MESHOPT_COMPILER"


class Way(StrEnum):
    """How kernels become machine code that Python calls."""

    NATIVE = "native"  # `jit` compiles, `native` loads: quick, by inner names of numba
    NUMBA = "numba"  # `plain`: by documented ones


_given_up = threading.Event()
# A mark: the name of the folder depends on the version of numba, and on our sources.
_GIVEN_UP = "native.not"


def way() -> Way:
    """The way that is asked for; `NUMBA` where the other did not work before.

    Raises
    ------
    ConfigError
        The environment asks for one that there is not.
    """
    asked = os.environ.get(VARIABLE) or Way.NATIVE
    if asked not in list(Way):
        raise ConfigError(f"{VARIABLE}: '{asked}' is none of {', '.join(Way)}")
    given_up = _given_up.is_set() or cache.has(_GIVEN_UP)
    return Way.NUMBA if given_up else Way(asked)


def give_up_native(why: Exception) -> None:
    """Run all kernels by `NUMBA` from now on, in later runs too: this numba asks for it."""
    reason = f"{type(why).__name__}: {' '.join(str(why).split())}"
    log.warning(
        "the loader of compiled kernels does not know this numba or this platform (%.200s); "
        "numba's own means take its place, and start more slowly",
        reason,
    )
    _given_up.set()
    cache.mark(_GIVEN_UP, f"{reason}\n")


def missing(groups: Iterable[str]) -> list[str]:
    """Groups of kernels that no run has compiled from these sources yet, the way they run."""
    return [] if INTERPRETED else [group for group in groups if not cache.has(_mark_of(group))]


def note(group: str) -> None:
    """Note that a group of kernels is compiled."""
    cache.mark(_mark_of(group))


def _mark_of(group: str) -> str:
    return f"{group}.{way()}"
