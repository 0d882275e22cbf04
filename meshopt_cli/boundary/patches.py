"""Where a boundary may be worked on: in planes and along straight ridges.

The outer boundary falls into patches: facets that lie in one plane and carry the same tags, out
to the ridges between them. A vertex inside a patch may move in its plane, one inside a straight
ridge along it; corners stay, and so do interfaces between regions. Within a patch other facets
may take the place of those that were there, so that the shape of the domain is kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kernels.guide import LINE, PLANE, STAYS
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.model import Block, Mesh
from ..mesh.sizes import norms
from ..mesh.tags import REQUIRED, flagged, is_whole

Array = np.ndarray


@dataclass(frozen=True)
class Patches:
    """The patches of a boundary, and where its vertices may move.

    Attributes
    ----------
    points : (np, 3) float64
        As they were before the work.
    guide : (np, 4) float64
        For each vertex STAYS, LINE or PLANE, and the unit direction or normal.
    ridges : (n, 2) int64
        Edges between patches, in 3-D.
    facets : (n, d) int64
        Facets of the outer boundary.
    patch : (n,) int64
        Patch of each of them.
    declared : (n,) int64
        For each, the number among the declared facets of the mesh that it is, or -1.
    tolerance : float
    splits : (n,) bool or None
        Facets whose edges may be split; None where the boundary keeps its vertices but for those
        that vanish within planes.
    whole : (m, 2) int64 or None
        Then, edges that stay as they are, in 3-D.
    """

    points: Array
    guide: Array
    ridges: Array
    facets: Array
    patch: Array
    declared: Array
    tolerance: float
    splits: Array | None = None
    whole: Array | None = None


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


def patches_of(mesh: Mesh, source: Simplices, tolerance: float) -> Patches:
    """Find the patches of the boundary, and where each vertex may move.

    Parameters
    ----------
    source : Simplices
        What `cast` gave for the mesh.
    tolerance : float
        Sine of the angle within which facets lie in one plane, and edges in one line.
    """
    n_points = len(source.points)
    facets = source.outer
    declared, label, required = declared_among(mesh, source.facet_type, facets)
    pinned = source.fixed.copy()
    pinned[source.inner] = True
    pinned[facets[required]] = True
    if source.dimension == 2:
        guide = _guides_of_chains(source.points, facets, label, pinned, tolerance)
        nothing = np.empty((0, 2), np.int64)
        number = np.arange(len(facets))
        return Patches(source.points, guide, nothing, facets, number, declared, tolerance)
    normals = normals_of(source.points, facets)
    alone = np.arange(len(facets))
    label = np.where(required, len(facets) + alone, label)  # no other facet takes its place
    ridges, one, other = _ridges(facets, normals, label, source.edges, n_points, tolerance)
    patch = adjacency.first_of(len(facets), one, other)
    pinned[_loose_ends(source.edges, facets, n_points)] = True
    _, label, required = declared_among(mesh, "line", ridges)
    pinned[ridges[required]] = True
    pinned |= ~_are_alike(ridges, label, n_points)
    guide = _guides(source.points, facets, normals, patch, ridges, pinned, tolerance)
    return Patches(source.points, guide, ridges, facets, patch, declared, tolerance)


def declared_among(mesh: Mesh, kind: str, rows: Array) -> tuple[Array, Array, Array]:
    """For each facet or edge: which declared one it is, a label for its tags, whether it must stay.

    It must where the file says so, and where the file lists it several times: whatever took its
    place would have to be as many.
    """
    blocks = [b for b in mesh.blocks if b.type == kind]
    found = np.full(len(rows), -1)
    label = np.full(len(rows), -1)
    must_stay = np.zeros(len(rows), dtype=bool)
    if not sum(len(b.cells) for b in blocks):
        return found, label, must_stay
    known = np.concatenate([b.cells for b in blocks])
    found = adjacency.places_in(known, rows, len(mesh.points))
    there = found >= 0
    label[there] = labels(blocks)[found[there]]
    required = [flagged(b.data.get(REQUIRED, np.zeros(len(b.cells)))) for b in blocks]
    _, number, count = adjacency.distinct_rows(np.sort(known, axis=1))
    must_stay[there] = (np.concatenate(required) | (count[number] > 1))[found[there]]
    return found, label, must_stay


def _are_alike(rows: Array, label: Array, n_points: int) -> Array:
    """Whether all facets or edges at each vertex have the same label, (np,) bool."""
    width = rows.shape[1]
    low = np.full(n_points, np.iinfo(np.int64).max)
    high = np.full(n_points, np.iinfo(np.int64).min)
    np.minimum.at(low, rows.ravel(), np.repeat(label, width))
    np.maximum.at(high, rows.ravel(), np.repeat(label, width))
    return low >= high


def normals_of(points: Array, facets: Array) -> Array:
    """Unit normals of triangles, or of edges in the plane z = 0, (n, 3)."""
    if facets.shape[1] == 2:
        along = points[facets[:, 1]] - points[facets[:, 0]]
        return unit(np.stack([along[:, 1], -along[:, 0], along[:, 2]], axis=1))
    a, b, c = (points[facets[:, k]] for k in range(3))
    return unit(np.cross(b - a, c - a))


def unit(vectors: Array) -> Array:
    """Vectors by their lengths, (n, 3); those without a length stay 0, and have no direction."""
    length = norms(vectors)[:, None]
    return vectors / np.where(length > 0.0, length, 1.0)


def _ridges(
    facets: Array, normals: Array, label: Array, declared: Array, n_points: int, tolerance: float
) -> tuple[Array, Array, Array]:
    """Edges where the boundary bends or its tags change, and the pairs of facets at all others."""
    edges, one, other, odd = sides_of_edges(facets, n_points)
    bend = np.linalg.norm(normals[one] - normals[other], axis=1)
    smooth = (bend <= tolerance) & (label[one] == label[other])
    keys = adjacency.row_keys(edges, n_points)
    smooth &= ~np.isin(keys, adjacency.row_keys(declared, n_points))
    return np.concatenate([odd, edges[~smooth]]), one[smooth], other[smooth]


def sides_of_edges(facets: Array, n_points: int) -> tuple[Array, Array, Array, Array]:
    """The edges of triangles: those between two, both of them, and the edges of another number.

    Returns
    -------
    edges : (n, 2) int64
        Ascending, and so are both their ends.
    one, other : (n,) int64
        The triangles at each.
    odd : (m, 2) int64
    """
    edges = np.sort(adjacency.edges_of_triangles(facets), axis=1)
    owner = np.repeat(np.arange(len(facets)), 3)
    key = adjacency.row_keys(edges, n_points)
    order = np.argsort(key, kind="stable")
    key, owner, edges = key[order], owner[order], edges[order]
    start = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    count = np.diff(start, append=len(key))
    pair = start[count == 2]
    return edges[pair], owner[pair], owner[pair + 1], edges[start[count != 2]]


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
    on_boundary = np.zeros(n_points, dtype=bool)
    on_boundary[facets] = True
    inside = on_boundary & _are_alike(facets, patch, n_points) & (n_ridges == 0) & ~pinned
    guide[facets.ravel(), 1:] = np.repeat(normals, 3, axis=0)
    guide[inside, 0] = PLANE
    _set_lines(guide, points, ridges, ~pinned & (n_ridges == 2), tolerance)
    guide[guide[:, 0] == STAYS] = 0.0
    return guide


def _guides_of_chains(
    points: Array, facets: Array, label: Array, pinned: Array, tolerance: float
) -> Array:
    """Guides in the plane: a vertex between two edges in line that carry the same tags."""
    n_points = len(points)
    guide = np.zeros((n_points, 4))
    n_edges = np.bincount(facets.ravel(), minlength=n_points)
    free = ~pinned & (n_edges == 2) & _are_alike(facets, label, n_points)
    _set_lines(guide, points, facets, free, tolerance)
    guide[guide[:, 0] == STAYS] = 0.0
    return guide


def _set_lines(guide: Array, points: Array, edges: Array, free: Array, tolerance: float) -> None:
    """Set the guide of the free vertices whose two edges go in opposite directions."""
    ends = np.concatenate([edges, edges[:, ::-1]])
    along = unit(points[ends[:, 1]] - points[ends[:, 0]])
    total = np.zeros((len(points), 3))
    np.add.at(total, ends[:, 0], along)
    free[ends[~along.any(axis=1)]] = False  # at an edge without a direction
    straight = free & (np.linalg.norm(total, axis=1) <= tolerance)
    guide[ends[:, 0], 1:] = np.where(straight[ends[:, 0], None], along, guide[ends[:, 0], 1:])
    guide[straight, 0] = LINE
