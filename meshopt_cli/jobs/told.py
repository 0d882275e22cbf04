"""Vertices that are told where to stay, in one optimization."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np

from ..boundary.patches import Patches
from ..cells import SIMPLICES
from ..constraints.grammar import KeepOff
from ..constraints.model import Constraints, noise_of
from ..constraints.proof import prove_constraints, strays, too_near
from ..constraints.told import Place, constraints_of, edges_of
from ..mesh.any_cells import AnyCells
from ..mesh.cast import Simplices
from ..mesh.model import Mesh
from ..mesh.plane import with_depth

log = logging.getLogger("meshopt")

Array = np.ndarray


def constraints_on(
    mesh: Mesh, part: Simplices | AnyCells, keep_offs: Sequence[KeepOff], near: Array | None = None
) -> Constraints | None:
    """What the vertices of a mesh are told, see `constraints_of`; None where it is nothing."""
    if isinstance(part, Simplices):
        sets = [(SIMPLICES[part.dimension], part.cells)]
    else:
        sets = [(group.family, group.cells) for group in part.cell_sets]
    mirrored = isinstance(part, AnyCells) and part.mirrored
    place = Place(part.points, edges_of(sets), part.frame, mirrored, part.single)
    return constraints_of(mesh, place, keep_offs, near)


def staying(part: Simplices, patches: Patches | None) -> Array:
    """Vertices that stay whatever they are told, (np,) bool."""
    stays = part.fixed.copy()
    stays[part.skin] = True
    stays[part.edges] = True
    return stays if patches is None else stays & (patches.guide[:, 0] == 0.0)


def in_work(part: AnyCells, points: Array) -> Array:
    """Points of the file in the coordinates of the work, (np, 3)."""
    points = with_depth(points)
    if part.frame is not None:
        return part.frame.flatten(points)
    return points * np.array([1.0, 1.0, -1.0]) if part.mirrored else points


def found_stray(
    mesh: Mesh, result: Mesh, origin: Array, keep_offs: Sequence[KeepOff], near: Array | None
) -> Array | None:
    """Vertices that are to be told as well what to keep off; None where all is well.

    Those that were far from it were told nothing, so that they may be moved by all means.

    Parameters
    ----------
    mesh, result : Mesh
        Before and after, by their corners.
    origin : (np',) int64
        The point of `mesh` that each point of `result` was, -1 for a new one.
    near : (np,) bool, optional
        Those that were told so.
    """
    if not keep_offs:
        return None
    after = with_depth(mesh.points).copy()
    old = np.flatnonzero(origin >= 0)
    after[origin[old]] = with_depth(result.points)[old]
    found = strays(keep_offs, mesh, after, mesh.points.dtype == np.float32)
    if near is None:
        return found if found.any() else None
    return found | near if (found & ~near).any() else None


def warn_of_new(mesh: Mesh, result: Mesh, origin: Array, keep_offs: Sequence[KeepOff]) -> None:
    """Say how many new vertices are nearer to what is to be kept off than others may be."""
    new = with_depth(result.points)[origin < 0]
    n = too_near(keep_offs, mesh, new, mesh.points.dtype == np.float32) if len(new) else 0
    if n:
        log.warning(
            "%d new vertices are nearer than --keep-off says, which holds for those of the input", n
        )  # fmt: skip


def prove_told(
    constraints: Constraints | None,
    before: Simplices | AnyCells,
    points: Array,
    origin: Array,
    fixed: Array,
) -> None:
    """Compare a result with what its vertices were told, and say how many could not follow.

    Parameters
    ----------
    points : (np', 3) float64
        After the work, in its coordinates.
    origin : (np',) int64
        The point of `before` that each of them was, -1 for a new one.
    fixed : (np,) bool
        Vertices that stay in any case.

    Raises
    ------
    InvariantError
    """
    if constraints is None:
        return
    after = before.points.copy()
    after[origin[origin >= 0]] = points[origin >= 0]
    prove_constraints(constraints, before.points, after, before.single)
    vertices = np.repeat(np.arange(len(after)), np.diff(constraints.start))
    slack = np.einsum("ij,ij->i", after[vertices], constraints.limits[:, :3])
    slack -= constraints.limits[:, 3]
    outside = np.unique(vertices[slack < -2.0 * noise_of(after, before.single)])
    outside = outside[~fixed[outside]]
    if len(outside):
        log.warning(
            "%d vertices stay where they were told not to be: moving them would make a cell worse "
            "than the worst, or there is no room for them", len(outside),
        )  # fmt: skip
