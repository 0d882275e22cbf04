"""What facets, sharp edges and fixed vertices let each tetrahedron be, and which fall short."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..cells import SIMPLICES, TET_FACETS
from ..kernels.search.target import estimate_targets
from ..kernels.shape.angles import REGULAR_ANGLE_3
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.model import Array
from ..mesh.sizes import angles_between, area_vectors, contents
from .measures import Measure, as_degradation, cell_quality

NEAR = 1.1  # a Q of less than so many times the best there can be is near it
N_PLACES = 5
REGULAR = math.degrees(REGULAR_ANGLE_3)
N_ANGLES, N_REACHES = 140, 60  # shapes of tets on an edge that are looked at for the best of them


@dataclass(frozen=True)
class Place:
    """A cell that could be better.

    Attributes
    ----------
    where : (float, float, float)
        Its centre.
    worst, allowed : float
        Its Q, and the least that it might have.
    """

    where: tuple[float, ...]
    worst: float
    allowed: float


@dataclass(frozen=True)
class Room:
    """What cells might gain.

    Attributes
    ----------
    held : int
        Cells that facets, edges or vertices keep from being regular.
    near : int
        Those of them that are within 10 % of what is allowed.
    places : tuple of Place
        The cells with most room left, held or not.
    """

    held: int
    near: int
    places: tuple[Place, ...]


@dataclass(frozen=True)
class BoundaryEdges:
    """Edges where two facets of a region meet.

    Attributes
    ----------
    ends : (n, 2) int64
    region : (n,) int64
    angles : (n,) float64
        Between the facets on the side of the region, in degrees; 180 for more than that.
    tets : (n, 4) int64
        Vertices of the tetrahedron that the facets span.
    """

    ends: Array
    region: Array
    angles: Array
    tets: Array


def boundary_edges(simplices: Simplices) -> BoundaryEdges:
    """Edges of the boundary and of interfaces, where two facets of a region meet."""
    points, skin = simplices.points, simplices.skin
    region = np.repeat(simplices.region[np.nonzero(simplices.neighbours < 0)[0]], 3)
    ends = adjacency.edges_of_triangles(skin)
    keys = adjacency.row_keys(ends, len(points))
    _, edge, n_facets = adjacency.distinct_rows(np.stack([keys, region], axis=1))
    pairs = np.argsort(edge, kind="stable")
    pairs = pairs[n_facets[edge[pairs]] == 2].reshape(-1, 2)
    # Seen from inside one of the facets.
    tets = np.column_stack([ends[pairs[:, 0]], np.roll(skin, 1, axis=1).ravel()[pairs]])
    is_convex = contents(points, tets, SIMPLICES[3]) > 0.0
    one, other = (area_vectors(points, tets[:, [0, 1, apex]]) for apex in (2, 3))
    angles = np.where(is_convex, np.degrees(angles_between(one, other)), 180.0)
    return BoundaryEdges(ends[pairs[:, 0]], region[pairs[:, 0]], angles, tets)


def best_at_angle(measure: Measure, degrees: Array) -> Array:
    """q of the best tetrahedron with a dihedral angle of at most so much, (n,).

    By symmetry its edge across is at right angles to that of the angle, middle over middle.
    """
    angles = np.linspace(0.5, REGULAR, N_ANGLES)
    reaches = np.geomspace(0.3, 3.0, N_REACHES)  # of the other vertices, in lengths of the edge
    half = np.radians(angles)[:, None] / 2.0
    x = reaches * np.cos(half)
    y = reaches * np.sin(half)
    corners = np.zeros((N_ANGLES, N_REACHES, 4, 3))
    corners[..., 0, 2], corners[..., 1, 2] = -0.5, 0.5
    corners[..., 2:, 0] = x[..., None]
    corners[..., 2, 1], corners[..., 3, 1] = -y, y
    cells = np.arange(corners[..., 0].size).reshape(-1, 4)
    q = cell_quality(corners.reshape(-1, 3), cells, measure).reshape(N_ANGLES, N_REACHES)
    best = np.maximum.accumulate(np.abs(q).max(axis=1))
    return np.interp(degrees, [0.0, *angles], [0.0, *best])


def allowed(simplices: Simplices, measure: Measure) -> Array:
    """The q that each tetrahedron might have where it is, (ne,); 1 for those that nothing holds.

    A facet whose vertices are all fixed lets it be so good as the best tetrahedron on it, an edge
    of the boundary so good as its angle, and four fixed vertices so good as it is.
    """
    cells, points = simplices.cells, simplices.points
    fixed = simplices.fixed.copy()
    fixed[simplices.skin] = True
    held = fixed[cells]
    whole = held.all(axis=1)
    result = np.ones(len(cells))
    rows, local = np.nonzero(held[:, TET_FACETS].all(axis=2) & ~whole[:, None])
    bound = np.empty(len(rows))
    faces = np.ascontiguousarray(cells[rows[:, None], TET_FACETS[local]])
    estimate_targets(measure.judge, points, faces, bound)
    np.minimum.at(result, rows, bound)
    edges = boundary_edges(simplices)
    sharp = np.flatnonzero(edges.angles < REGULAR)
    if len(sharp):
        rows, angles = _at_edges(simplices, edges, sharp, held)
        np.minimum.at(result, rows, best_at_angle(measure, angles))
    result[whole] = cell_quality(points, cells[whole], measure)
    return np.maximum(result, 0.0)


def _at_edges(
    simplices: Simplices, edges: BoundaryEdges, chosen: Array, held: Array
) -> tuple[Array, Array]:
    """Cells with some of these edges, and the angle there."""
    cells = np.flatnonzero(np.count_nonzero(held, axis=1) >= 2)
    n = len(simplices.points)
    ends = simplices.cells[cells][:, adjacency.edge_table(simplices.cells)]
    region = np.repeat(simplices.region[cells], ends.shape[1])
    wanted = np.stack([adjacency.row_keys(edges.ends[chosen], n), edges.region[chosen]], axis=1)
    those = np.stack([adjacency.row_keys(ends.reshape(-1, 2), n), region], axis=1)
    _, number, _ = adjacency.distinct_rows(np.concatenate([wanted, those]))
    angle = np.full(int(number.max()) + 1, np.inf)
    angle[number[: len(chosen)]] = edges.angles[chosen]
    found = angle[number[len(chosen) :]]
    at = np.flatnonzero(np.isfinite(found))
    return cells[at // ends.shape[1]], found[at]


def room(simplices: Simplices, measure: Measure, q: Array) -> Room | None:
    """What the cells might gain; None for triangles, all of which may be regular.

    Parameters
    ----------
    q : (ne,) float64
        What they have by the measure.
    """
    if simplices.dimension == 2:
        return None
    best = np.maximum(allowed(simplices, measure), q)
    held, far = best < 1.0, NEAR * q < best
    rows = np.flatnonzero(far)
    ratio = best[rows] / np.maximum(q[rows], np.finfo(float).tiny)
    most = rows[np.argsort(-ratio, kind="stable")[:N_PLACES]]
    centres = simplices.points[simplices.cells[most]].mean(axis=1)
    places = zip(centres.tolist(), as_degradation(q[most]), as_degradation(best[most]), strict=True)
    return Room(
        int(np.count_nonzero(held)),
        int(np.count_nonzero(held & ~far)),
        tuple(Place(tuple(where), float(now), float(might)) for where, now, might in places),
    )
