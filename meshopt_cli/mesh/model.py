"""What a file holds (`Mesh`) and the part of it that is optimized (`Simplices`).

A `Mesh` keeps everything a file said, in the file's own order and precision.
`cast` takes from it the arrays the kernels work on; `with_simplices` puts the
worked arrays back among all the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..errors import BadMeshError, ConfigError, UnsupportedMeshError
from . import adjacency
from .plane import Frame, flatness, plane_of, with_depth

Array = np.ndarray

# Cell types by what they are to this tool.
LOWER = {"vertex": 0, "line": 1}
SIMPLICES = {"triangle": 2, "tetra": 3}
DIMENSION = {
    **LOWER,
    **SIMPLICES,
    "quad": 2,
    "pyramid": 3,
    "wedge": 3,
    "hexahedron": 3,
}

# Integer arrays that tell cells of one region from those of another, whatever their values.
PHYSICAL, GEOMETRICAL, REF = TAG_NAMES = ("gmsh:physical", "gmsh:geometrical", "medit:ref")
# Dimension and tag of the entity that Gmsh has a node on.
DIM_TAGS = "gmsh:dim_tags"
# Medit's flags of vertices and of cells: what is required must stay.
CORNER, REQUIRED, RIDGE = FLAGS = ("medit:corner", "medit:required", "medit:ridge")
# Vectors at some of the vertices.
NORMAL, TANGENT = "medit:normal", "medit:tangent"
# Any other integer array does so when it has few values: otherwise it numbers the cells.
MAX_LABELS = 64


@dataclass
class Block:
    """Cells of one type that stand together in a file.

    Attributes
    ----------
    type : str
        Name of the cell type as meshio spells it: "triangle", "tetra", ...
    cells : (n, k) int64
        Vertices of each cell, counted from 0. Not checked against the points.
    data : dict of str to (n, ...) array
        Arrays with one row a cell, by the name the file gives them.
    entities : (m,) int array, optional
        Tags of the entities that bound this one (Gmsh 4.1).
    """

    type: str
    cells: Array
    data: dict[str, Array] = field(default_factory=dict)
    entities: Array | None = None


@dataclass
class Mesh:
    """All that a mesh file holds.

    Attributes
    ----------
    points : (np, 2) or (np, 3) float32 or float64
    blocks : list of Block
    point_data : dict of str to (np, ...) array
    names : dict of str to (tag, dimension)
        Physical groups by name.
    more_groups : dict of (dimension, tag) to tuple of int
        The physical groups that an entity of Gmsh is in besides that of its cells.
    regions : tuple of str, optional
        Arrays that make regions, instead of all that `is_tag` takes for tags.
    """

    points: Array
    blocks: list[Block]
    point_data: dict[str, Array] = field(default_factory=dict)
    names: dict[str, tuple[int, int]] = field(default_factory=dict)
    more_groups: dict[tuple[int, int], tuple[int, ...]] = field(default_factory=dict)
    regions: tuple[str, ...] | None = None

    def dimension(self) -> int:
        """Greatest dimension of the cells, second-order ones included; -1 without cells."""
        return max((dimension_of(b.type) for b in self.blocks if len(b.cells)), default=-1)


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

    @property
    def dimension(self) -> int:
        return self.cells.shape[1] - 1

    @cached_property
    def neighbours(self) -> Array:
        """What lies beyond each facet, (ne, d + 1): see `adjacency.neighbours`.

        Facets of the boundary, between two regions, or declared in the file have no neighbour.
        """
        return adjacency.neighbours(self.cells, self.region, len(self.points), self.facets)

    @cached_property
    def skin(self) -> Array:
        """Facets without a neighbour, (n, d), turned as their cells turn them."""
        return adjacency.boundary_facets(self.cells, self.neighbours)


def dimension_of(cell_type: str) -> int:
    """Dimension of a cell type of any order, from its name."""
    stem = cell_type.rstrip("0123456789")
    return DIMENSION.get(stem, 3)


def main_type(mesh: Mesh) -> str:
    """The type of the cells to optimize, "triangle" or "tetra".

    Raises
    ------
    BadMeshError
        The mesh has no cells of dimension 2 or 3.
    UnsupportedMeshError
        It has cells that are neither, of the greatest dimension or besides it.
    """
    dimension = mesh.dimension()
    if dimension < 2:
        what = {-1: "no cells", 0: "points only", 1: "lines only"}[dimension]
        raise BadMeshError(f"{what}: a mesh of triangles or tetrahedra is needed")
    wanted = "triangle" if dimension == 2 else "tetra"
    others = {b.type for b in mesh.blocks if len(b.cells)} - {wanted, "triangle", *LOWER}
    if others:
        curved = all(cell_type not in DIMENSION for cell_type in others)
        remedy = "save it with cells of first order" if curved else "cut them into simplices first"
        raise UnsupportedMeshError(
            f"cells of type {', '.join(sorted(others))} cannot be optimized, only linear triangles "
            f"in a plane and linear tetrahedra can: {remedy}; meshopt check takes them as they are"
        )
    return wanted


def is_tag(name: str, arrays: list[Array]) -> bool:
    """Whether an array over the cells tells regions apart."""
    if name in FLAGS or any(a.dtype.kind not in "iu" or a.ndim != 1 for a in arrays):
        return False
    return name in TAG_NAMES or len(np.unique(np.concatenate(arrays))) <= MAX_LABELS


def tags_of(blocks: list[Block], regions: tuple[str, ...] | None = None) -> dict[str, Array]:
    """The tags that make regions of the cells of some blocks, each (ne,), by name.

    Parameters
    ----------
    regions : tuple of str, optional
        Only these arrays; see `Mesh.regions`.
    """
    names = [n for n in blocks[0].data if all(n in b.data for b in blocks)]
    arrays = {n: [b.data[n] for b in blocks] for n in names}
    if regions is not None:
        return {n: np.concatenate(arrays[n]) for n in names if n in regions}
    return {n: np.concatenate(a) for n, a in arrays.items() if is_tag(n, a)}


def with_regions(mesh: Mesh, names: tuple[str, ...]) -> Mesh:
    """The mesh, in which these arrays make regions, and no others.

    Raises
    ------
    ConfigError
        A name is that of no array of whole numbers, one a cell, on all cells to optimize.
    """
    blocks = main_blocks(mesh, main_type(mesh))
    common = [n for n in blocks[0].data if all(n in b.data for b in blocks)]
    arrays = {n: [b.data[n] for b in blocks] for n in common}
    fit = [n for n in common if all(a.dtype.kind in "iu" and a.ndim == 1 for a in arrays[n])]
    for name in names:
        if name not in fit:
            known = f"choose from {', '.join(fit)}" if fit else "the mesh has none"
            raise ConfigError(f"no array {name!r} of whole numbers on all cells: {known}")
    return replace(mesh, regions=names)


def regions_of(blocks: list[Block], regions: tuple[str, ...] | None = None) -> Array:
    """Region of each cell, (ne,) int64: a combination of tags, numbered from 0 in order.

    Blocks whose cells have the same tags make one region: a file may cut one region into
    several blocks.
    """
    tags = tags_of(blocks, regions)
    n_cells = sum(len(b.cells) for b in blocks)
    if not tags:
        return np.zeros(n_cells, dtype=np.int64)
    rows = np.stack([tags[n].astype(np.int64) for n in tags], axis=1)
    _, region, _ = adjacency.distinct_rows(rows)
    return region


def main_blocks(mesh: Mesh, cell_type: str) -> list[Block]:
    return [b for b in mesh.blocks if b.type == cell_type and len(b.cells)]


def declared(mesh: Mesh, cell_type: str) -> Array:
    """Cells of one type over all blocks, (n, k) int64."""
    width = {"vertex": 1, "line": 2, "triangle": 3}[cell_type]
    found = [b.cells for b in mesh.blocks if b.type == cell_type]
    return np.concatenate(found) if found else np.empty((0, width), np.int64)


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
    turned = False
    if cell_type == "triangle":
        tolerance = flatness(points[used], mesh.points.dtype)
        frame = plane_of(points, cells, tolerance)
        if frame is None:
            raise UnsupportedMeshError(
                "the triangles do not lie in one plane: surfaces in space cannot be optimized "
                "here, but with remeshers of surfaces such as mmgs; meshopt check takes them"
            )
        points = frame.flatten(points)
        facets, edges = declared(mesh, "line"), np.empty((0, 2), np.int64)
    else:
        facets, edges = declared(mesh, "triangle"), declared(mesh, "line")
        # Some may be inverted: most of them tell the orientation.
        corners = points[cells[:: max(1, len(cells) // 1000)]]
        if np.sum(np.linalg.det(corners[:, 1:] - corners[:, :1])) < 0:
            cells = np.ascontiguousarray(cells[:, [0, 1, 3, 2]])
            turned = True
    fixed = np.zeros(len(points), dtype=bool)
    vertices = np.unique(declared(mesh, "vertex"))
    # A file that declares every vertex (as Mmg writes them) says nothing by it.
    if len(vertices) < np.count_nonzero(used):
        fixed[vertices] = True
    for name in (CORNER, REQUIRED):
        if name in mesh.point_data:
            fixed |= flagged(mesh.point_data[name])
    required = [b.cells[flagged(b.data[REQUIRED])] for b in blocks if REQUIRED in b.data]
    if required:  # with their facets, cells stay too
        kept = np.concatenate(required)
        facets = np.concatenate([facets, adjacency.facets(kept)])
        fixed[kept] = True
    single = mesh.points.dtype == np.float32
    region = regions_of(blocks, mesh.regions)
    return Simplices(points, cells, region, fixed, facets, edges, frame, single, turned)


def flagged(values: Array) -> Array:
    """Where an array, (n,) of numbers, is set."""
    return np.nan_to_num(values) != 0


def with_positive_tets(mesh: Mesh) -> tuple[Mesh, int]:
    """Turn the tetrahedra of negative volume; also returns how many they were.

    This mends a mesh whose cells were written in either orientation. In a tangle it makes
    neighbours overlap, which `validity.check` sees (M207).
    """
    points = with_depth(mesh.points)
    n_turned = 0
    blocks = []
    for block in mesh.blocks:
        if block.type == "tetra" and len(block.cells):
            edges = points[block.cells[:, 1:]] - points[block.cells[:, :1]]
            negative = np.linalg.det(edges) < 0
            cells = np.where(negative[:, None], block.cells[:, [0, 1, 3, 2]], block.cells)
            n_turned += int(np.count_nonzero(negative))
            blocks.append(replace(block, cells=cells))
        else:
            blocks.append(block)
    return replace(mesh, blocks=blocks), n_turned


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
            blocks.append(replace(block, cells=cells[kept], data=data))
            continue
        rows = np.flatnonzero(place == main)
        rows = rows[np.argsort(worked.region[rows], kind="stable")]
        if len(rows):
            first = first_of_region[worked.region[rows]]
            data = {name: values[first] for name, values in tags.items()}
            # A region that goes over several entities of Gmsh has the bounds of none.
            bounded = mesh.regions is None or GEOMETRICAL in mesh.regions
            entities = block.entities if bounded else None
            blocks.append(replace(block, cells=worked.cells[rows], data=data, entities=entities))
        main += 1
    return replace(mesh, points=points, blocks=blocks, point_data={})


def _homes(blocks: list[Block], region: Array) -> tuple[Array, Array]:
    """The first cell of each region, and the number of the block that cell stands in."""
    _, first = np.unique(region, return_index=True)
    ends = np.cumsum([len(b.cells) for b in blocks])
    return first, np.searchsorted(ends, first, side="right")
