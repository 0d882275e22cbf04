"""How much of a result is luck: a mesh under several numberings of its vertices and cells.

`python tests/benchmarks/spread.py MESH... [--times N] [--preset NAME] [--pieces N,...]` optimizes
each mesh as it is and renumbered so many times, as whole processes, and prints for each figure the
median and the range. What a preset is said to reach is the median. With --pieces it cuts the mesh
in so many pieces, too, and optimizes these.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import native
from judge import Part

FIGURES = ("Q_T", "mean Q", "share below 2", "least °", "cells", "optimize s")


def renumbered(part: Part, seed: int) -> Part:
    """The same mesh, with its vertices and cells in another order; 0 leaves them in theirs."""
    if seed == 0:
        return part
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(part.points))
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    rows = rng.permutation(len(part.cells))
    cells = number[part.cells[rows]]
    turned = cells[:, [1, 2, 0, *range(3, cells.shape[1])]]
    cells = np.where((rng.random(len(cells)) < 0.5)[:, None], turned, cells)
    return replace(part, points=part.points[order], cells=cells, region=part.region[rows])


def runs(part: Part, times: int, preset: str, folder: Path) -> Iterator[tuple[float, ...]]:
    """The figures of each numbering."""
    source, log = folder / "mesh.mesh", folder / "report.json"
    for seed in range(times + 1):
        native.write_medit(source, renumbered(part, seed))
        meshopt("optimize", source, folder / "out.mesh", "--preset", preset, "--report", log)
        yield figures_in(log)


def in_pieces(part: Part, n: int, preset: str, folder: Path) -> tuple[float, ...]:
    """The figures of a mesh that was cut in n pieces."""
    source, log = folder / "mesh.mesh", folder / "report.json"
    native.write_medit(source, part)
    meshopt("split", source, folder / "in.pvtu", "--pieces", n)
    meshopt("optimize", folder / "in.pvtu", folder / "out.pvtu", "--preset", preset,
            "--report", log)  # fmt: skip
    meshopt("check", folder / "out.pvtu")
    return figures_in(log)


def meshopt(*words: object) -> None:
    """Run a command."""
    subprocess.run([sys.executable, "-m", "meshopt_cli", *map(str, words), "-q"], check=True)


def figures_in(log: Path) -> tuple[float, ...]:
    """What a report tells."""
    told = json.loads(log.read_text(encoding="utf-8"))
    after = told["after"]
    return (
        after["worst"], after["mean"], after["histogram"]["percent"][0], after["angle_min"],
        after["ne"], told["seconds"]["optimize"],
    )  # fmt: skip


def shown(values: tuple[float, ...]) -> str:
    """Median, and the range where there is one."""
    least, most = min(values), max(values)
    middle = f"{statistics.median(values):.5g}"
    return middle if least == most else f"{middle} ({least:.5g}-{most:.5g})"


def main(arguments: list[str] | None = None) -> int:
    """Print a line for each mesh."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("meshes", nargs="+", type=Path, metavar="MESH")
    parser.add_argument("--times", type=int, default=10, help="numberings besides its own")
    parser.add_argument("--preset", default="standard")
    parser.add_argument("--pieces", default="", metavar="N,...", help="cut it, too")
    options = parser.parse_args(arguments)
    table = Table(title=f"{options.preset}, {options.times + 1} numberings: median (range)")
    for name in ("mesh", *FIGURES):
        table.add_column(name, justify="left" if name == "mesh" else "right", overflow="fold")
    for path in options.meshes:
        part, _ = native.read_any(path)
        with tempfile.TemporaryDirectory() as folder:
            figures = list(runs(part, options.times, options.preset, Path(folder)))
            table.add_row(path.name, *(shown(values) for values in zip(*figures, strict=True)))
            for n in filter(None, options.pieces.split(",")):
                figures = [in_pieces(part, int(n), options.preset, Path(folder))]
                row = (shown(values) for values in zip(*figures, strict=True))
                table.add_row(f"  in {n} pieces", *row)
    (Console() if sys.stdout.isatty() else Console(width=160)).print(table)
    return 0


if __name__ == "__main__":
    sys.exit(main())
