"""Whether vertices are where they were told to stay."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InvariantError
from ..kernels.guide import LINE, PLANE, SPACE
from ..mesh.model import Mesh
from ..mesh.plane import with_depth
from . import grammar
from .grammar import KeepOff
from .model import Constraints, noise_of
from .near import nearest, pairs_within
from .told import faces_of

Array = np.ndarray


def prove_constraints(constraints: Constraints, before: Array, after: Array, single: bool) -> None:
    """Compare vertices, before and after the work, with what they were told.

    Parameters
    ----------
    before, after : (np, 3) float64
        In the coordinates of the work; of vertices that are not there any more, twice the same.
    single : bool
        Whether they are stored in single precision.

    Raises
    ------
    InvariantError
    """
    steps = after - before
    kind, direction = constraints.guide[:, 0], constraints.guide[:, 1:]
    part = np.einsum("ij,ij->i", steps, direction)
    off = np.zeros(len(steps))
    off[kind == PLANE] = np.abs(part[kind == PLANE])
    rest = steps - part[:, None] * direction
    off[kind == LINE] = np.linalg.norm(rest[kind == LINE], axis=1)
    # Every step of many is rounded.
    noise = 100.0 * noise_of(before, single)
    wrong = np.flatnonzero((off > noise) & (kind < SPACE))
    if len(wrong):
        raise InvariantError(f"vertex {wrong[0]} left the line or plane that it was told to keep")
    vertices = np.repeat(np.arange(len(before)), np.diff(constraints.start))
    slack = [
        np.einsum("ij,ij->i", points[vertices], constraints.limits[:, :3])
        - constraints.limits[:, 3]
        for points in (before, after)
    ]
    wrong = np.flatnonzero((slack[1] < -noise) & (slack[1] < slack[0] - noise))
    if len(wrong):
        raise InvariantError(f"vertex {vertices[wrong[0]]} went where it was told not to be")


def strays(keep_offs: Sequence[KeepOff], mesh: Mesh, after: Array, single: bool) -> Array:
    """Vertices that came nearer to what is to be kept off than they may, and than they were.

    Parameters
    ----------
    mesh : Mesh
        Before the work.
    after : (np, 3) float64
        Its points after it; those of vertices that are not there any more as they were.

    Returns
    -------
    strays : (np,) bool
    """
    before = with_depth(mesh.points)
    noise = 100.0 * noise_of(before, single)
    found = np.zeros(len(before), dtype=bool)
    moved = np.flatnonzero(np.any(after != before, axis=1))
    for one in keep_offs:
        was, now = (_distances(one, mesh, points[moved]) for points in (before, after))
        found[moved[(now < one.distance - noise) & (now < was - noise)]] = True
    return found


def too_near(keep_offs: Sequence[KeepOff], mesh: Mesh, points: Array, single: bool) -> int:
    """How many points, (n, 3), are nearer to what is to be kept off than they may be."""
    near = np.zeros(len(points), dtype=bool)
    for one in keep_offs:
        near |= _distances(one, mesh, points) < one.distance - 100.0 * noise_of(points, single)
    return int(np.count_nonzero(near))


def _distances(one: KeepOff, mesh: Mesh, points: Array) -> Array:
    """How far points are from what is to be kept off, (n,), or more than that where it is far."""
    if one.kind == grammar.PLANE:
        origin, normal = np.array(one.points)
        return np.abs((points - origin) @ normal) / np.linalg.norm(normal)
    if one.kind in grammar.CORNERS:
        corners = np.array(one.points)[np.minimum(np.arange(3), len(one.points) - 1)]
        there = nearest(np.broadcast_to(corners, (len(points), 3, 3)), points)
        return np.linalg.norm(points - there, axis=1)
    faces = with_depth(mesh.points)[faces_of(one, mesh)]
    rows, _, _, distance = pairs_within(faces, points, np.full(len(points), one.distance))
    found = np.full(len(points), np.inf)
    np.minimum.at(found, rows, distance)
    return found
