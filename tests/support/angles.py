"""Angles of triangles in the plane, by numpy alone."""

from __future__ import annotations

import numpy as np


def angles_of(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """The three angles of each triangle in degrees, (n, 3)."""
    corners = points[cells][:, :, :2]
    u = np.roll(corners, -1, axis=1) - corners
    v = np.roll(corners, 1, axis=1) - corners
    area = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return np.degrees(np.arctan2(area, np.sum(u * v, axis=2)))


def n_obtuse(points: np.ndarray, cells: np.ndarray) -> int:
    """Number of triangles with an angle above 90 degrees, but for rounding."""
    return int(np.count_nonzero(angles_of(points, cells).max(axis=1) > 90.0 + 1e-6))
