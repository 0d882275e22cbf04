"""What presets make of quads, pyramids, wedges, hexahedra and mixed meshes.

`python tests/benchmarks/cells.py MESH... [--preset NAME]` optimizes each mesh as a whole process,
and prints the least scaled Jacobian of a corner, the mean of the least of each cell, and how many
cells have a corner that is not positive, before and after; whether the boundary kept every bit; and
times. The judge shares no code with the package: corners are found here, from the files as meshio
reads them.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import meshio
import numpy as np
from rich.console import Console
from rich.table import Table

Array = np.ndarray

# A vertex and its neighbours along the edges, so that the corner is positive in a valid cell.
CORNERS = {
    "triangle": [(0, 1, 2)],
    "quad": [(0, 1, 3), (1, 2, 0), (2, 3, 1), (3, 0, 2)],
    "tetra": [(0, 1, 2, 3)],
    "pyramid": [(0, 1, 3, 4), (1, 2, 0, 4), (2, 3, 1, 4), (3, 0, 2, 4)],
    "wedge": [(0, 1, 2, 3), (1, 2, 0, 4), (2, 0, 1, 5), (3, 5, 4, 0), (4, 3, 5, 1), (5, 4, 3, 2)],
    "hexahedron": [(0, 1, 3, 4), (1, 2, 0, 5), (2, 3, 1, 6), (3, 0, 2, 7),
                   (4, 7, 5, 0), (5, 4, 6, 1), (6, 5, 7, 2), (7, 6, 4, 3)],
}  # fmt: skip
FACETS = {
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "quad": [(0, 1), (1, 2), (2, 3), (3, 0)],
    "tetra": [(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)],
    "pyramid": [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (0, 3, 2, 1)],
    "wedge": [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
    "hexahedron": [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6),
                   (3, 0, 4, 7)],
}  # fmt: skip
SOLIDS = ("tetra", "pyramid", "wedge", "hexahedron")


def cells_of(mesh: meshio.Mesh) -> dict[str, Array]:
    """The cells of the greatest dimension by type."""
    found = {kind: [b.data for b in mesh.cells if b.type == kind] for kind in CORNERS}
    there = {kind: np.concatenate(parts) for kind, parts in found.items() if parts}
    solid = {kind: cells for kind, cells in there.items() if kind in SOLIDS}
    return solid or there


def jacobians(points: Array, cells: dict[str, Array]) -> Array:
    """The least scaled Jacobian of each cell; faces as they are seen from above."""
    least = []
    for kind, rows in cells.items():
        corners = []
        for corner in CORNERS[kind]:
            e = [points[rows[:, v]] - points[rows[:, corner[0]]] for v in corner[1:]]
            across = np.cross(e[0], e[1])
            det = across[:, 2] if len(e) == 2 else np.einsum("ij,ij->i", across, e[2])
            length = np.prod([np.linalg.norm(v, axis=1) for v in e], axis=0)
            corners.append(det / np.where(length > 0, length, 1.0))
        least.append(np.min(corners, axis=0))
    return np.concatenate(least)


def boundary(points: Array, cells: dict[str, Array]) -> list[bytes]:
    """The points of facets that occur once, bit by bit."""
    seen: dict[tuple[int, ...], int] = {}
    for kind, rows in cells.items():
        for facet in FACETS[kind]:
            for row in np.sort(rows[:, facet], axis=1).tolist():
                seen[tuple(row)] = seen.get(tuple(row), 0) + 1
    alone = sorted({v for facet, n in seen.items() if n == 1 for v in facet})
    return [points[v].tobytes() for v in alone]


def judged(path: Path) -> tuple[Array, list[bytes]]:
    mesh = meshio.read(path)
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.points.shape[1]] = mesh.points
    cells = cells_of(mesh)
    return jacobians(points, cells), boundary(points, cells)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("--preset", default="standard")
    options = parser.parse_args()
    table = Table("mesh", "cells", "before", "bad", "after", "bad ", "boundary", "s", "passes s")
    for path in options.meshes:
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "out.vtu"
            ask = ["optimize", path, out, "--preset", options.preset, "--json"]
            ran = subprocess.run(
                [sys.executable, "-m", "meshopt_cli", *ask], capture_output=True, check=False
            )
            if ran.returncode:
                table.add_row(path.name, "", ran.stderr.decode().splitlines()[-1][:60])
                continue
            report = json.loads(ran.stdout)
            (before, rim), (after, kept) = judged(path), judged(out)
        table.add_row(
            path.name, f"{len(before):,}",
            f"{before.min():.3f} {before.mean():.3f}", str((before <= 0).sum()),
            f"{after.min():.3f} {after.mean():.3f}", str((after <= 0).sum()),
            "kept" if rim == kept else "moved", f"{sum(report['seconds'].values()):.2f}",
            f"{sum(line['seconds'] for line in report['passes']):.2f}",
        )  # fmt: skip
    Console(width=140).print(table)


if __name__ == "__main__":
    main()
