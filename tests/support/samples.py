"""Where things are, and the sample meshes."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from meshopt_cli import formats
from meshopt_cli.mesh.cast import Simplices, cast
from meshopt_cli.mesh.model import Block, Mesh

ROOT = Path(__file__).parents[2]
SAMPLES = ROOT / "samples"
SAMPLE_NAMES = ("raw_ball.mesh", "quadtree.vtk", "two_regions.msh", "plate.vtu", "grid.vtk")


@cache
def sample(name: str) -> Simplices:
    """The cells of a sample mesh. The only place of these tests that reads a file."""
    read, _ = formats.read(SAMPLES / name)
    return cast(read)


def raw_ball():
    """A mesh of which every pass has something to change."""
    of = sample("raw_ball.mesh")
    return Mesh(of.points.copy(), [Block("tetra", of.cells.copy())])
