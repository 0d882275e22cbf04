"""Planar meshes: the plane they lie in, and coordinates in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import adjacency

Array = np.ndarray

# A mesh is planar when no vertex is farther from its plane than this part of its extent.
PLANARITY = {np.dtype(np.float64): 1e-6, np.dtype(np.float32): 1e-5}


@dataclass(frozen=True)
class Frame:
    """A plane of space: an origin and the rows u, v, n of a right-handed orthonormal frame."""

    origin: Array
    axes: Array

    def flatten(self, points: Array) -> Array:
        """Coordinates in the plane, (np, 3) with z = 0."""
        flat = (points - self.origin) @ self.axes.T
        flat[:, 2] = 0.0
        return flat

    def unflatten(self, points: Array, flat: Array) -> Array:
        """Bring plane coordinates back to space, keeping the height `points` have over it."""
        height = (points - self.origin) @ self.axes[2]
        return self.origin + flat[:, :2] @ self.axes[:2] + np.outer(height, self.axes[2])


def with_depth(points: Array) -> Array:
    """The points as (np, 3) float64, z = 0 where the file has two columns."""
    result = np.zeros((len(points), 3))
    result[:, : points.shape[1]] = points
    return result


def flatness(points: Array, precision: np.dtype) -> float:
    """How far from a plane vertices may lie, relative to the extent of the mesh.

    Far from the origin, coordinates are rounded more coarsely than the mesh is flat.

    Parameters
    ----------
    points : (n, 3) float64
    precision : dtype
        In which the coordinates are stored.
    """
    extent = float(np.max(np.ptp(points, axis=0))) or 1.0
    rounding = float(np.finfo(precision).eps) * float(np.abs(points).max())
    return max(PLANARITY[precision], 4.0 * rounding / extent)


def plane_of(points: Array, triangles: Array, tolerance: float) -> Frame | None:
    """The plane that all triangles lie in, or None.

    The normal points to the side from which most of the area turns counter-clockwise. In a
    plane normal to an axis the frame only exchanges coordinates, so that they keep every bit.

    Parameters
    ----------
    points : (np, 3) float64
    triangles : (n, 3) int64
    tolerance : float
        Greatest distance from the plane, relative to the extent of the mesh.
    """
    corners = points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    used = points[adjacency.distinct(triangles)]
    extent = float(np.max(np.ptp(used, axis=0)))
    # Triangles may turn either way: line the normals up before adding them.
    largest = normals[np.argmax(np.einsum("ij,ij->i", normals, normals))]
    sides = normals @ largest
    normal = np.sum(normals * np.where(sides < 0, -1.0, 1.0)[:, None], axis=0)
    length = float(np.linalg.norm(normal))
    if length == 0.0 or not np.isfinite(length):
        return None
    normal /= length
    if np.sum(normals @ normal) < 0:
        normal = -normal
    axis = int(np.argmax(np.abs(normal)))
    if np.ptp(used[:, axis]) <= tolerance * extent and abs(normal[axis]) > 1 - 1e-9:
        sign = 1.0 if normal[axis] > 0 else -1.0
        u, v = np.eye(3)[(axis + 1) % 3], sign * np.eye(3)[(axis + 2) % 3]
        return Frame(np.zeros(3), np.stack([u, v, sign * np.eye(3)[axis]]))
    origin = used.mean(axis=0)
    if np.max(np.abs((used - origin) @ normal)) > tolerance * extent:
        return None
    u = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u /= np.linalg.norm(u)
    return Frame(origin, np.stack([u, np.cross(normal, u), normal]))
