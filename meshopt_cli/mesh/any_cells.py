"""The cells of a mesh of any families, to be worked on, and put back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..errors import UnsupportedMeshError
from .adjacency import distinct
from .borders import of_mesh
from .facets import CellSet
from .model import Array, Block, Mesh, declared, top_blocks
from .plane import Frame, plane_of, precision_of, with_depth
from .sizes import contents
from .tags import REQUIRED, STAY, flagged, regions_of


@dataclass
class AnyCells:
    """The cells of greatest dimension of a mesh.

    Attributes
    ----------
    points : (np, 3) float64
        All points of the file; in the plane of the mesh, with z = 0, where d = 2.
    cell_sets : list of CellSet
        Cells by family, a set for each block of the file, numbered in its order. Numbers of cells
        that the work took away are missing.
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
    for name in STAY:
        if name in mesh.point_data:
            fixed |= flagged(mesh.point_data[name])
    for link in mesh.periodic:
        fixed[link.pairs] = True


def points_left(before: AnyCells, after: AnyCells) -> Array:
    """The points of a mesh that are left, ascending: all but those that lost their last cell."""
    lost = np.zeros(len(before.points), dtype=bool)
    for cells in before.cell_sets:
        lost[cells.cells] = True
    for cells in after.cell_sets:
        lost[cells.cells] = False
    return np.flatnonzero(~lost)


def with_cells(mesh: Mesh, before: AnyCells, after: AnyCells) -> Mesh:
    """A mesh as it was worked on: what did not change keeps every bit, and its place.

    Cells that went take their rows along, and points their arrays.

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
    sets = zip(top_blocks(mesh), before.cell_sets, after.cell_sets, strict=True)
    worked = {id(block): _worked(block, one, other) for block, one, other in sets}
    blocks = [worked.get(id(block), block) for block in mesh.blocks]
    left = points_left(before, after)
    changed = replace(mesh, points=result, blocks=blocks)
    return changed if len(left) == len(points) else _with_points(changed, left)


def _worked(block: Block, before: CellSet, after: CellSet) -> Block:
    """A block with the cells that are left of it."""
    cells = after.cells.astype(block.cells.dtype)
    if len(cells) == len(before.cells):
        return replace(block, cells=cells)
    kept = np.isin(before.numbers, after.numbers)
    data = {name: values[kept] for name, values in block.data.items()}
    return replace(block, cells=cells, data=data, numbers=None)


def _with_points(mesh: Mesh, left: Array) -> Mesh:
    """A mesh with some of its points only, and what needs no others."""
    new_number = np.full(len(mesh.points), -1)
    new_number[left] = np.arange(len(left))
    blocks = []
    for block in mesh.blocks:
        cells = new_number[block.cells]
        kept = np.all(cells >= 0, axis=1)
        data = {name: values[kept] for name, values in block.data.items()}
        blocks.append(replace(block, cells=cells[kept], data=data, numbers=None))
    return mesh.with_points(left, new_number, blocks)
