"""The ways to run the kernels, and which groups of them are ready for the one that is taken."""

from __future__ import annotations

import contextlib
import logging
import os
import threading
from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path

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
    given_up = _given_up.is_set() or _why_given_up().exists()
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
    with contextlib.suppress(OSError):
        _why_given_up().write_text(f"{reason}\n", encoding="utf-8")


def _why_given_up() -> Path:
    # The name of the folder depends on the version of numba, and on our sources.
    return cache.folder() / "native.not"


def missing(groups: Iterable[str]) -> list[str]:
    """Groups of kernels that no run has compiled from these sources yet, the way they run."""
    return [] if INTERPRETED else [group for group in groups if not _mark_of(group).exists()]


def note(group: str) -> None:
    """Note that a group of kernels is compiled."""
    with contextlib.suppress(OSError):
        cache.folder().mkdir(parents=True, exist_ok=True)
        _mark_of(group).touch()


def _mark_of(group: str) -> Path:
    return cache.folder() / f"{group}.{way()}"
