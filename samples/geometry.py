"""Quality, boundary and shaking of simplices: what the makers of the samples share."""

import itertools

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DECIMALS = 6  # coordinates are rounded before any test, so a file holds what was tested
ALPHA = {3: np.sqrt(3) / 6, 4: np.sqrt(6) / 36}


def measure(points: Floats, cells: Ints) -> Floats:
    """Signed areas of triangles (seen from above z = 0), or signed volumes of tetrahedra."""
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    normal = np.cross(edges[:, 0], edges[:, 1])
    if cells.shape[1] == 3:
        return normal[:, 2] / 2
    return np.einsum("ij,ij->i", normal, edges[:, 2]) / 6


def face_areas(points: Floats, faces: Ints) -> Floats:
    """Areas of triangles in space."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def aspect_ratio(points: Floats, cells: Ints) -> Floats:
    """Aspect ratio of each cell; infinite when the cell is flat or inverted."""
    corners = range(cells.shape[1])
    lengths = [
        np.linalg.norm(points[cells[:, i]] - points[cells[:, j]], axis=1)
        for i, j in itertools.combinations(corners, 2)
    ]
    if len(corners) == 3:
        rim = np.sum(lengths, axis=0) / 2
    else:
        faces = itertools.combinations(corners, 3)
        rim = np.sum([face_areas(points, cells[:, face]) for face in faces], axis=0)
    size = measure(points, cells)
    with np.errstate(divide="ignore"):
        ratio = ALPHA[len(corners)] * np.max(lengths, axis=0) * rim / size
    return np.where(size > 0, ratio, np.inf)


def directed_facets(cells: Ints) -> Ints:
    """Edges of triangles or faces of tetrahedra, each turned as its cell is.

    Positive triangles give counter-clockwise edges, positive tetrahedra outward faces.
    """
    local = {3: [[0, 1], [1, 2], [2, 0]], 4: [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]}
    return np.concatenate([cells[:, facet] for facet in local[cells.shape[1]]])


def boundary_facets(cells: Ints) -> Ints:
    """Directed facets that belong to one cell only."""
    facets = directed_facets(cells)
    _, inverse, counts = np.unique(
        np.sort(facets, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    return facets[counts[inverse.ravel()] == 1]


def oriented(points: Floats, cells: Ints) -> Ints:
    """The cells, all turned positive, sorted by their vertices."""
    cells = np.sort(cells, axis=1)
    negative = measure(points, cells) < 0
    cells[negative, -2:] = cells[negative, :-3:-1]
    return cells[np.lexsort(cells.T[::-1])]


def balls(n_points: int, cells: Ints) -> list[Ints]:
    """Numbers of the cells around each vertex."""
    order = np.argsort(cells.ravel(), kind="stable")
    counts = np.bincount(cells.ravel(), minlength=n_points)
    return np.split(order // cells.shape[1], np.cumsum(counts)[:-1])


def perturb(
    points: Floats,
    cells: Ints,
    movable: NDArray[np.bool_],
    reach: Floats,
    worst: float,
    rng: np.random.Generator,
) -> Floats:
    """Move vertices at random by up to `reach`, or less where a cell would get past `worst`."""
    points = points.copy()
    ball = balls(len(points), cells)
    for vertex in np.flatnonzero(movable):
        old = points[vertex].copy()
        step = rng.uniform(-1, 1, 3) * reach
        for _ in range(6):
            points[vertex] = np.round(old + step, DECIMALS)
            if aspect_ratio(points, cells[ball[vertex]]).max() < worst:
                break
            step = step / 2
        else:
            points[vertex] = old
    return points
