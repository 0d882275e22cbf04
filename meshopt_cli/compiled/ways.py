"""The ways to run the kernels, and which groups of them are ready for the one that is taken."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Iterable
from enum import StrEnum
from importlib.util import find_spec

from ..errors import ConfigError
from . import cache, library
from .once import once

log = logging.getLogger("meshopt")

# numba's switch: Python runs the kernels itself.
INTERPRETED = os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")

VARIABLE = "MESHOPT_COMPILER"


class Way(StrEnum):
    """How kernels become machine code that Python calls."""

    LIBRARY = "library"  # compiled before, in the package: see `library`
    NATIVE = "native"  # `jit` compiles, `native` loads: quick, by inner names of numba
    NUMBA = "numba"  # `plain`: by documented ones


_given_up = threading.Event()
# A mark: the name of the folder depends on the version of numba, and on our sources.
_GIVEN_UP = "native.not"


def way() -> Way:
    """The way that is asked for; if none is, the first of them that works.

    Raises
    ------
    ConfigError
        The environment asks for one that there is not, or nothing can compile.
    """
    if _asked() in ("", Way.LIBRARY):
        library_ = library.opened()
        if library_.code is not None:
            return Way.LIBRARY
        if _asked():
            reason = library_.unfit or "this package has none: a wheel for this platform would"
            raise ConfigError(f"{VARIABLE}={Way.LIBRARY}: {reason}")
    return compiler()


def compiler() -> Way:
    """How kernels are compiled that the package has not; `NUMBA` where `NATIVE` failed before.

    Raises
    ------
    ConfigError
        As `way`.
    """
    if lacking := _lacking():
        why = library.opened().unfit or "this package brings none along"
        raise ConfigError(
            f"no compiled kernels ({why}), and no {lacking} to compile them: "
            "python -m pip install numba"
        )
    given_up = _given_up.is_set() or cache.has(_GIVEN_UP)
    return Way.NUMBA if given_up or _asked() == Way.NUMBA else Way.NATIVE


@once
def _lacking() -> str:
    """What is not installed of that which compiles kernels."""
    return " and no ".join(name for name in ("numba", "llvmlite") if find_spec(name) is None)


def _asked() -> str:
    asked = os.environ.get(VARIABLE, "")
    if asked and asked not in list(Way):
        raise ConfigError(f"{VARIABLE}: '{asked}' is none of {', '.join(Way)}")
    return asked


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
    if INTERPRETED or way() is Way.LIBRARY:
        return []
    return [group for group in groups if not cache.has(_mark_of(group))]


def note(group: str) -> None:
    """Note that a group of kernels is compiled."""
    if way() is not Way.LIBRARY:
        cache.mark(_mark_of(group))


def _mark_of(group: str) -> str:
    return f"{group}.{way()}"
