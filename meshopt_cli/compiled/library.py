"""The compiled kernels that a wheel for a platform brings along, in one shared library.

They are built for a baseline processor, of the sources in the same wheel, and need neither numba
nor llvmlite: see `building/kernels.py` in the repository. A wheel for all platforms has none.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import logging
from pathlib import Path
from typing import NamedTuple

from . import cache
from .call import Call
from .once import once
from .words import Words

log = logging.getLogger("meshopt")

NAME = "kernels.so"
MANIFEST = "kernels.json"
FOLDER = Path(__file__).parent

PROCESSOR = "x86-64-v3"
# What Linux calls what such a processor has: https://gitlab.com/x86-psABIs/x86-64-ABI, 3.1.1.
FEATURES = {
    "cx16", "lahf_lm", "popcnt", "pni", "sse4_1", "sse4_2", "ssse3",
    "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe",
}  # fmt: skip
_PROCESSORS = Path("/proc/cpuinfo")


class Library(NamedTuple):
    """A library that fits, or why it does not."""

    code: ctypes.CDLL | None
    results: dict[str, str]  # by the name of an entry, which is that of the function too
    unfit: str  # "" where it fits, and where there is none


@once
def opened() -> Library:
    """The library of this package; where it does not fit, the log has a line that says why."""
    try:
        text = (FOLDER / MANIFEST).read_text(encoding="utf-8")
    except OSError:
        return Library(None, {}, "")
    try:
        manifest = json.loads(text)
        unfit = _unfit(manifest)
        if not unfit:
            return Library(ctypes.CDLL(str(FOLDER / NAME)), dict(manifest["results"]), "")
    except (OSError, ValueError, LookupError, TypeError) as error:
        unfit = f"damaged ({' '.join(str(error).split())})"
    log.info("the compiled kernels of this package are not used: %s", unfit)
    return Library(None, {}, unfit)


def _unfit(manifest: dict[str, str]) -> str:
    """Why a library is not to be used; "" where nothing says so."""
    if settings := cache.settings():
        return f"{', '.join(name for name, _ in settings)} in the environment"
    if manifest["sources"] != cache.digest_of_sources():
        return "built of other sources"
    if hashlib.sha256((FOLDER / NAME).read_bytes()).hexdigest() != manifest["library"]:
        return f"{NAME} is damaged"
    lacking = FEATURES - _features()
    return f"the processor lacks {', '.join(sorted(lacking))}" if lacking else ""


def _features() -> set[str]:
    """What the processor has, as Linux tells it."""
    # The first record is enough, and the rest takes long on a machine of many cores.
    with _PROCESSORS.open("rb", buffering=0) as stream:
        for line in stream.read(8192).splitlines():
            key, _, value = line.partition(b":")
            if key.strip() == b"flags":
                return set(value.decode().split())
    return set()


def find(name: str, words: Words) -> Call | None:
    """The code of an entry, ready to run; None where the library does not have it.

    Parameters
    ----------
    name : str
        Of the entry and the layout of its arguments.
    words : list
        Of some arguments of that layout.
    """
    library = opened()
    if library.code is None or name not in library.results:
        return None
    address = ctypes.cast(library.code[name], ctypes.c_void_p).value
    assert address is not None
    return Call(address, library.code, words, library.results[name])
