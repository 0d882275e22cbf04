"""How near points are to planes, edges and faces, and the half-spaces that keep them off."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

Array = np.ndarray

PAIRS = 1 << 21  # of points and faces, looked at together


class HalfSpaces(NamedTuple):
    """Half-spaces `normal . x >= offset`, each of one vertex."""

    vertices: Array  # (n,) int64
    normals: Array  # (n, 3) float64, of length 1
    offsets: Array  # (n,) float64


def nearest(faces: Array, points: Array) -> Array:
    """The nearest point of a triangle to each point, (n, 3).

    Parameters
    ----------
    faces : (n, 3, 3) float64
        Corners; some may be the same, which makes an edge or a point of it.
    points : (n, 3) float64
    """
    found = np.empty_like(points)
    least = np.full(len(points), np.inf)
    for k in range(3):
        a, b = faces[:, k], faces[:, (k + 1) % 3]
        edge = b - a
        square = np.einsum("ij,ij->i", edge, edge)
        part = np.einsum("ij,ij->i", points - a, edge) / np.where(square > 0.0, square, 1.0)
        there = a + np.clip(part, 0.0, 1.0)[:, None] * edge
        far = np.einsum("ij,ij->i", points - there, points - there)
        nearer = far < least
        found[nearer], least[nearer] = there[nearer], far[nearer]
    normal = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    square = np.einsum("ij,ij->i", normal, normal)
    inside = square > 0.0
    for k in range(3):
        a, b = faces[:, k], faces[:, (k + 1) % 3]
        inside &= np.einsum("ij,ij->i", np.cross(b - a, points - a), normal) > 0.0
    height = np.einsum("ij,ij->i", points[inside] - faces[inside, 0], normal[inside])
    found[inside] = points[inside] - (height / square[inside])[:, None] * normal[inside]
    return found


def pairs_within(faces: Array, points: Array, reach: Array) -> tuple[Array, Array, Array, Array]:
    """Points and faces that are no farther from each other than so much.

    Parameters
    ----------
    reach : (n,) float64
        For each point.

    Returns
    -------
    one, other : (m,) int64
        Rows of points, ascending, and of faces.
    place : (m, 3) float64
        The nearest point of the face.
    distance : (m,) float64
    """
    centre = faces.mean(axis=1)
    radius = np.linalg.norm(faces - centre[:, None], axis=2).max(axis=1, initial=0.0)
    step = max(1, PAIRS // max(1, len(faces)))
    parts = []
    for begin in range(0, len(points), step):
        here = points[begin : begin + step]
        far = np.linalg.norm(here[:, None] - centre[None], axis=2)
        one, other = np.nonzero(far <= radius[None] + reach[begin : begin + step, None])
        place = nearest(faces[other], here[one])
        distance = np.linalg.norm(here[one] - place, axis=1)
        near = distance <= reach[begin + one]
        parts.append((begin + one[near], other[near], place[near], distance[near]))
    if not parts:
        nothing = np.empty(0, np.int64)
        return nothing, nothing, np.empty((0, 3)), np.empty(0)
    one, other, place, distance = (np.concatenate(part) for part in zip(*parts, strict=True))
    return one, other, place, distance


def off_faces(
    vertices: Array, points: Array, place: Array, distance: Array, least: float
) -> HalfSpaces:
    """Half-spaces of points that do not lie on what they are to keep off.

    What they keep off is convex: its nearest point has all of it on the other side, so that the
    half-space is at least as far from all of it as from that point.
    """
    apart = distance > 0.0
    normals = (points[apart] - place[apart]) / distance[apart, None]
    offsets = np.einsum("ij,ij->i", normals, place[apart]) + least
    return HalfSpaces(vertices[apart], normals, offsets)


def around_home(vertices: Array, points: Array, travel: Array, dimension: int) -> HalfSpaces:
    """Half-spaces that keep points within so much of where they are."""
    axes = np.concatenate([np.eye(3)[:dimension], -np.eye(3)[:dimension]])
    normals = np.tile(axes, (len(vertices), 1))
    rows = np.repeat(np.arange(len(vertices)), 2 * dimension)
    offsets = np.einsum("ij,ij->i", normals, points[rows])
    offsets -= travel[rows] / np.sqrt(dimension)
    return HalfSpaces(vertices[rows], normals, offsets)
