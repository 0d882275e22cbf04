"""Planar meshes: the plane they lie in, and coordinates in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..cells import FAMILIES
from . import adjacency
from .facets import CellSet
from .model import Array
from .sizes import area_vectors

# A mesh is planar when no vertex is farther from its plane than this part of its extent, in
# double and in single precision.
PLANARITY = 1e-6, 1e-5

STRAIGHT = 1e-9  # a normal whose cosine to an axis is nearer to 1 than this has its direction


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

    @property
    def normal_axis(self) -> int:
        """The axis of space that the plane is normal to, -1 for an inclined plane."""
        axis = int(np.argmax(np.abs(self.axes[2])))
        return axis if abs(self.axes[2, axis]) > 1 - STRAIGHT else -1

    @property
    def is_exact(self) -> bool:
        """Whether coordinates in the plane are some of those in space, bit for bit."""
        return not self.origin.any() and bool((np.abs(self.axes).max(axis=1) == 1.0).all())

    def upright(self) -> Frame:
        """The frame as it is seen from where the axis points that it is most nearly normal to."""
        axis = int(np.argmax(np.abs(self.axes[2])))
        if self.axes[2, axis] > 0:
            return self
        return Frame(self.origin, self.axes * np.array([[1.0], [-1.0], [-1.0]]))


class InPlane(NamedTuple):
    """Points in the plane of a planar mesh: coordinates (np, 2), their noise (np,), and the axis
    that the plane is normal to, seen from where it points to; -1 for an inclined plane."""

    points: Array
    noise: Array
    normal: int


def with_depth(points: Array) -> Array:
    """The points as (np, 3) float64, z = 0 where the file has two columns."""
    result = np.zeros((len(points), 3))
    result[:, : points.shape[1]] = points
    return result


def precision_of(points: Array) -> float:
    """Relative spacing of the numbers that coordinates are stored as; double for integers."""
    return float(np.finfo(points.dtype if points.dtype.kind == "f" else np.float64).eps)


def flatness(points: Array, precision: float) -> float:
    """How far from a plane vertices may lie, relative to the extent of the mesh.

    Far from the origin, coordinates are rounded more coarsely than the mesh is flat.

    Parameters
    ----------
    points : (n, 3) float64
    precision : float
        See `precision_of`.
    """
    extent = float(np.max(np.ptp(points, axis=0))) or 1.0
    rounding = precision * float(np.abs(points).max())
    return max(PLANARITY[precision > 1e-10], 4.0 * rounding / extent)


def plane_of(points: Array, triangles: Array, precision: float) -> Frame | None:
    """The plane that all triangles lie in, or None: the one test of what is planar.

    The normal points to the side from which most of the area turns counter-clockwise. In a
    plane normal to an axis the frame only exchanges coordinates, so that they keep every bit.

    Parameters
    ----------
    points : (np, 3) float64
    triangles : (n, 3) int64
    precision : float
        Of the coordinates as they are stored, see `precision_of`: it says how far from the plane
        vertices may lie.
    """
    used = points[adjacency.distinct(triangles)]
    if not len(used):
        return None
    extent = np.ptp(used, axis=0)
    limit = flatness(used, precision) * float(extent.max())
    normals = area_vectors(points, triangles)
    # Triangles may turn either way: line the normals up before adding them.
    largest = normals[np.argmax(np.einsum("ij,ij->i", normals, normals))]
    sides = normals @ largest
    normal = np.sum(normals * np.where(sides < 0, -1.0, 1.0)[:, None], axis=0)
    if not normal.any():  # all are flat: along an axis they may lie in a plane all the same
        normal[2 - int(np.argmin(extent[::-1]))] = 1.0
    length = float(np.linalg.norm(normal))
    if not np.isfinite(length):
        return None
    normal /= length
    if np.sum(normals @ normal) < 0:
        normal = -normal
    axis = int(np.argmax(np.abs(normal)))
    if np.ptp(used[:, axis]) <= limit and abs(normal[axis]) > 1 - STRAIGHT:
        sign = 1.0 if normal[axis] > 0 else -1.0
        u, v = np.eye(3)[(axis + 1) % 3], sign * np.eye(3)[(axis + 2) % 3]
        return Frame(np.zeros(3), np.stack([u, v, sign * np.eye(3)[axis]]))
    origin = used.mean(axis=0)
    if np.max(np.abs((used - origin) @ normal)) > limit:
        return None
    u = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u /= np.linalg.norm(u)
    return Frame(origin, np.stack([u, np.cross(normal, u), normal]))


def in_plane(
    points: Array, noise: Array, cell_sets: list[CellSet], precision: float
) -> InPlane | None:
    """The points in the plane of some faces, one at least; None if they do not lie in one.

    Parameters
    ----------
    points : (np, 3) float64
    noise : (np,) float64
        Error of the coordinates.
    precision : float
        See `precision_of`.
    """
    halves = [g.cells[:, FAMILIES[g.family].partitions[0]].reshape(-1, 3) for g in cell_sets]
    frame = plane_of(points, np.concatenate(halves), precision)
    if frame is None:
        return None
    frame = frame.upright()
    flat = frame.flatten(points)[:, :2]
    if not frame.is_exact:
        # How far the plane is from the origin does not matter.
        noise = 4 * precision * np.abs(flat).max(axis=1)
    return InPlane(flat, noise, frame.normal_axis)
