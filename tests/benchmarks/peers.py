"""Compare this tool with others on the same meshes, with the boundary kept.

`python tests/benchmarks/peers.py MESH... [--tools NAMES] [--runs N] [--markdown FILE]`. Each
tool runs as a whole process on a file of a kind that it reads natively, made before the clock
starts, and a judge that shares no code with any of them measures what comes out. Tools that are
not installed are left out with a line that says so; `pip install '.[bench]'` brings those that
PyPI has.
"""

from __future__ import annotations

import argparse
import json
import logging
import math
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

from rich.console import Console
from rich.table import Table

import native
from judge import Verdict, judge
from meshopt_cli.errors import MeshoptError
from tools import TOOLS, Job, Meshopt

CHILD = Path(__file__).with_name("child.py")
SAMPLES = Path(__file__).parents[2] / "samples"
# Small meshes by dimension: a first run on them compiles all kernels there are.
WARM_UP = {2: SAMPLES / "quadtree.vtk", 3: SAMPLES / "grid.vtk"}
COLUMNS = (
    ("tool", "left"),
    ("status", "left"),
    ("whole s", "right"),
    ("optimize s", "right"),
    ("peak MiB", "right"),
    ("1-2", "right"),
    ("2-3", "right"),
    ("3-10", "right"),
    (">10", "right"),
    ("Q_T", "right"),
    ("mean Q", "right"),
    ("least °", "right"),
    ("greatest °", "right"),
    ("cells", "right"),
    ("vertices", "right"),
    ("boundary", "left"),
)


@dataclass
class Result:
    """What a tool did to a mesh.

    Attributes
    ----------
    status : str
        "ok", or in one line what went wrong.
    seconds, cpu, peak : float, optional
        Of the whole process: the least of the runs, and the most memory in MiB.
    optimize : float, optional
        Seconds without reading and writing, where the tool tells them.
    """

    tool: str
    status: str
    version: str = ""
    command: str = ""
    seconds: float | None = None
    cpu: float | None = None
    optimize: float | None = None
    peak: float | None = None
    verdict: Verdict | None = None


def run(name: str, job: Job, runs: int, limit: float, cores: int) -> Result:
    """Run a tool on a mesh a few times, and judge what it wrote the last time."""
    tool = TOOLS[name]
    version = tool.version()
    if version is None:
        return Result(name, "absent")
    if isinstance(tool, Meshopt):
        _warm_up(job.part.dimension)
    try:
        command = tool.command(job)
    except Exception as error:  # libraries raise anything
        return Result(name, f"not converted: {_line(str(error))}", version)
    result = Result(name, "ok", version, " ".join(command))
    log = job.folder / f"{name}.log"
    for _ in range(runs):
        meter = [sys.executable, "-I", "-S", str(CHILD), "meter", str(limit), str(cores), str(log)]
        told = subprocess.run([*meter, *command], capture_output=True, text=True, check=True)
        took = json.loads(told.stdout)
        text = log.read_text(encoding="utf-8", errors="replace")
        if took["late"]:
            result.status = f"timeout after {limit:g} s"
        elif took["status"]:
            result.status = f"failed ({took['status']}): {_line(text)}"
        if result.status != "ok":
            return result
        for figure, value in (*took.items(), ("optimize", tool.optimize(text))):
            if figure in ("seconds", "cpu", "optimize") and value is not None:
                known = getattr(result, figure)
                setattr(result, figure, value if known is None else min(known, value))
        result.peak = max(result.peak or 0.0, took["peak"])
    try:
        result.verdict = judge(tool.result(job), job.part)
    except Exception as error:  # whatever is wrong with a file that a peer wrote
        result.status = f"result not readable: {_line(str(error) or type(error).__name__)}"
    else:
        if result.verdict.invalid:
            result.status = f"{result.verdict.invalid} cells not positive"
    return result


def compare(source: Path, names: list[str], options: argparse.Namespace) -> Iterator[Result]:
    """Run tools on a mesh, and yield first what it is worth itself."""
    part, plane = native.read_any(source)
    before = judge(part)
    if before.invalid:
        raise native.UnusableError(f"{before.invalid} cells are not positive: nothing to compare")
    yield Result("input", "", verdict=before)
    with tempfile.TemporaryDirectory() as folder:
        job = Job(source.resolve(), part, plane, Path(folder))
        for name in names:
            if part.dimension in TOOLS[name].dimensions:
                yield run(name, job, options.runs, options.timeout, options.cores)
                job.clear()


