"""What can be measured of a mesh that cannot be optimized."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..cells import FAMILIES, SIMPLICES, family_of
from ..errors import UnsupportedMeshError
from ..mesh.cast import Simplices, cast
from ..mesh.model import Array, Block, Mesh, declared, main_type, top_blocks
from ..mesh.plane import plane_of, precision_of, with_depth
from ..mesh.second_order import by_corners, is_second_order


class Part(NamedTuple):
    """The simplices of a mesh, and what of it they leave out."""

    simplices: Simplices
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
        second-order ones the corners; triangles of a surface stay in space, with no `frame`.

    Raises
    ------
    BadMeshError, UnsupportedMeshError
        There are no simplices in it.
    """
    notes: list[str] = []
    if is_second_order(mesh):
        n = sum(len(block.cells) for block in top_blocks(mesh))
        notes.append(_by_corners(n))
        mesh = by_corners(mesh)
    try:
        main_type(mesh)
    except UnsupportedMeshError:
        mesh, more = _simplices_only(mesh)
        notes += more
    if mesh.dimension() == 2:
        cells = declared(mesh, main_type(mesh))
        points = with_depth(mesh.points)
        if plane_of(points, cells, precision_of(mesh.points)) is None:
            notes.append("each triangle of the surface is measured in its own plane")
            return Part(_surface(points, cells), tuple(notes))
    return Part(cast(mesh), tuple(notes))


def _surface(points: Array, triangles: Array) -> Simplices:
    """Triangles in space, of which nothing is known but where they are."""
    return Simplices(
        points,
        triangles,
        region=np.zeros(len(triangles), np.int64),
        fixed=np.zeros(len(points), bool),
        facets=np.empty((0, 2), np.int64),
        edges=np.empty((0, 2), np.int64),
        frame=None,
        single=False,
        turned=False,
    )


def _by_corners(n: int) -> str:
    return f"{n:,} cells of higher order are measured by their corners"


def _simplices_only(mesh: Mesh) -> tuple[Mesh, list[str]]:
    wanted = FAMILIES[SIMPLICES[mesh.dimension()]]
    kept, curved = [], 0
    left: dict[str, int] = {}
    for block in top_blocks(mesh):
        if family_of(block.type) is wanted:
            curved += len(block.cells) * (block.type not in FAMILIES)
            corners = np.ascontiguousarray(block.cells[:, : wanted.n_corners])
            kept.append(Block(wanted.name, corners, block.data))
        else:
            left[block.type] = left.get(block.type, 0) + len(block.cells)
    if not kept:
        main_type(mesh)  # which says so
    notes = [f"{n:,} cells of type {cell_type} are left out" for cell_type, n in left.items()]
    if curved:
        notes.append(_by_corners(curved))
    return Mesh(mesh.points, kept, regions=mesh.regions), notes
