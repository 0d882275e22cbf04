"""Compile all kernels into one shared library, for a wheel: `python building/kernels.py FOLDER`.

numba makes an object file of each entry, for a baseline processor, and the C compiler links them
(`CC`, else `cc`); it compiles nothing. Python and numba of any version can call what comes out.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import shlex
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[1]

# Nothing that the machine has beyond the processor of the library, and no functions of Intel's.
ENVIRONMENT = {"NUMBA_CPU_FEATURES": "", "NUMBA_DISABLE_INTEL_SVML": "1"}


class Object(NamedTuple):
    """An object file of one entry."""

    name: str  # of the function in it
    image: bytes
    results: str  # layout of what it returns


def prepare() -> None:
    """Make this process, and those that it starts, compile for the processor of the library.

    numba reads its variables when it is imported.
    """
    sys.path.insert(0, str(ROOT))
    from meshopt_cli.compiled import library

    for name in [name for name in os.environ if name.startswith("NUMBA_")]:
        del os.environ[name]
    os.environ.update(ENVIRONMENT, NUMBA_CPU_NAME=library.PROCESSOR)


def compiled(entry: Any, arguments: tuple[Any, ...]) -> Object:
    """An entry compiled for arguments of the types of these, to go into a library."""
    from llvmlite import binding

    from meshopt_cli.compiled import jit, library, words

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    machine = binding.Target.from_default_triple().create_target_machine(
        cpu=library.PROCESSOR, opt=3, reloc="pic", codemodel="small"
    )
    name = entry.name(words.flatten(arguments)[0])
    return Object(name, *jit.compile_entry(entry.py_func, arguments, name, machine))


def compiled_groups(groups: list[str]) -> list[Object]:
    """All entries of some groups of kernels."""
    from meshopt_cli import warmup

    work = warmup.specimen()
    return [
        compiled(entry, entry.example(work))
        for entry in warmup.entries()
        if entry.group in groups and entry.example is not None
    ]


def link(objects: list[Object], sources: str, folder: Path) -> None:
    """Write the library, and what tells whether it fits: the digest of its sources among it."""
    from meshopt_cli.compiled import library

    objects = sorted(objects)
    parts = [folder / f"{number}.o" for number in range(len(objects))]
    for part, made in zip(parts, objects, strict=True):
        part.write_bytes(made.image)
    # What numba leaves there for Python is no part of it.
    exports = folder / "exports"
    names = " ".join(f'"{made.name}";' for made in objects)
    exports.write_text(f"{{ global: {names} local: *; }};\n")
    out = folder / library.NAME
    linker = shlex.split(os.environ.get("CC", "cc"))
    options = ["-shared", "-nostartfiles", "-s", "-Wl,-z,defs", "-Wl,--build-id=none",
               "-Wl,--gc-sections", f"-Wl,--version-script={exports}"]  # fmt: skip
    try:
        subprocess.run([*linker, *options, "-o", out, *parts, "-lm", "-lc"], check=True)
    except FileNotFoundError:
        sys.exit(f"no {linker[0]} to link the kernels: install a C compiler, or name one by CC")
    for part in (*parts, exports):
        part.unlink()
    manifest = {
        "library": hashlib.sha256(out.read_bytes()).hexdigest(),
        "sources": sources,
        "results": {made.name: made.results for made in objects},
    }
    (folder / library.MANIFEST).write_text(json.dumps(manifest, indent=1) + "\n")


def main(folder: Path) -> None:
    """Write library and manifest into a folder."""
    prepare()
    from meshopt_cli.compiled import cache
    from meshopt_cli.cores import n_cores
    from meshopt_cli.warmup import GROUPS, shares_of

    sources = cache.digest_of_sources()
    shares = shares_of(GROUPS, n_cores())
    with ProcessPoolExecutor(len(shares), get_context("spawn")) as pool:
        objects = itertools.chain(*pool.map(compiled_groups, shares))
        link(list(objects), sources, folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
