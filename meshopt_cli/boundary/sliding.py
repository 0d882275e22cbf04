"""Where the boundary may be worked on: in planes and along straight ridges (`--boundary slide`).

The outer boundary falls into patches: facets that lie in one plane and carry the same tags, out
to the ridges between them. A vertex inside a patch may move in its plane, one inside a straight
ridge along it; corners stay, and so do interfaces between regions. Within a patch other facets
may take the place of those that were there, so that the shape of the domain is kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..cells import SIMPLICES
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.model import Block, Mesh
from ..mesh.tags import REQUIRED, flagged, is_whole

Array = np.ndarray

FIXED, LINE, PLANE = range(3)  # the first column of a guide


@dataclass(frozen=True)
class Slide:
    """What may move on the boundary of a mesh.

    Attributes
    ----------
    guide : (np, 4) float64
        For each vertex FIXED, LINE or PLANE, and the unit direction or normal.
    ridges : (n, 2) int64
        Edges between patches, in 3-D.
    facets : (n, d) int64
        Facets of the outer boundary.
    patch : (n,) int64
        Patch of each of them.
    declared : (n,) int64
        For each, the number among the declared facets of the mesh that it is, or -1.
    tolerance : float
    """

    guide: Array
    ridges: Array
    facets: Array
    patch: Array
    declared: Array
    tolerance: float


def facet_type(simplices: Simplices) -> str:
    """Type of the cells that declare facets."""
    return SIMPLICES[simplices.dimension - 1]


def labels(blocks: list[Block]) -> Array:
    """One number a row over some blocks, equal for rows with the same integer arrays, (n,)."""
    names = sorted({n for b in blocks for n, a in b.data.items() if is_whole(a)})
    n_rows = sum(len(b.cells) for b in blocks)
    columns = [np.zeros(n_rows, np.int64)]
    for name in names:
        parts = [b.data.get(name, np.zeros(len(b.cells), np.int64)) for b in blocks]
        columns.append(np.concatenate(parts).astype(np.int64))
    _, label, _ = adjacency.distinct_rows(np.stack(columns, axis=1))
    return label


def find(mesh: Mesh, source: Simplices, tolerance: float) -> Slide:
    """Find the patches of the boundary, and where each vertex may move.

    Parameters
    ----------
    source : Simplices
        What `cast` gave for the mesh.
    """
    n_points = len(source.points)
    keys = adjacency.row_ids(source.skin, n_points)
    _, inverse, count = np.unique(keys, return_inverse=True, return_counts=True)
    outer = count[inverse] == 1
    facets = source.skin[outer]
    declared, label, required = _declared(mesh, source, facets)
    pinned = source.fixed.copy()
    pinned[source.skin[~outer]] = True
    pinned[facets[required]] = True
    if source.dimension == 2:
        guide = _guides_of_chains(source.points, facets, label, pinned, tolerance)
        nothing = np.empty((0, 2), np.int64)
        return Slide(guide, nothing, facets, np.arange(len(facets)), declared, tolerance)
    normals = _normals(source.points, facets)
    ridges, one, other = _ridges(facets, normals, label, source.edges, n_points, tolerance)
    patch = adjacency.first_of(len(facets), one, other)
    pinned[_loose_ends(source.edges, facets, n_points)] = True
    guide = _guides(source.points, facets, normals, patch, ridges, pinned, tolerance)
    return Slide(guide, ridges, facets, patch, declared, tolerance)


def _declared(mesh: Mesh, source: Simplices, facets: Array) -> tuple[Array, Array, Array]:
    """For each facet: which declared one it is, a label for its tags, whether it is required."""
    kind = facet_type(source)
    blocks = [b for b in mesh.blocks if b.type == kind]
    found = np.full(len(facets), -1)
    label = np.full(len(facets), -1)
    required = np.zeros(len(facets), dtype=bool)
    if not blocks or not sum(len(b.cells) for b in blocks):
        return found, label, required
    rows = np.concatenate([b.cells for b in blocks])
    n_points = len(source.points)
    ids = adjacency.row_ids(np.concatenate([rows, facets]), n_points)
    order = np.argsort(ids[: len(rows)], kind="stable")
    place = np.searchsorted(ids[: len(rows)], ids[len(rows) :], sorter=order)
    nearest = order[np.minimum(place, len(rows) - 1)]
    same = ids[nearest] == ids[len(rows) :]
    found[same] = nearest[same]
    label[same] = labels(blocks)[nearest[same]]
    flags = [flagged(b.data.get(REQUIRED, np.zeros(len(b.cells)))) for b in blocks]
    required[same] = np.concatenate(flags)[nearest[same]]
    return found, label, required


def _normals(points: Array, facets: Array) -> Array:
    a, b, c = (points[facets[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _ridges(
    facets: Array, normals: Array, label: Array, declared: Array, n_points: int, tolerance: float
) -> tuple[Array, Array, Array]:
    """Edges where the boundary bends or its tags change, and the pairs of facets at all others."""
    edges = np.sort(adjacency.edges_of_triangles(facets), axis=1)
    owner = np.repeat(np.arange(len(facets)), 3)
    key = adjacency.row_keys(edges, n_points)
    order = np.argsort(key, kind="stable")
    key, owner, edges = key[order], owner[order], edges[order]
    start = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    count = np.diff(start, append=len(key))
    pair = start[count == 2]
    one, other = owner[pair], owner[pair + 1]
    bend = np.linalg.norm(normals[one] - normals[other], axis=1)
    smooth = (bend <= tolerance) & (label[one] == label[other])
    smooth &= ~np.isin(key[pair], adjacency.row_keys(declared, n_points))
    ridges = np.concatenate([edges[start[count != 2]], edges[pair[~smooth]]])
    return ridges, one[smooth], other[smooth]


def _loose_ends(declared: Array, facets: Array, n_points: int) -> Array:
    """Vertices of declared edges that do not lie on the boundary."""
    on_boundary = adjacency.row_keys(adjacency.edges_of_triangles(facets), n_points)
    loose = ~np.isin(adjacency.row_keys(declared, n_points), on_boundary)
    return declared[loose].ravel()


def _guides(
    points: Array,
    facets: Array,
    normals: Array,
    patch: Array,
    ridges: Array,
    pinned: Array,
    tolerance: float,
) -> Array:
    n_points = len(points)
    guide = np.zeros((n_points, 4))
    n_ridges = np.bincount(ridges.ravel(), minlength=n_points)
    # A vertex with all its facets in one patch, and no ridge.
    low = np.full(n_points, len(facets))
    high = np.full(n_points, -1)
    np.minimum.at(low, facets.ravel(), np.repeat(patch, 3))
    np.maximum.at(high, facets.ravel(), np.repeat(patch, 3))
    inside = (low == high) & (n_ridges == 0) & ~pinned
    guide[facets.ravel(), 1:] = np.repeat(normals, 3, axis=0)
    guide[inside, 0] = PLANE
    _set_lines(guide, points, ridges, ~pinned & (n_ridges == 2), tolerance)
    guide[guide[:, 0] == FIXED] = 0.0
    return guide


def _guides_of_chains(
    points: Array, facets: Array, label: Array, pinned: Array, tolerance: float
) -> Array:
    """Guides in the plane: a vertex between two edges in line that carry the same tags."""
    n_points = len(points)
    guide = np.zeros((n_points, 4))
    n_edges = np.bincount(facets.ravel(), minlength=n_points)
    low = np.full(n_points, len(facets) + 1)
    high = np.full(n_points, -2)
    np.minimum.at(low, facets.ravel(), np.repeat(label, 2))
    np.maximum.at(high, facets.ravel(), np.repeat(label, 2))
    free = ~pinned & (n_edges == 2) & (low == high)
    _set_lines(guide, points, facets, free, tolerance)
    guide[guide[:, 0] == FIXED] = 0.0
    return guide


def _set_lines(guide: Array, points: Array, edges: Array, free: Array, tolerance: float) -> None:
    """Set the guide of the free vertices whose two edges go in opposite directions."""
    ends = np.concatenate([edges, edges[:, ::-1]])
    along = points[ends[:, 1]] - points[ends[:, 0]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    total = np.zeros((len(points), 3))
    np.add.at(total, ends[:, 0], along)
    straight = free & (np.linalg.norm(total, axis=1) <= tolerance)
    guide[ends[:, 0], 1:] = np.where(straight[ends[:, 0], None], along, guide[ends[:, 0], 1:])
    guide[straight, 0] = LINE


def redeclared(
    mesh: Mesh, result: Mesh, slide: Slide, worked: Simplices, origin: Array
) -> tuple[Mesh, Array]:
    """Declare the facets of a worked boundary as those that they took the place of were.

    Parameters
    ----------
    mesh, result : Mesh
        Before the work, and after it as `mesh.with_simplices` gives it.
    origin : (np',) int64
        The point of `mesh` that each point of the result was, -1 for a new one.

    Returns
    -------
    mesh : Mesh
    patch : (n,) int64
        Patch of each outer facet of `worked`, in the order of its skin.
    """
    n_points = len(worked.points)
    keys = adjacency.row_ids(worked.skin, n_points)
    _, inverse, count = np.unique(keys, return_inverse=True, return_counts=True)
    facets = worked.skin[count[inverse] == 1]
    old = np.sort(slide.facets, axis=1)
    new = np.sort(origin[facets], axis=1)
    ids = adjacency.row_ids(np.concatenate([old, np.maximum(new, 0)]), len(mesh.points))
    order = np.argsort(ids[: len(old)], kind="stable")
    place = np.minimum(
        np.searchsorted(ids[: len(old)], ids[len(old) :], sorter=order), len(old) - 1
    )
    match = order[place]
    kept = (ids[match] == ids[len(old) :]) & (new >= 0).all(axis=1)
    patch = np.where(kept, slide.patch[match], -1)
    for row in np.flatnonzero(~kept).tolist():
        patch[row] = _patch_of(slide, origin[facets[row]])
    gone = np.setdiff1d(slide.declared[slide.declared >= 0], slide.declared[match[kept]])
    template = np.full(len(slide.facets), -1)
    has = np.flatnonzero(slide.declared >= 0)
    template[slide.patch[has]] = slide.declared[has]
    wanted = np.where(kept, -1, template[np.maximum(patch, 0)])
    return _with_facets(mesh, result, facets, wanted, gone, origin, worked), patch


def _patch_of(slide: Slide, vertices: Array) -> int:
    """The patch that all these points of the input have facets in."""
    common: set[int] | None = None
    for vertex in vertices.tolist():
        here = set(slide.patch[(slide.facets == vertex).any(axis=1)].tolist())
        common = here if common is None else common & here
    return min(common) if common else -1


def _with_facets(
    mesh: Mesh,
    result: Mesh,
    facets: Array,
    wanted: Array,
    gone: Array,
    origin: Array,
    worked: Simplices,
) -> Mesh:
    """Take the declared facets that are gone out of a mesh, and put new ones in their blocks."""
    kind = facet_type(worked)
    number = np.full(len(mesh.points), -1)
    number[origin[origin >= 0]] = np.flatnonzero(origin >= 0)
    blocks = []
    first = 0
    declaring = iter(block for block in mesh.blocks if block.type == kind)
    for block in result.blocks:
        if block.type != kind:
            blocks.append(block)
            continue
        old = next(declaring)
        rows = np.arange(first, first + len(old.cells))
        first += len(old.cells)
        # `result` lacks the rows whose vertices are gone.
        there = (number[old.cells] >= 0).all(axis=1)
        stays = ~np.isin(rows[there], gone)
        new = np.flatnonzero((wanted >= rows[:1].min(initial=0)) & np.isin(wanted, rows))
        source = wanted[new] - (rows[0] if len(rows) else 0)
        cells = np.concatenate([block.cells[stays], facets[new]])
        data = {
            name: np.concatenate([values[stays], old.data[name][source]])
            for name, values in block.data.items()
        }
        blocks.append(replace(block, cells=cells, data=data))
    return replace(result, blocks=blocks)
