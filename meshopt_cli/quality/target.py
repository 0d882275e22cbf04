"""What the boundary of a mesh allows: the row `target` of Table 18.3, and the angles it forces."""

from __future__ import annotations

import math

import numpy as np

from ..kernels.search.target import best_over_face, estimate_targets
from ..kernels.shape.angles import REGULAR_ANGLE_3
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.model import Array
from .measures import MEASURES, Measure, cell_quality
from .room import boundary_edges

# Shapes of boundary faces that are searched for the angles they force, among so many times as
# many of the thinnest faces.
N_SHAPES = 20
FACES_PER_SHAPE = 50


def target(
    simplices: Simplices, measure: Measure, most: int | None = None, faces: Array | None = None
) -> float:
    """Q of the best cell that the worst boundary facet allows (Table 18.3).

    Over an edge of the plane this is the equilateral triangle. Over a triangle of space the
    apex is searched for: first above the centroid for all faces, which gives a bound, then
    everywhere for the faces whose bound is worst, until no other can be worse.

    Parameters
    ----------
    most : int, optional
        Search for no more shapes of faces than this, among the thinnest: what they force holds,
        and others may force more.
    faces : (n, 3) int64, optional
        These facets of the skin alone, as they stand there.
    """
    if simplices.dimension == 2:
        return 1.0
    # Seen from inside, so that an apex on the side of the cell is above.
    faces = simplices.skin if faces is None else faces
    if most is not None and len(faces) > FACES_PER_SHAPE * most:
        n = FACES_PER_SHAPE * most
        faces = faces[np.argpartition(_thinness(simplices.points[faces]), n)[:n]]
    bound = np.empty(len(faces))
    estimate_targets(measure.judge, simplices.points, faces, bound)
    worst = math.inf
    # Regular grids have a few shapes of faces, many times over: each is searched once.
    _, shape, _ = adjacency.distinct_rows(_shapes(simplices.points[faces]))
    seen: set[int] = set()
    for row in np.argsort(bound, kind="stable"):
        if bound[row] >= worst or len(seen) == most:
            break
        if int(shape[row]) not in seen:
            seen.add(int(shape[row]))
            i, j, k = (int(v) for v in faces[row])
            worst = min(worst, best_over_face(measure.judge, simplices.points, i, j, k))
    return 1.0 / worst if 0.0 < worst < math.inf else math.inf


def forced_angles(simplices: Simplices) -> tuple[float, float]:
    """The least dihedral angle that the boundary lets be exceeded nowhere, and the greatest.

    They follow from the worst boundary faces, as `target` does, and from the sharpest edges of
    the boundary and of interfaces.

    Returns
    -------
    least, greatest : float
        Degrees: no mesh has all angles above the one, nor all below the other. 0 and 180 set
        no limit.
    """
    if simplices.dimension == 2:
        return 60.0, 60.0
    regular = math.degrees(REGULAR_ANGLE_3)
    least = regular / target(simplices, MEASURES["angle-min"], N_SHAPES)
    greatest = 180.0 - (180.0 - regular) / target(simplices, MEASURES["angle-max"], N_SHAPES)
    return min(least, _forced_by_edges(simplices)), greatest


def _forced_by_edges(simplices: Simplices) -> float:
    """Least angle in degrees that the edges where two facets of a region meet let be exceeded.

    An edge has one tetrahedron, the one that both facets span, or several, of which one has at
    most half the angle between the facets.
    """
    edges = boundary_edges(simplices)
    is_convex = edges.angles < 180.0
    if not is_convex.any():
        return 180.0
    angles = cell_quality(simplices.points, edges.tets[is_convex], MEASURES["angle-min"])
    alone = angles * math.degrees(REGULAR_ANGLE_3)
    return float(np.maximum(alone, 0.5 * edges.angles[is_convex]).min())


def _thinness(triangles: Array) -> Array:
    """Area over the square of the longest side, (n,); triangles are (n, 3, 3)."""
    sides = triangles - np.roll(triangles, 1, axis=1)
    square = np.einsum("ijk,ijk->ij", sides, sides).max(axis=1)
    area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return np.divide(area, square, out=np.zeros(len(area)), where=square > 0.0)


def _shapes(triangles: Array) -> Array:
    """Two numbers that are equal for similar triangles, (n, 2); triangles are (n, 3, 3)."""
    sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2)
    sides.sort(axis=1)
    return np.round(sides[:, :2] / sides[:, 2:], 9)
