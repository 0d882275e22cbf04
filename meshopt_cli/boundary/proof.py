"""Proof that a result fills the domain of the input: what no pass may change."""

from __future__ import annotations

import numpy as np

from ..cells import SIMPLICES
from ..errors import InvariantError
from ..kernels.guide import LINE, STAYS
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.sizes import contents
from .patches import Patches, normals_of, unit
from .redeclare import homes

Array = np.ndarray

# Volume of a region may change by rounding only: this part of the volume of the mesh.
VOLUME_TOLERANCE = 1e-9


def prove_fixed(
    before: Simplices,
    after: Simplices,
    points_before: Array,
    points_after: Array,
    origin: Array,
) -> None:
    """Compare the boundary of a result, as it will be written, with that of the input.

    Parameters
    ----------
    points_before, points_after : (np, 2 or 3) array
        As the files have them.
    origin : (np',) int64
        The point of the input that each point of the result was, -1 for a new one.

    Raises
    ------
    InvariantError
        The boundary or an interface changed.
    """
    if not _are_the_same(before.skin, origin[after.skin], len(before.points)):
        raise InvariantError("the facets of the boundary or of an interface changed")
    prove_vertices(before, points_before, points_after, origin)


def prove_vertices(
    before: Simplices, points_before: Array, points_after: Array, origin: Array
) -> None:
    """Compare the vertices of a boundary with those of the input; see `prove_fixed`.

    Raises
    ------
    InvariantError
        One of them moved.
    """
    skin = adjacency.distinct(before.skin)
    number = np.full(len(before.points), -1)
    number[origin[origin >= 0]] = np.flatnonzero(origin >= 0)
    if not np.array_equal(points_before[skin], points_after[number[skin]]):
        raise InvariantError("a vertex of the boundary moved")


def _are_the_same(facets: Array, others: Array, n_points: int) -> bool:
    """Whether facets are the same as others, turned in any way and in any order."""
    if len(facets) != len(others) or others.min(initial=0) < 0:
        return False
    one, other = (adjacency.canonical(rows, n_points) for rows in (facets, others))
    return np.array_equal(one, other)


def prove_volumes(before: Simplices, after: Simplices, tolerance: float = 0.0) -> None:
    """Compare the volumes of the regions.

    Parameters
    ----------
    tolerance : float
        What they may change by more than rounding, as a part of the volume of the mesh.

    Raises
    ------
    InvariantError
        One changed.
    """
    old, new = _volumes(before), _volumes(after)
    if len(old) != len(new) or np.any(
        np.abs(old - new) > (VOLUME_TOLERANCE + tolerance) * old.sum()
    ):
        raise InvariantError("the volume of a region changed")


def prove_patches(before: Simplices, worked: Simplices, patches: Patches, origin: Array) -> None:
    """Compare a boundary that was worked on with that of the input.

    Parameters
    ----------
    worked : Simplices
        In the frame of `before`.

    Raises
    ------
    InvariantError
        A vertex left its plane or its ridge, a corner or an interface changed, or the area of
        a patch.
    """
    if not _are_the_same(before.inner, origin[worked.inner], len(before.points)):
        raise InvariantError("the facets of an interface changed")
    here = np.flatnonzero(origin >= 0)
    skin = adjacency.distinct(before.skin)
    corners = skin[patches.guide[skin, 0] == STAYS]
    if not np.isin(corners, origin[here]).all():
        raise InvariantError("a vertex of the boundary vanished that may not move")
    guide = patches.guide[origin[here]]
    moved = worked.points[here] - before.points[origin[here]]
    part = np.einsum("ij,ij->i", moved, guide[:, 1:])
    along = part[:, None] * guide[:, 1:]
    off = np.where((guide[:, 0] == LINE)[:, None], moved - along, along)
    off[guide[:, 0] == STAYS] = moved[guide[:, 0] == STAYS]
    off = off[np.isin(origin[here], skin)]
    extent = float(np.ptp(before.points[skin], axis=0).max())
    if np.any(np.abs(off) > patches.tolerance * extent):
        raise InvariantError("a vertex of the boundary left its plane or its ridge")
    patch = homes(patches, worked, origin)
    if np.any(patch < 0):
        raise InvariantError("a facet of the boundary belongs to no plane of it")
    old = _areas(before.points, patches.facets, patches.patch)
    new = _areas(worked.points, worked.outer, patch)
    total = old.sum()
    old = np.concatenate([old, np.zeros(max(0, len(new) - len(old)))])
    new = np.concatenate([new, np.zeros(max(0, len(old) - len(new)))])
    is_known = before.dimension == 3 or worked.patch is not None
    if is_known and np.any(np.abs(old - new) > (VOLUME_TOLERANCE + patches.tolerance) * total):
        raise InvariantError("the area of a plane of the boundary changed")
    if worked.patch is not None:
        _prove_flat(patches, worked, patch, extent)


def _prove_flat(patches: Patches, worked: Simplices, patch: Array, extent: float) -> None:
    """Compare where facets of a worked boundary lie with the planes, or lines, of their patches.

    Raises
    ------
    InvariantError
        One lies farther off than any did before.
    """
    total = np.zeros((len(patches.facets), 3))
    np.add.at(total, patches.patch, normals_of(patches.points, patches.facets))
    normal = unit(total)
    # A patch is numbered by its first facet.
    height = np.einsum("ij,ij->i", normal, patches.points[patches.facets[:, 0]])

    def off(points: Array, facets: Array, of: Array) -> float:
        heights = np.einsum("nkj,nj->nk", points[facets], normal[of]) - height[of, None]
        return float(np.abs(heights).max(initial=0.0))

    least = off(patches.points, patches.facets, patches.patch)
    if off(worked.points, worked.outer, patch) > least + patches.tolerance * extent:
        raise InvariantError("a facet of the boundary left its plane or its line")


def _areas(points: Array, facets: Array, patch: Array) -> Array:
    """Area, or length, of each patch."""
    a, b = points[facets[:, 0]], points[facets[:, 1]]
    if facets.shape[1] == 2:
        size = np.linalg.norm(b - a, axis=1)
    else:
        size = np.linalg.norm(np.cross(b - a, points[facets[:, 2]] - a), axis=1) / 2.0
    return np.bincount(patch, weights=size)


def _volumes(mesh: Simplices) -> Array:
    """Volume of each region."""
    points = np.ascontiguousarray(mesh.points[:, : mesh.dimension])
    volume = contents(points, mesh.cells, SIMPLICES[mesh.dimension])
    return np.bincount(mesh.region, weights=volume)
