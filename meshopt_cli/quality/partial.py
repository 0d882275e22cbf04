"""What can be measured of a mesh that cannot be optimized."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import UnsupportedMeshError
from ..mesh import adjacency
from ..mesh.cast import Simplices, cast
from ..mesh.model import DIMENSION, Array, Block, Mesh, dimension_of, main_type
from ..mesh.plane import flatness, plane_of, with_depth

# The simplex of each dimension.
_WANTED = {2: "triangle", 3: "tetra"}


class Part(NamedTuple):
    """The simplices of a mesh, how many vertices they have, and what of it they leave out."""

    simplices: Simplices
    n_points: int
    notes: tuple[str, ...]


def measurable(mesh: Mesh) -> Part:
    """The simplices of a mesh, as far as there are any.

    Parameters
    ----------
    mesh : Mesh
        Its vertex numbers are in range.

    Returns
    -------
    Part
        With the simplices of `cast`, if it takes the mesh. Else those of highest dimension; of
        second-order ones the corners, of triangles in space each by itself in a plane.

    Raises
    ------
    BadMeshError, UnsupportedMeshError
        There are no simplices in it.
    """
    notes: list[str] = []
    try:
        main_type(mesh)
    except UnsupportedMeshError:
        mesh, notes = _simplices_only(mesh)
    n_points = 0
    if mesh.dimension() == 2:
        cells = np.concatenate([b.cells for b in mesh.blocks if b.type == "triangle"])
        points = with_depth(mesh.points)
        tolerance = flatness(points[adjacency.distinct(cells)], mesh.points.dtype)
        if plane_of(points, cells, tolerance) is None:
            notes.append("each triangle of the surface is measured in its own plane")
            mesh, n_points = _side_by_side(points[cells]), len(adjacency.distinct(cells))
    simplices = cast(mesh)
    return Part(simplices, n_points or len(adjacency.distinct(simplices.cells)), tuple(notes))


def _simplices_only(mesh: Mesh) -> tuple[Mesh, list[str]]:
    wanted = _WANTED[mesh.dimension()]
    kept, curved = [], 0
    left: dict[str, int] = {}
    for block in mesh.blocks:
        stem = block.type.rstrip("0123456789")
        if stem == wanted and len(block.cells):
            curved += len(block.cells) * (block.type not in DIMENSION)
            corners = block.cells[:, : mesh.dimension() + 1]
            kept.append(Block(wanted, np.ascontiguousarray(corners)))
        elif dimension_of(block.type) == mesh.dimension() and len(block.cells):
            left[block.type] = left.get(block.type, 0) + len(block.cells)
    if not kept:
        main_type(mesh)  # which says so
    notes = [f"{n:,} cells of type {cell_type} are left out" for cell_type, n in left.items()]
    if curved:
        notes.append(f"{curved:,} cells of higher order are measured by their corners")
    return Mesh(mesh.points, kept), notes


def _side_by_side(corners: Array) -> Mesh:
    """Triangles of space, (n, 3, 3), each in the plane z = 0 with points of its own."""
    along = corners[:, 1] - corners[:, 0]
    across = corners[:, 2] - corners[:, 0]
    base = np.linalg.norm(along, axis=1)
    u = along / np.where(base > 0.0, base, 1.0)[:, None]
    x = np.einsum("ij,ij->i", across, u)
    height = np.linalg.norm(np.cross(u, across), axis=1)
    points = np.zeros((len(corners), 3, 2))
    points[:, 1, 0] = base
    points[:, 2, 0], points[:, 2, 1] = x, height
    cells = np.arange(3 * len(corners)).reshape(-1, 3)
    return Mesh(points.reshape(-1, 2), [Block("triangle", cells)])
