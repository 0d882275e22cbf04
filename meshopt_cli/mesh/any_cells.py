"""The cells of a mesh of any families, to be worked on where they are: only points move."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..errors import UnsupportedMeshError
from .adjacency import distinct
from .borders import of_mesh
from .facets import CellSet
from .model import Array, Mesh, declared, top_blocks
from .plane import Frame, plane_of, precision_of, with_depth
from .sizes import contents
from .tags import CORNER, REQUIRED, flagged, regions_of


@dataclass
class AnyCells:
    """The cells of greatest dimension of a mesh.

    Attributes
    ----------
    points : (np, 3) float64
        All points of the file; in the plane of the mesh, with z = 0, where d = 2.
    cell_sets : list of CellSet
        Cells by family, a set for each block of the file, numbered in its order.
    fixed : (np,) bool
        Vertices of the boundary, of interfaces, and what the file declares.
    region : (nc,) int64
        Region of each cell by its number.
    stays : (nc,) bool
        Cells that keep their vertices.
    lines : (n, 2) int64
        Edges of the plane that the file declares.
    frame : Frame or None
        Where the plane of a planar mesh lies in space.
    single : bool
        Whether the file stores coordinates in single precision.
    mirrored : bool
        Whether z has the other sign than in the file, whose cells are all listed the other way
        round.
    """

    points: Array
    cell_sets: list[CellSet]
    fixed: Array
    region: Array
    stays: Array
    lines: Array
    frame: Frame | None
    single: bool
    mirrored: bool = False

    @property
    def dimension(self) -> int:
        return FAMILIES[self.cell_sets[0].family].dimension

    @property
    def families(self) -> tuple[str, ...]:
        """In the order of `FAMILIES`."""
        there = {group.family for group in self.cell_sets}
        return tuple(family for family in FAMILIES if family in there)

    @property
    def n_cells(self) -> int:
        return sum(len(group.cells) for group in self.cell_sets)


def is_of_any_cells(mesh: Mesh) -> bool:
    """Whether the main cells are of known families and first order, not all of them simplices."""
    types = {block.type for block in top_blocks(mesh)}
    return mesh.dimension() >= 2 and types <= FAMILIES.keys() and types != {
        SIMPLICES[mesh.dimension()]
    }  # fmt: skip


def cast_any(mesh: Mesh) -> AnyCells:
    """Take from a mesh what is worked on.

    The mesh is one of those that `is_of_any_cells` tells, and its neighbours agree.

    Raises
    ------
    UnsupportedMeshError
        Faces do not lie in a plane.
    """
    bordered = of_mesh(mesh)
    points = with_depth(mesh.points)
    fixed = bordered.bound.copy()
    frame = None
    if bordered.dimension == 2:
        halves = [group.cells[:, half] for group in bordered.cell_sets
                  for half in FAMILIES[group.family].partitions[0]]  # fmt: skip
        frame = plane_of(points, np.concatenate(halves), precision_of(mesh.points))
        if frame is None:
            raise UnsupportedMeshError(
                "the cells do not lie in one plane: surfaces in space cannot be optimized here; "
                "meshopt check and report take them"
            )
        points = frame.flatten(points)
    _fix_declared(mesh, fixed)
    sign = points if bordered.dimension == 3 else points[:, :2]
    total = sum(float(contents(sign, g.cells, g.family).sum()) for g in bordered.cell_sets)
    single = mesh.points.dtype == np.float32
    top = top_blocks(mesh)
    stays = [flagged(b.data[REQUIRED]) if REQUIRED in b.data else np.zeros(len(b.cells), bool)
             for b in top]  # fmt: skip
    cells = AnyCells(
        points, bordered.cell_sets, fixed, regions_of(top, mesh.regions), np.concatenate(stays),
        declared(mesh, "line"), frame, single,
    )  # fmt: skip
    return _mirrored(cells) if total < 0.0 else cells


def _mirrored(cells: AnyCells) -> AnyCells:
    """Cells that are all listed the other way round, as a mirror sees them."""
    axes = np.array([1.0, -1.0, -1.0])[:, None]
    if cells.frame is not None:
        frame = Frame(cells.frame.origin, cells.frame.axes * axes)
        return replace(cells, points=cells.points * np.array([1.0, -1.0, 1.0]), frame=frame)
    return replace(cells, points=cells.points * np.array([1.0, 1.0, -1.0]), mirrored=True)


def _fix_declared(mesh: Mesh, fixed: Array) -> None:
    """Fix what the file declares: vertices, edges, required cells, periodic sides."""
    used = distinct(np.concatenate([block.cells.ravel() for block in top_blocks(mesh)]))
    vertices = distinct(declared(mesh, "vertex"))
    # A file that declares every vertex says nothing by it.
    if len(vertices) < len(used):
        fixed[vertices] = True
    for block in mesh.blocks:
        is_lower = len(block.cells) and not any(block is one for one in top_blocks(mesh))
        if is_lower and block.type not in ("vertex",):
            fixed[block.cells] = True
        if REQUIRED in block.data:
            fixed[block.cells[flagged(block.data[REQUIRED])]] = True
    for name in (CORNER, REQUIRED):
        if name in mesh.point_data:
            fixed |= flagged(mesh.point_data[name])
    for link in mesh.periodic:
        fixed[link.pairs] = True


def with_cells(mesh: Mesh, before: AnyCells, after: AnyCells) -> Mesh:
    """A mesh as it was worked on: what did not change keeps every bit, and its place.

    Parameters
    ----------
    before, after : AnyCells
        What `cast_any` gives for the mesh, and what came of it.
    """
    points = after.points
    moved = np.any(points != before.points, axis=1)
    where = points[moved]
    if before.frame is not None:
        where = before.frame.unflatten(with_depth(mesh.points[moved]), where)
    elif before.mirrored:
        where = where * np.array([1.0, 1.0, -1.0])
    result = mesh.points.copy()
    result[moved] = where[:, : result.shape[1]].astype(result.dtype)
    top = [id(block) for block in top_blocks(mesh)]
    worked = dict(zip(top, after.cell_sets, strict=True))
    blocks = [
        replace(block, cells=worked[id(block)].cells.astype(block.cells.dtype))
        if id(block) in worked
        else block
        for block in mesh.blocks
    ]
    return replace(mesh, points=result, blocks=blocks)
