"""What of a mesh can be measured, whether it can be optimized or not."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..cells import FAMILIES, SIMPLICES, family_of
from ..errors import BadMeshError
from ..mesh.cast import Simplices, cast
from ..mesh.model import Array, Block, Mesh, declared, main_type, top_blocks
from ..mesh.plane import plane_of, precision_of, with_depth
from ..mesh.second_order import by_corners, is_second_order
from ..mesh.sizes import contents


class Part(NamedTuple):
    """The cells of a mesh that can be measured, and what of it they leave out.

    Attributes
    ----------
    points : (np, 3) float64
        With z = 0 for cells that lie in a plane.
    cells : dict of str to (n, k) int64
        Corners of the cells of greatest dimension, by their families.
    has_signs : bool
        Whether cells that are turned the wrong way can be told: not so on a surface in space.
    simplices : Simplices or None
        The same, where they are all of them triangles or tetrahedra.
    notes : tuple of str
    """

    points: Array
    cells: dict[str, Array]
    has_signs: bool
    simplices: Simplices | None
    notes: tuple[str, ...]

    def is_turned(self, family: str) -> Array:
        """Which cells of a family have a negative volume or area, (n,) bool."""
        cells = self.cells[family]
        if not self.has_signs:
            return np.zeros(len(cells), dtype=bool)
        points = self.points if FAMILIES[family].dimension == 3 else self.points[:, :2]
        return contents(points, cells, family) < 0.0


def measurable(mesh: Mesh) -> Part:
    """The cells of a mesh, by their corners.

    Parameters
    ----------
    mesh : Mesh
        Its vertex numbers are in range.

    Returns
    -------
    Part
        Simplices as `cast` gives them, if it takes the mesh; triangles of a surface stay in
        space, with no `frame`. Cells of types that are unknown are left out.

    Raises
    ------
    BadMeshError
        There are no cells in it that can be measured.
    """
    cells, notes = _by_family(mesh)
    if len(cells) > 1 or not FAMILIES[next(iter(cells))].is_simplex:
        return _any_cells(mesh, cells, notes)
    mesh = _only_simplices(mesh)
    if mesh.dimension() == 2:
        triangles = declared(mesh, main_type(mesh))
        points = with_depth(mesh.points)
        if plane_of(points, triangles, precision_of(mesh.points)) is None:
            notes.append("each triangle of the surface is measured in its own plane")
            return _of(_surface(points, triangles), notes)
    return _of(cast(mesh), notes)


def _of(simplices: Simplices, notes: list[str]) -> Part:
    cells = {SIMPLICES[simplices.dimension]: simplices.cells}
    has_signs = simplices.dimension == 3 or simplices.frame is not None
    return Part(simplices.points, cells, has_signs, simplices, tuple(notes))


def _by_family(mesh: Mesh) -> tuple[dict[str, Array], list[str]]:
    """Corners of the cells of greatest dimension by their families, and what is to be said."""
    if mesh.dimension() < 2:
        what = {-1: "no cells", 0: "points only", 1: "lines only"}[mesh.dimension()]
        raise BadMeshError(f"{what}: there is nothing to measure")
    kept: dict[str, list[Array]] = {}
    left: dict[str, int] = {}
    curved = 0
    for block in top_blocks(mesh):
        family = family_of(block.type)
        if family is None:
            left[block.type] = left.get(block.type, 0) + len(block.cells)
            continue
        curved += len(block.cells) * (block.type not in FAMILIES)
        kept.setdefault(family.name, []).append(block.cells[:, : family.n_corners])
    notes = [f"{n:,} cells of type {cell_type} are left out" for cell_type, n in left.items()]
    if not kept:
        raise BadMeshError(f"no cells to measure: {', '.join(notes)}")
    if curved:
        notes.append(f"{curved:,} cells of higher order are measured by their corners")
    in_order = {name: kept[name] for name in FAMILIES if name in kept}
    return {name: np.ascontiguousarray(np.concatenate(k)) for name, k in in_order.items()}, notes


def _only_simplices(mesh: Mesh) -> Mesh:
    """A mesh whose measurable cells are triangles or tetrahedra, as a mesh of these alone."""
    if is_second_order(mesh):
        mesh = by_corners(mesh)
    wanted = FAMILIES[SIMPLICES[mesh.dimension()]]
    blocks = top_blocks(mesh)
    if all(block.type == wanted.name for block in blocks):
        return mesh
    kept = []
    for block in blocks:
        if family_of(block.type) is wanted:
            corners = np.ascontiguousarray(block.cells[:, : wanted.n_corners])
            kept.append(Block(wanted.name, corners, block.data))
    return Mesh(mesh.points, kept, regions=mesh.regions)


def _any_cells(mesh: Mesh, cells: dict[str, Array], notes: list[str]) -> Part:
    points = with_depth(mesh.points)
    has_signs = True
    if mesh.dimension() == 3:
        if sum(float(contents(points, c, family).sum()) for family, c in cells.items()) < 0.0:
            points = points * np.array([1.0, 1.0, -1.0])  # all are turned the other way
    else:
        halves = [c[:, half] for family, c in cells.items()
                  for half in FAMILIES[family].partitions[0]]  # fmt: skip
        frame = plane_of(points, np.concatenate(halves), precision_of(mesh.points))
        if frame is None:
            has_signs = False
            notes.append("each cell of the surface is measured in its own plane")
        else:
            # A quad that runs clockwise in the plane of x and y is negative (Figure 18.5).
            seen = frame.upright() if frame.normal_axis == 2 else frame
            points = seen.flatten(points)
    return Part(points, cells, has_signs, None, tuple(notes))


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
