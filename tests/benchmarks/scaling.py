"""How time and memory grow with the number of cells.

`python tests/benchmarks/scaling.py [CELLS...] [--preset NAME]` makes a raw Delaunay mesh of a ball
of about so many tetrahedra, slivers included, for each number; optimizes it as a whole process on
one core; and prints one line for each. Needs the extra `samples`.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import native
from judge import Part

CHILD = Path(__file__).with_name("child.py")
CELLS = (50_000, 200_000, 500_000, 1_000_000, 2_000_000)
SMALL = 1_000  # cells of a mesh whose run takes what a run takes in any case
PER_POINT = 6.5  # tetrahedra
COLUMNS = ("cells", "whole s", "passes s", "passes µs/cell", "peak MiB", "bytes/cell",
           "less start", "Q_T before", "Q_T after")  # fmt: skip


def ball(n_cells: int) -> Part:
    """Delaunay mesh of points on a sphere and of a shaken lattice inside it."""
    from scipy.spatial import Delaunay

    n_points = n_cells / PER_POINT
    side = (4.0 * np.pi / 3.0 / n_points) ** (1.0 / 3.0)
    n_surface = int(4.0 * np.pi / side**2)
    # Spiral of Fibonacci.
    z = 1.0 - (2.0 * np.arange(n_surface) + 1.0) / n_surface
    turn = np.arange(n_surface) * np.pi * (3.0 - np.sqrt(5.0))
    surface = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(n_surface)])
    surface = surface * np.sqrt(1.0 - z**2)[:, None] + z[:, None] * [0.0, 0.0, 1.0]
    ticks = np.arange(-1.0, 1.0, side)
    lattice = np.stack(np.meshgrid(ticks, ticks, ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    lattice += np.random.default_rng(1).uniform(-0.3, 0.3, lattice.shape) * side
    inner = lattice[np.linalg.norm(lattice, axis=1) < 1.0 - 0.6 * side]
    points = np.concatenate([surface, inner])
    cells = Delaunay(points).simplices.astype(np.int64)
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    volume = np.linalg.det(edges)
    cells[volume < 0, 2:] = cells[volume < 0, :1:-1]
    cells = cells[np.abs(volume) > 1e-6 * side**3]  # four vertices of a face of the hull
    return Part(points, cells, np.ones(len(cells), dtype=np.int64))


def measured(part: Part, preset: str, folder: Path) -> tuple[dict[str, float], dict]:
    """What a run took, and its report."""
    source, log = folder / "ball.mesh", folder / "report.json"
    native.write_medit(source, part)
    meter = [sys.executable, "-I", "-S", str(CHILD), "meter", "3600", "1", str(log)]
    command = [sys.executable, "-m", "meshopt_cli", "optimize", str(source),
               str(folder / "out.mesh"), "--preset", preset, "--json"]  # fmt: skip
    told = subprocess.run([*meter, *command], capture_output=True, text=True, check=True)
    text = log.read_text(encoding="utf-8")
    return json.loads(told.stdout), json.loads(text[text.index("{") :])


def row(took: dict[str, float], report: dict, start: float) -> list[str]:
    """The cells of the table, in the order of `COLUMNS`; `start` is the memory of a small run."""
    n_cells = report["before"]["ne"]
    seconds = sum(line["seconds"] for line in report["passes"])
    return [
        f"{n_cells:,}",
        f"{took['seconds']:.2f}",
        f"{seconds:.2f}",
        f"{1e6 * seconds / n_cells:.2f}",
        f"{took['peak']:.0f}",
        f"{took['peak'] * 2**20 / n_cells:.0f}",
        f"{(took['peak'] - start) * 2**20 / n_cells:.0f}",
        f"{report['before']['worst']:.3g}",
        f"{report['after']['worst']:.3g}",
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("cells", nargs="*", type=int, default=CELLS)
    parser.add_argument("--preset", default="standard")
    options = parser.parse_args()
    table = Table(*COLUMNS, title=f"preset {options.preset}, one core")
    with tempfile.TemporaryDirectory() as folder:
        # The first run compiles the kernels.
        for _ in range(2):
            took, _ = measured(ball(SMALL), options.preset, Path(folder))
        for n_cells in options.cells:
            table.add_row(
                *row(*measured(ball(n_cells), options.preset, Path(folder)), took["peak"])
            )
    Console(width=120).print(table)


if __name__ == "__main__":
    main()
