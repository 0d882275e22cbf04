"""One damaged file and one command, and what must hold whatever comes of it."""

from __future__ import annotations

import contextlib
import io
import logging
import os
import random
import re
import resource
import signal
import time
import zlib
from dataclasses import dataclass
from pathlib import Path

from fuzz.mutate import mutated
from fuzz.seeds import seeds
from meshopt_cli.cli.entry import status_of

SECONDS = 5
MEMORY = 500 << 20  # bytes, over what the process has before
SMALL = 100_000  # bytes of a file for which these hold
# Names of Python's and libraries' errors, and what else no user can make anything of.
FOREIGN = re.compile(
    r"\b[A-Z]\w*(?:Error|Exception|Warning)\b|Traceback|internal error|numpy|meshio|<class"
)
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]")


@dataclass(frozen=True)
class Case:
    """A number, which stands for a file and a command."""

    number: int

    @property
    def dice(self) -> random.Random:
        return random.Random(self.number)

    def file(self, folder: Path) -> Path:
        """The damaged file."""
        dice, known = self.dice, seeds()
        name = dice.choice(sorted(known))
        ending, data = known[name]
        others = [known[other][1] for other in sorted(known)[::9]]
        zipped = ending.endswith(".gz")
        if zipped and dice.random() < 0.5:  # damaged inside
            data = zlib.decompress(data, wbits=31)
            data = _gzipped(mutated(dice, data, others))
        else:
            data = mutated(dice, data, others)
        path = folder / f"case{ending}"
        path.write_bytes(data[:SMALL])
        return path

    def command(self, path: Path, out: Path) -> list[str]:
        """What is done with it."""
        dice = random.Random(self.number + 1)
        output = str(out.with_suffix(dice.choice((".vtu", ".vtk", ".msh", ".mesh", ".meshb"))))
        return dice.choice(
            (
                ["check", str(path)],
                ["check", str(path), "--format", dice.choice(("json", "github", "sarif", "junit"))],
                ["report", str(path), *dice.choice(([], ["--format", "json"]))],
                ["optimize", str(path), output, "--preset", "fast"],
                ["repair", "--all", str(path), output],
            )
        )


def _gzipped(data: bytes) -> bytes:
    packer = zlib.compressobj(wbits=31)
    return packer.compress(data) + packer.flush()


def _late(*_: object) -> None:
    raise TimeoutError(f"it takes more than {SECONDS} s")


def run(arguments: list[str]) -> tuple[int, str, str]:
    """A command line in this process, with its time and memory limited."""
    logging.getLogger("meshopt").handlers[:] = []
    out = io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True)
    err = io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True)
    old = signal.signal(signal.SIGALRM, _late)
    signal.alarm(SECONDS)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = status_of(arguments)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, old)
    return status, *(s.buffer.getvalue().decode(errors="replace") for s in (out, err))


@contextlib.contextmanager
def limited():
    """No more memory than a small file may take; in a process that ends after it."""
    size = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY, resource.RLIM_INFINITY))
    yield
    resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY,) * 2)


def try_case(case: Case, folder: Path) -> tuple[str, int, float]:
    """Run a case: what is wrong with what came of it, "" where nothing is; status, seconds."""
    for old in folder.iterdir():
        old.unlink()
    path = case.file(folder)
    out = folder / "out.vtu"
    arguments = case.command(path, out)
    start = time.perf_counter()
    try:
        status, text, err = run(arguments)
    except BaseException as error:
        return f"{type(error).__name__}: {error}", -1, time.perf_counter() - start
    took = time.perf_counter() - start
    return _wrong(arguments, path, folder, status, text, err), status, took


def _wrong(arguments: list[str], path: Path, folder: Path, status: int, text: str, err: str) -> str:
    if status not in (0, 1, 2, 3):
        return f"status {status}: {err.strip()[-300:]}"
    if status == 2 or "out of memory" in err:
        return f"status {status}: {err.strip()[-300:]}"
    if found := FOREIGN.search(err.replace(str(path), "")) or FOREIGN.search(text):
        return f"it says {found[0]!r}: {err.strip()[-300:]}"
    if found := CONTROL.search(err) or CONTROL.search(text):
        return f"it shows {found[0]!r}: {(err + text).strip()[-300:]!r}"
    errors = [line for line in err.splitlines() if "warning: " not in line]
    if status == 3 and (
        len(errors) != 1 or not (str(path) in errors[0] or str(folder / "out.") in errors[0])
    ):
        return f"{len(errors)} lines for an error: {err.strip()[-500:]}"
    written = list(folder.glob("out.*"))
    if status == 3 and written:
        return f"{written[0].name} is there, and the status is 3"
    left = [p.name for p in folder.iterdir() if p not in (path, *written)]
    if left:
        return f"{left} are left"
    for output in written:
        again, _, complaint = run(["check", str(output)])
        if again > 1 or (arguments[0] == "optimize" and again):
            return f"{output.name} is written, and check says {again}: {complaint.strip()[-300:]}"
    return ""
