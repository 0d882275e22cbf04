"""Volumes, planes and coincident points, for the rules of `check`.

All of it works on whole arrays and allows for the rounding of the coordinates: `noise`
is the error of a coordinate, in the unit of the points.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

Array = np.ndarray
Pairs = tuple[Array, Array]

FLAT = 1e-10  # least height of a cell, as a fraction of its longest edge
CHUNK = 1 << 16  # cells at a time: what fits in the cache of a processor

# For each vertex of a cell, itself and its neighbours along the edges: a tet that is positive
# where the cell is valid. The apex of a pyramid has four edges, and is left out.
CORNERS = {
    "tetra": np.array([[0, 1, 2, 3]]),
    "pyramid": np.array([[0, 1, 3, 4], [1, 2, 0, 4], [2, 3, 1, 4], [3, 0, 2, 4]]),
    "wedge": np.array(
        [[0, 1, 2, 3], [1, 2, 0, 4], [2, 0, 1, 5], [3, 5, 4, 0], [4, 3, 5, 1], [5, 4, 3, 2]]
    ),
    "hexahedron": np.array(
        [
            *([0, 1, 3, 4], [1, 2, 0, 5], [2, 3, 1, 6], [3, 0, 2, 7]),
            *([4, 7, 5, 0], [5, 4, 6, 1], [6, 5, 7, 2], [7, 6, 4, 3]),
        ]
    ),
}

# Facets of each type of cell by their number of vertices, turned outwards.
FACETS = {
    "triangle": {2: np.array([[1, 2], [2, 0], [0, 1]])},
    "quad": {2: np.array([[0, 1], [1, 2], [2, 3], [3, 0]])},
    "tetra": {3: np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])},
    "pyramid": {
        3: np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]),
        4: np.array([[0, 3, 2, 1]]),
    },
    "wedge": {
        3: np.array([[0, 2, 1], [3, 4, 5]]),
        4: np.array([[0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]),
    },
    "hexahedron": {
        4: np.array(
            [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
        )
    },
}


def chunks(n: int) -> Iterator[slice]:
    """Slices that cover `n` rows."""
    return (slice(first, first + CHUNK) for first in range(0, n, CHUNK))


def norms(vectors: Array) -> Array:
    """Lengths of vectors, over the last axis."""
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))


def corner_volumes(points: Array, noise: Array, cells: Array, family: str) -> Pairs:
    """Volumes at the corners of 3-D cells, six times that of the tet of each corner.

    Parameters
    ----------
    points : (np, 3) float64
    noise : (np,) float64
    cells : (n, k) int64
    family : str
        A key of `CORNERS`.

    Returns
    -------
    volume : (n, c) float64
    flat : (n, c) bool
        The least height of the tet is nothing but rounding, or `FLAT` of its longest edge.
    """
    table = CORNERS[family]
    volume = np.empty((len(cells), len(table)))
    flat = np.zeros(volume.shape, dtype=bool)
    worst = noise.max(initial=0.0)
    for corner, local in enumerate(table):
        for rows in chunks(len(cells)):
            tets = np.take(cells[rows], local, axis=1)
            volume[rows, corner], size = _tet_volumes(points, tets)
            # Twice the longest edge at one vertex bounds all edges: few tets stay in doubt.
            bound = 8 * size**2 * (FLAT * size + worst)
            doubt = np.flatnonzero(np.abs(volume[rows, corner]) <= bound)
            flat[rows.start + doubt, corner] = _are_flat(points, noise, tets[doubt])
    return volume, flat


def _tet_volumes(points: Array, tets: Array) -> Pairs:
    """Six times the volume of each tet, and its longest edge at the first vertex."""
    origin = points[tets[:, 0]]
    a, b, c = (points[tets[:, k]] - origin for k in (1, 2, 3))
    volume = (
        a[:, 0] * (b[:, 1] * c[:, 2] - b[:, 2] * c[:, 1])
        + a[:, 1] * (b[:, 2] * c[:, 0] - b[:, 0] * c[:, 2])
        + a[:, 2] * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    )
    return volume, np.maximum(np.maximum(norms(a), norms(b)), norms(c))


def _are_flat(points: Array, noise: Array, tets: Array) -> Array:
    """Whether the least height of each tet is none."""
    volume, _ = _tet_volumes(points, tets)
    corners = points[tets]
    edges = [corners[:, j] - corners[:, i] for i in range(4) for j in range(i + 1, 4)]
    longest = np.max([norms(edge) for edge in edges], axis=0)
    faces = [np.cross(edges[i], edges[j]) for i, j in ((0, 1), (0, 2), (1, 2), (3, 4))]
    area = np.max([norms(face) for face in faces], axis=0)
    least = FLAT * longest + noise[tets].max(axis=1, initial=0.0)
    # The height is volume / area, unless the tet is no more than a line.
    return (np.abs(volume) <= area * least) | (area <= longest * least)


def triangle_areas(points: Array, noise: Array, cells: Array) -> Pairs:
    """Twice the signed areas of the triangles of polygons in the plane (18.1.3).

    Parameters
    ----------
    points : (np, 2) float64
    noise : (np,) float64
    cells : (n, k) int64
        For quads the triangle of corner i is (i - 1, i, i + 1), Figure 18.1.

    Returns
    -------
    area : (n, c) float64
        c is 1 for triangles, 4 for quads.
    flat : (n, c) bool
    """
    corners = points[cells]
    before, after = np.roll(corners, 1, axis=1), np.roll(corners, -1, axis=1)
    a, b = after - corners, before - corners
    if cells.shape[1] == 3:
        a, b = a[:, :1], b[:, :1]
    area = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    longest = norms(after - corners).max(axis=1, initial=0.0)
    height = FLAT * longest + noise[cells].max(axis=1, initial=0.0)
    return area, np.abs(area) <= (longest * height)[:, None]


def flat_in_space(points: Array, noise: Array, cells: Array) -> Array:
    """Which triangles or quads of a surface have no area, (n,) bool."""
    corners = points[cells]
    # The cross product of the diagonals of a quad is twice its area.
    a, b = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
    longest = norms(np.roll(corners, -1, axis=1) - corners).max(axis=1, initial=0.0)
    height = FLAT * longest + noise[cells].max(axis=1, initial=0.0)
    return norms(np.cross(a, b)) <= longest * height


def plane_of(points: Array, tolerance: float) -> tuple[Array, int] | None:
    """Axes of the plane that points lie in, if they do.

    Parameters
    ----------
    points : (n, 3) float64
    tolerance : float
        Greatest extent across the plane.

    Returns
    -------
    axes : (3, 2) float64
        `points @ axes` are coordinates in the plane.
    normal : int
        The axis the plane is normal to, 2 for z; -1 for an inclined plane.
    """
    extent = np.ptp(points, axis=0)
    for normal in (2, 1, 0):
        if extent[normal] <= tolerance:
            # The axes that follow the normal, in turn, see it come towards the viewer.
            return np.eye(3)[:, [(normal + 1) % 3, (normal + 2) % 3]], normal
    centred = points - points.mean(axis=0)
    _, vectors = np.linalg.eigh(centred.T @ centred)
    if np.ptp(centred @ vectors[:, 0]) > tolerance:
        return None
    return vectors[:, [1, 2]], -1


def same_direction(one: Array, other: Array) -> Array:
    """Whether two facets with the same vertices run round in the same direction.

    Parameters
    ----------
    one, other : (n, w) int64
    """
    width = one.shape[1]
    start = np.argmax(other == one[:, :1], axis=1)
    following = other[np.arange(len(other)), (start + 1) % width]
    # An edge has no direction round, only one along.
    return start == 0 if width == 2 else following == one[:, 1]


def near_pairs(points: Array, distance: float) -> Pairs:
    """Points nearer to each other than a distance, (n,) and (n,) int64.

    Of more than two points in one place, enough pairs to link them all.
    """
    # Along a direction that no grid follows, few points come close by chance.
    along = points @ np.array([0.5773, 0.6301, 0.5193])
    order = np.argsort(along, kind="stable")
    along, points = along[order], points[order]
    reach = distance + 4 * np.finfo(float).eps * np.abs(along).max(initial=0.0)
    left = np.arange(len(order) - 1)
    found: list[Pairs] = []
    # The bound on the lag is for points of which very many lie within the distance.
    for lag in range(1, 64):
        left = left[left + lag < len(order)]
        left = left[along[left + lag] - along[left] <= reach]
        if not len(left):
            break
        apart = norms(points[left + lag] - points[left])
        near = left[apart <= distance]
        found.append((order[near], order[near + lag]))
        # The rest of those in the very same place follow from their neighbour in the list.
        left = left[apart > 0]
    one, other = (np.concatenate([pair[k] for pair in found] or [order[:0]]) for k in (0, 1))
    return one, other


def first_of(n: int, one: Array, other: Array) -> Array:
    """For each of `n` points the least one that pairs link it to, itself included."""
    first = np.arange(n)
    while True:
        least = np.minimum(first[one], first[other])
        before = first.copy()
        for ends in (one, other, before[one], before[other]):
            np.minimum.at(first, ends, least)
        first = first[first]
        if np.array_equal(first, before):
            return first


def _edges_of(family: str) -> Array:
    """Local ends of the edges of a family, each once, (n, 2)."""
    ends = {
        tuple(sorted((int(a), int(b))))
        for table in FACETS[family].values()
        for facet in table
        for a, b in zip(facet, np.roll(facet, -1), strict=True)
    }
    return np.array(sorted(ends))


def _hinges_of(family: str) -> Array:
    """Pairs of facets of a solid that have an edge in common, (n, 2), as `facet_normals` counts."""
    facets = [
        {frozenset((int(a), int(b))) for a, b in zip(facet, np.roll(facet, -1), strict=True)}
        for table in FACETS[family].values()
        for facet in table
    ]
    pairs = [(i, j) for j in range(len(facets)) for i in range(j) if facets[i] & facets[j]]
    return np.array(pairs)


EDGES = {family: _edges_of(family) for family in FACETS}
HINGES = {family: _hinges_of(family) for family in CORNERS}


def facet_normals(points: Array, cells: Array, family: str) -> Array:
    """Outward normals of the facets of solids, (n, f, 3), twice as long as the facet is large."""
    normals = []
    for width, table in FACETS[family].items():
        for facet in table:
            a, b, c = (points[cells[:, k]] for k in facet[:3])
            # The cross product of the diagonals of a quad is twice its mean area.
            d = points[cells[:, facet[3]]] if width == 4 else a
            normals.append(np.cross(c - a, d - b) if width == 4 else np.cross(b - a, c - a))
    return np.stack(normals, axis=1)


def contents(points: Array, cells: Array, family: str) -> Array:
    """Signed volumes of solids, or areas of triangles and quads, (n,).

    Where points have three columns the areas are those in space, which have no sign.
    """
    if family == "tetra":
        parts = [_tet_volumes(points, cells[rows])[0] for rows in chunks(len(cells))]
        return np.concatenate([np.empty(0), *parts]) / 6
    if family in CORNERS:
        origin = points[cells[:, :1]]
        total = np.zeros(len(cells))
        for table in FACETS[family].values():
            for facet in table:
                total += flux(points[cells[:, facet]] - origin)
        return total
    a = points[cells[:, 2]] - points[cells[:, 0]]
    b = points[cells[:, -1]] - points[cells[:, 1]]
    if len(cells) and points.shape[1] == 2:
        return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    return norms(np.cross(a, b)) / 2


def flux(facets: Array) -> Array:
    """What each facet adds to the content that a closed boundary encloses, (n,).

    By the divergence theorem: the volume, or the area in the plane, of the cone from the
    origin. A quad counts as the mean of its two divisions in triangles, so that both of its
    cells see the same.

    Parameters
    ----------
    facets : (n, w, d) float64
        Corners, turned outwards.
    """
    if facets.shape[-1] == 2:
        a, b = facets[:, 0], facets[:, 1]
        return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    if facets.shape[1] == 3:
        return _triple(facets[:, 0], facets[:, 1], facets[:, 2]) / 6
    halves = [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3]]
    return np.sum([flux(facets[:, half]) for half in halves], axis=0) / 2


def _triple(a: Array, b: Array, c: Array) -> Array:
    """Triple product of vectors."""
    return (
        a[:, 0] * (b[:, 1] * c[:, 2] - b[:, 2] * c[:, 1])
        + a[:, 1] * (b[:, 2] * c[:, 0] - b[:, 0] * c[:, 2])
        + a[:, 2] * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    )


def unfolded(points: Array, triangles: Array) -> Pairs:
    """Each triangle in a plane of its own, seen anticlockwise: points with z = 0, and cells."""
    a = points[triangles[:, 1]] - points[triangles[:, 0]]
    b = points[triangles[:, 2]] - points[triangles[:, 0]]
    length = norms(a)
    flat = np.zeros((len(triangles), 3, 3))
    flat[:, 1, 0] = length
    flat[:, 2, 0] = np.einsum("ij,ij->i", a, b) / length
    flat[:, 2, 1] = norms(np.cross(a, b)) / length
    return flat.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)