def row(result: Result) -> list[str]:
    """The cells of the table, in the order of `COLUMNS`."""
    times = ("" if v is None else f"{v:.3g}" for v in (result.seconds, result.optimize))
    start = [result.tool, result.status, *times, _figure(result.peak, 0)]
    verdict = result.verdict
    if verdict is None:
        return [*start, *[""] * (len(COLUMNS) - len(start))]
    return [
        *start,
        *(_figure(p, 2) for p in verdict.percent),
        f"{verdict.worst:.4g}",
        _figure(verdict.mean, 3),
        _figure(verdict.angle_min, 1),
        _figure(verdict.angle_max, 1),
        f"{verdict.cells:,}",
        f"{verdict.vertices:,}",
        "" if result.tool == "input" else verdict.boundary,
    ]


def markdown(title: str, rows: list[list[str]]) -> str:
    """The table of a mesh for a Markdown file."""
    rule = ["---:" if side == "right" else "---" for _, side in COLUMNS]
    lines = [[name for name, _ in COLUMNS], rule, *rows]
    return f"## {title}\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Print a table for each mesh; the exit status is 1 when one of them cannot be read."""
    options = _parser().parse_args(arguments)
    logging.getLogger("meshopt").setLevel(logging.ERROR)
    names = [name for name in options.tools.split(",") if name]
    unknown = [name for name in names if name not in TOOLS]
    if unknown:
        _parser().error(f"no tool {', '.join(unknown)}: choose from {', '.join(TOOLS)}")
    console = Console() if sys.stdout.isatty() else Console(width=200)
    cores = f"{options.cores} core(s)" if options.cores else "all cores"
    about = f"{platform.machine()}, {os.cpu_count()} cores, each tool on {cores}"
    found = {name: TOOLS[name].version() for name in names}
    versions = ", ".join(dict.fromkeys(v for v in found.values() if v))
    console.print(f"{about}; {versions}; best of {options.runs}", highlight=False)
    for name in [name for name, version in found.items() if not version]:
        console.print(f"{name}: absent", highlight=False)
    names = [name for name in names if found[name]]
    texts, records, failed = [f"{about}; {versions}; best of {options.runs}\n"], [], False
    for path in options.meshes:
        try:
            results = list(compare(path, names, options))
        except (MeshoptError, native.UnusableError) as error:
            text = str(error)
            print(text if str(path) in text else f"{path}: {text}", file=sys.stderr)
            failed = True
            continue
        table = Table(title=path.name, title_justify="left")
        for name, side in COLUMNS:
            table.add_column(name, justify=side, overflow="fold", no_wrap=side == "right")
        rows = [row(result) for result in results]
        for cells in rows:
            table.add_row(*cells)
        console.print(table)
        texts.append(markdown(path.name, rows))
        records += [_record(path, result) for result in results]
    if options.markdown:
        options.markdown.write_text("\n".join(texts), encoding="utf-8")
    if options.json:
        options.json.write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")
    return int(failed)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("meshes", nargs="+", type=Path, metavar="MESH")
    parser.add_argument("--tools", default=",".join(TOOLS), help="names with commas between")
    parser.add_argument("--runs", type=int, default=1, help="of which the fastest counts")
    parser.add_argument("--timeout", type=float, default=300.0, help="seconds for a run")
    parser.add_argument("--cores", type=int, default=1, help="for each tool; 0 stands for all")
    parser.add_argument("--markdown", type=Path, metavar="FILE")
    parser.add_argument("--json", type=Path, metavar="FILE")
    return parser


def _record(path: Path, result: Result) -> dict[str, object]:
    record = {"mesh": path.name, **asdict(result)}
    verdict = record["verdict"] or {}
    for name in ("worst", "mean"):
        if not math.isfinite(verdict.get(name, 0.0)):
            verdict[name] = None  # JSON has no infinity
    return record


@cache
def _warm_up(dimension: int) -> None:
    """Compile our kernels, which is done once on a machine and no part of a run."""
    with tempfile.TemporaryDirectory() as folder:
        files = [str(WARM_UP[dimension]), str(Path(folder) / "warm.vtk")]
        command = [sys.executable, "-m", "meshopt_cli", "optimize", *files, "--preset", "best"]
        subprocess.run(command, capture_output=True, check=False)


def _line(text: str) -> str:
    """The last line that says something."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1][:100] if lines else "no message"


def _figure(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"


if __name__ == "__main__":
    sys.exit(main())
