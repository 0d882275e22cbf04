"""Small local patches by name, drivers for the operators, and what must hold after them."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
from builders import mesh, tet_grid, tri_grid

from meshopt_cli import adjacency, formats
from meshopt_cli.kernels import collapse, flip, relocate, shell_swap, split
from meshopt_cli.kernels._jit import entry
from meshopt_cli.kernels.types import N_CELLS, N_POINTS
from meshopt_cli.mesh import Mesh, Simplices, cast
from meshopt_cli.quality import MEASURES, cell_quality
from meshopt_cli.workspace import Workspace

ROOT = Path(__file__).parent.parent
SAMPLE_NAMES = ("raw_ball.mesh", "quadtree.vtk", "two_regions.msh", "plate.vtu", "grid.vtk")

REGULAR = {
    2: np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(3) / 2, 0]]),
    3: np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)[[0, 2, 1, 3]],
}


# Meshes ---------------------------------------------------------------------------------


@cache
def sample(name: str) -> Simplices:
    """The cells of a sample mesh. The only place of these tests that reads a file."""
    read, _ = formats.read(ROOT / "samples" / name)
    return cast(read)


def simplices(patch: Mesh | Simplices) -> Simplices:
    """The cells of a patch, which may be cast already."""
    return cast(patch) if isinstance(patch, Mesh) else patch


def workspace(patch: Mesh | Simplices, measure: str = "aspect-ratio") -> Workspace:
    """A patch as the kernels see it."""
    return Workspace(simplices(patch), MEASURES[measure].code)


def volumes(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Signed volume of each cell, area in the plane, by the determinants (18.1) and (18.3)."""
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    if cells.shape[1] == 3:
        return np.linalg.det(edges[:, :, :2]) / 2
    return np.linalg.det(edges) / 6


def shaken(patch: Mesh, amount: float, seed: int = 0) -> Mesh:
    """The patch with its inner vertices moved at random, all cells still positive."""
    source = cast(patch)
    generator = np.random.default_rng(seed)
    width = patch.points.shape[1]
    step = generator.uniform(-amount, amount, (len(patch.points), width))
    step[np.unique(source.skin)] = 0.0
    start = source.points[:, :width]
    while True:
        moved = source.points.copy()
        moved[:, :width] = start + step
        inverted = volumes(moved, source.cells) < 1e-3 * volumes(source.points, source.cells)
        if not inverted.any():
            return Mesh(moved[:, :width], patch.blocks)
        step[source.cells[inverted]] *= 0.5


def with_regions(patch: Mesh, regions: np.ndarray) -> Mesh:
    """The patch with a region number for each cell of its only block."""
    block = patch.blocks[0]
    block.data = {"gmsh:physical": np.asarray(regions, dtype=np.int64)}
    return patch


def halves(patch: Mesh) -> Mesh:
    """The patch cut into two regions by the plane x = 1/2, as far as its cells allow."""
    centres = patch.points[patch.blocks[0].cells].mean(axis=1)
    return with_regions(patch, (centres[:, 0] > 0.5).astype(int))


def ring(n: int, radius: float = 1.0) -> np.ndarray:
    """Corners of a regular polygon in the plane, (n, 2)."""
    angle = 2 * np.pi * np.arange(n) / n
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def spindle(n: int, height: float = 1.0, shake: float = 0.0, seed: int = 0) -> Mesh:
    """n tets around the edge from vertex 0 up to vertex 1: a closed shell, and nothing else."""
    generator = np.random.default_rng(seed)
    polygon = np.column_stack([ring(n), np.zeros(n)])
    polygon += generator.uniform(-shake, shake, polygon.shape)
    points = np.concatenate([[[0, 0, -height], [0, 0, height]], polygon])
    around = np.arange(n)
    cells = np.stack([0 * around, 0 * around + 1, 2 + around, 2 + (around + 1) % n], axis=1)
    return mesh(points, tetra=cells)


def double_pyramid(height: float = 1.0) -> Mesh:
    """Two tets with one face in common, apexes so high above it: a face swap makes three."""
    points = [*np.column_stack([ring(3), np.zeros(3)]), [0, 0, height], [0, 0, -height]]
    return mesh(points, tetra=[[0, 1, 2, 3], [0, 2, 1, 4]])


def diamond(height: float = 1.0) -> Mesh:
    """Two triangles on both sides of an edge of length 2, apexes so far from it."""
    return mesh([[-1, 0], [1, 0], [0, height], [0, -height]], triangle=[[0, 1, 2], [1, 0, 3]])


def fan(n: int, centre: tuple[float, float] = (0.0, 0.0)) -> Mesh:
    """n triangles around vertex 0: the ball of a vertex in the plane."""
    around = np.arange(n)
    cells = np.stack([0 * around, 1 + around, 1 + (around + 1) % n], axis=1)
    return mesh([centre, *ring(n)], triangle=cells)


def icosahedron(centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """20 tets around vertex 0: the ball of a vertex in space with the degree it should have."""
    golden = (1 + np.sqrt(5)) / 2
    corners = [[0, i, j * golden] for i in (-1, 1) for j in (-1, 1)]
    corners = np.array([np.roll(c, k) for c in corners for k in range(3)])
    near = np.linalg.norm(corners[:, None] - corners, axis=2)
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if max(near[a, b], near[b, c], near[a, c]) < 2.1
    ]
    cells = []
    for a, b, c in faces:
        outward = np.linalg.det(corners[[a, b, c]]) > 0
        cells.append([1 + a, 1 + b, 1 + c, 0] if not outward else [1 + a, 1 + c, 1 + b, 0])
    return mesh([centre, *corners], tetra=cells)


def hexagon_lattice(n: int) -> Mesh:
    """Equilateral triangles that fill a hexagon of side n."""
    inside = [
        (i, j) for i in range(-n, n + 1) for j in range(-n, n + 1) if max(abs(i), abs(j), abs(i + j)) <= n
    ]
    number = {at: k for k, at in enumerate(inside)}
    cells = []
    for i, j in inside:
        for corners in ([(i, j), (i + 1, j), (i, j + 1)], [(i + 1, j), (i + 1, j - 1 + 1), (i, j + 1)]):
            cells.append(corners)
    up = [[(i, j), (i + 1, j), (i, j + 1)] for i, j in inside]
    down = [[(i, j), (i + 1, j - 1), (i + 1, j)] for i, j in inside]
    whole = [[number[c] for c in t] for t in up + down if all(c in number for c in t)]
    points = [[i + j / 2, j * np.sqrt(3) / 2] for i, j in inside]
    return mesh(points, triangle=whole)
