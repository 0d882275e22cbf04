"""A measure: how much of the box around it a cell fills."""

import numpy as np

from meshopt_cli.plugins import MORE, NUMBER, Measure, Way


def _triangles(points: np.ndarray, cells: np.ndarray, family: str) -> np.ndarray:
    """Of triangles, in the plane of x and y."""
    p = points[cells, :2]
    (ax, ay), (bx, by) = (p[:, 1] - p[:, 0]).T, (p[:, 2] - p[:, 0]).T
    return _share(np.abs(ax * by - ay * bx) / 2.0, np.ptp(p, axis=1))


def _tetrahedra(points: np.ndarray, cells: np.ndarray, family: str) -> np.ndarray:
    p = points[cells]
    edges = p[:, 1:] - p[:, :1]
    return _share(np.abs(np.linalg.det(edges)) / 6.0, np.ptp(p, axis=1))


def _share(content: np.ndarray, extents: np.ndarray) -> np.ndarray:
    box = extents.prod(axis=1)
    return np.divide(content, box, out=np.zeros_like(content), where=box > 0)


BOX_SHARE = Measure(
    "box-share",
    {
        "triangle": Way("", function=_triangles, at_once=True),
        "tetra": Way("", function=_tetrahedra, at_once=True),
    },
    "content over that of the box around the cell",
    NUMBER,
    MORE,
)
