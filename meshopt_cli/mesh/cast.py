"""The part of a mesh that is optimized (`Simplices`), taken out of it and put back.

`cast` takes from a mesh the arrays the kernels work on; `with_simplices` puts the worked arrays
back among all the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..errors import UnsupportedMeshError
from ..handles import OUTER
from . import adjacency
from .model import Array, Block, Mesh, declared, main_blocks, main_type
from .orientation import turned
from .periodic import renumbered
from .plane import Frame, plane_of, precision_of, with_depth
from .sizes import contents
from .tags import GEOMETRICAL, REQUIRED, STAY, flagged, regions_of, tags_of


@dataclass
class Simplices:
    """The triangles or tetrahedra of a mesh, ready to be worked on.

    Attributes
    ----------
    points : (np, 3) float64
        All points of the file, the unused ones too; in the plane of the mesh, with z = 0,
        when the cells are triangles.
    cells : (ne, d + 1) int64
        Cells of positive order.
    region : (ne,) int64
        Region of each cell: a distinct combination of its integer tags.
    fixed : (np,) bool
        Vertices that the file declares.
    facets : (nf, d) int64
        Facets that the file declares: triangles in 3-D, lines in the plane.
    edges : (n, 2) int64
        Edges that the file declares in 3-D.
    frame : Frame or None
        Where the plane of a planar mesh lies in space.
    single : bool
        Whether the file stores coordinates in single precision.
    turned : bool
        Whether all cells of the file had the other orientation.
    patch : (n,) int64 or None
        Of each of the facets `outer` after work on a boundary whose edges may be split: its patch,
        or -1 where it stayed as it was.
    """

    points: Array
    cells: Array
    region: Array
    fixed: Array
    facets: Array
    edges: Array
    frame: Frame | None
    single: bool
    turned: bool
    patch: Array | None = None

    @property
    def dimension(self) -> int:
        return self.cells.shape[1] - 1

    @cached_property
    def neighbours(self) -> Array:
        """What lies beyond each facet, (ne, d + 1): see `adjacency.neighbours`.

        Facets of the boundary, between two regions, or declared in the file have no neighbour.
        """
        return adjacency.neighbours(self.cells, self.region, len(self.points), self.facets)

    @property
    def facet_type(self) -> str:
        """Type of the cells that declare facets."""
        return SIMPLICES[self.dimension - 1]

    @cached_property
    def skin(self) -> Array:
        """Facets without a neighbour, (n, d), turned as their cells turn them."""
        return adjacency.boundary_facets(self.cells, self.neighbours)

    @cached_property
    def outer(self) -> Array:
        """Facets of the skin that bound one cell only, (n, d)."""
        return self.skin[self.neighbours[self.neighbours < 0] == OUTER]

    @cached_property
    def inner(self) -> Array:
        """Facets of the skin with cells on both sides, (n, d), each from either side."""
        return self.skin[self.neighbours[self.neighbours < 0] != OUTER]

    @cached_property
    def idle(self) -> Array:
        """Facets that the file declares and that are those of no cell, (n, d)."""
        if not len(self.facets):
            return self.facets
        return self.facets[adjacency.places_in(self.skin, self.facets, len(self.points)) < 0]

    def without_facets(self, rows: Array) -> Simplices:
        """The same, in which the file does not declare some facets, (n, d)."""
        others = adjacency.places_in(rows, self.facets, len(self.points)) < 0
        return self if others.all() else replace(self, facets=self.facets[others])

    def holding(self, vertices: Array) -> Simplices:
        """The same, in which some vertices are fixed, and the outer facets between them stay."""
        fixed = self.fixed.copy()
        fixed[vertices] = True
        edges = self.edges
        if self.dimension == 3:  # in the plane a facet stays where its ends do
            held = np.zeros(len(fixed), dtype=bool)
            held[vertices] = True
            facets = self.outer[held[self.outer].all(axis=1)]
            edges = np.concatenate([edges, adjacency.edges_of_triangles(facets)])
        return replace(self, fixed=fixed, edges=edges)


def cast(mesh: Mesh) -> Simplices:
    """Take from a mesh what the kernels work on.

    The mesh must be valid (`validity.check`) up to its orientation.

    Raises
    ------
    BadMeshError, UnsupportedMeshError
        See `main_type`; also for triangles that do not lie in a plane.
    """
    cell_type = main_type(mesh)
    blocks = main_blocks(mesh, cell_type)
    cells = np.ascontiguousarray(np.concatenate([b.cells for b in blocks]), dtype=np.int64)
    points = with_depth(mesh.points)
    used = adjacency.is_used(cells, len(points))
    frame = None
    is_turned = False
    dimension = FAMILIES[cell_type].dimension
    facets = declared(mesh, SIMPLICES[dimension - 1])
    if dimension == 2:
        edges = np.empty((0, 2), np.int64)
        frame = plane_of(points, cells, precision_of(mesh.points))
        if frame is None:
            raise UnsupportedMeshError(
                "the triangles do not lie in one plane: surfaces in space cannot be optimized "
                "here, but with remeshers of surfaces such as mmgs; meshopt check takes them"
            )
        points = frame.flatten(points)
    else:
        edges = declared(mesh, "line")
        # Some may be inverted: most of them tell the orientation.
        some = cells[:: max(1, len(cells) // 1000)]
        is_turned = bool(contents(points, some, cell_type).sum() < 0)
        if is_turned:
            cells = np.ascontiguousarray(turned(cells))
    fixed = np.zeros(len(points), dtype=bool)
    vertices = adjacency.distinct(declared(mesh, "vertex"))
    # A file that declares every vertex (as Mmg writes them) says nothing by it.
    if len(vertices) < np.count_nonzero(used):
        fixed[vertices] = True
    for name in STAY:
        if name in mesh.point_data:
            fixed |= flagged(mesh.point_data[name])
    required = [b.cells[flagged(b.data[REQUIRED])] for b in blocks if REQUIRED in b.data]
    if required:  # with their facets, cells stay too
        kept = np.concatenate(required)
        facets = np.concatenate([facets, adjacency.facets(kept)])
        fixed[kept] = True
    single = mesh.points.dtype == np.float32
    region = regions_of(blocks, mesh.regions)
    part = Simplices(points, cells, region, fixed, facets, edges, frame, single, is_turned)
    return _with_what_stays(mesh, part)


def _with_what_stays(mesh: Mesh, part: Simplices) -> Simplices:
    """What is worked on, in which all else of the mesh finds its vertices again.

    Facets that bound no cell have fixed vertices, and so have cells of other types, which come
    back as they were. Periodic sides stay, so that they go on to match.
    """
    part.fixed[part.idle] = True
    others = [b.cells.ravel() for b in mesh.blocks if b.type not in SIMPLICES]
    others += [link.pairs.ravel() for link in mesh.periodic]
    return part.holding(np.concatenate(others)) if others else part


def with_simplices(mesh: Mesh, worked: Simplices, origin: Array, before: Simplices) -> Mesh:
    """Put worked cells in the place of those of a mesh, and keep all the rest.

    Of the arrays on these cells and on points, only the tags that make regions are there:
    `transfer.carry` brings the others.

    Parameters
    ----------
    worked : Simplices
        Points and cells after the work; regions are numbered as in `before`.
    origin : (np',) int64
        The point of `mesh` that each point of `worked` was, -1 for a new one.
    before : Simplices
        What `cast` gave for `mesh`.
    """
    cell_type = main_type(mesh)
    new_number = np.full(len(mesh.points), -1, dtype=np.int64)
    is_new = origin < 0
    new_number[origin[~is_new]] = np.flatnonzero(~is_new)
    # A new point starts as one of the cells', for the height over a plane.
    points = mesh.points[np.where(is_new, before.cells[0, 0], origin)].copy()
    moved = is_new | np.any(worked.points != before.points[origin], axis=1)
    if worked.frame is not None:
        space = worked.frame.unflatten(with_depth(points[moved]), worked.points[moved])
    else:
        space = worked.points[moved]
    points[moved] = space[:, : points.shape[1]].astype(points.dtype)

    old_blocks = main_blocks(mesh, cell_type)
    first_of_region, home = _homes(old_blocks, before.region)
    place = home[worked.region]
    tags = tags_of(old_blocks, mesh.regions)
    blocks = []
    main = 0
    for block in mesh.blocks:
        if block.type != cell_type or not len(block.cells):
            cells = new_number[block.cells]
            kept = np.all(cells >= 0, axis=1)
            data = {n: a[kept] for n, a in block.data.items()}
            blocks.append(replace(block, cells=cells[kept], data=data, numbers=None))
            continue
        rows = np.flatnonzero(place == main)
        rows = rows[np.argsort(worked.region[rows], kind="stable")]
        if len(rows):
            first = first_of_region[worked.region[rows]]
            data = {name: values[first] for name, values in tags.items()}
            # A region that goes over several entities of Gmsh has the bounds of none.
            bounded = mesh.regions is None or GEOMETRICAL in mesh.regions
            entities = block.entities if bounded else None
            cells = worked.cells[rows]
            blocks.append(Block(cell_type, cells, data, entities))
        main += 1
    periodic = renumbered(mesh.periodic, new_number)
    changed = replace(mesh, points=points, blocks=blocks, point_data={})
    return replace(changed, periodic=periodic, numbers=None)


def _homes(blocks: list[Block], region: Array) -> tuple[Array, Array]:
    """The first cell of each region, and the number of the block that cell stands in."""
    _, first = np.unique(region, return_index=True)
    ends = np.cumsum([len(b.cells) for b in blocks])
    return first, np.searchsorted(ends, first, side="right")
