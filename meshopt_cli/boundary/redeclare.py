"""The facets of a boundary that was worked on: of which patch each is, and how it is declared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.model import Mesh
from .patches import Patches

Array = np.ndarray


def homes(patches: Patches, worked: Simplices, origin: Array) -> Array:
    """The patch that each outer facet of a worked mesh lies in, (n,) int64; -1 where none does.

    Parameters
    ----------
    worked : Simplices
        Without patches of its own, its outer facets have vertices of the input only.
    origin : (np',) int64
        The point of the input that each point of `worked` was, -1 for a new one.
    """
    facets = origin[worked.outer]
    place = _unchanged(patches, facets)
    patch = np.where(place >= 0, patches.patch[place], -1)
    if worked.patch is not None:
        return np.where(worked.patch >= 0, worked.patch, patch)
    rows = np.flatnonzero((place < 0) & (facets >= 0).all(axis=1))
    at = _patches_at(patches, adjacency.distinct(facets[rows]))
    for row in rows.tolist():
        # A new facet lies in the patch that all its vertices have facets in.
        common = set.intersection(*(at[vertex] for vertex in facets[row].tolist()))
        patch[row] = min(common, default=-1)
        if len(common) > 1:  # all of them lie on a ridge between two patches
            middle = worked.points[worked.outer[row]].mean(axis=0)
            patch[row] = _patch_around(patches, middle, sorted(common))
    return patch


def _unchanged(patches: Patches, facets: Array) -> Array:
    """The facet before the work that each of some is still, -1 for a new one, (n,) int64.

    Parameters
    ----------
    facets : (n, d) int64
        In the points of the input, -1 for new points.
    """
    place = adjacency.places_in(patches.facets, np.maximum(facets, 0), len(patches.points))
    return np.where((facets >= 0).all(axis=1), place, -1)


def _patch_around(patches: Patches, place: Array, candidates: list[int]) -> int:
    """The patch, of some in space, that a place lies in: patches cover what they covered."""
    rows = np.flatnonzero(np.isin(patches.patch, candidates))
    a, b, c = patches.points[patches.facets[rows]].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    square = np.einsum("ij,ij->i", normal, normal)
    # How far inside of each facet it is, by its least barycentric coordinate.
    inside = np.min(
        [np.einsum("ij,ij->i", np.cross(q - p, place - p), normal) / square
         for p, q in ((a, b), (b, c), (c, a))], axis=0,
    )  # fmt: skip
    off = np.einsum("ij,ij->i", place - a, normal) ** 2 / square
    near = off <= off.min() + patches.tolerance * np.sqrt(square)
    return int(patches.patch[rows[np.argmax(np.where(near, inside, -np.inf))]])


def _patches_at(patches: Patches, vertices: Array) -> dict[int, set[int]]:
    """The patches that some vertices have facets in."""
    width = patches.facets.shape[1]
    corner, patch = patches.facets.ravel(), np.repeat(patches.patch, width)
    wanted = np.isin(corner, vertices)
    pairs, _, _ = adjacency.distinct_rows(np.stack([corner[wanted], patch[wanted]], axis=1))
    found: dict[int, set[int]] = {vertex: set() for vertex in vertices.tolist()}
    for vertex, one in pairs.tolist():
        found[vertex].add(one)
    return found


def redeclared(
    mesh: Mesh, result: Mesh, patches: Patches, worked: Simplices, origin: Array
) -> Mesh:
    """Declare the facets of a worked boundary as those that they took the place of were.

    Parameters
    ----------
    mesh, result : Mesh
        Before the work, and after it as `cast.with_simplices` gives it.
    origin : (np',) int64
        The point of `mesh` that each point of the result was, -1 for a new one.
    """
    patch = homes(patches, worked, origin)
    facets = worked.outer
    place = _unchanged(patches, origin[facets])
    kept = place >= 0
    gone = np.setdiff1d(patches.declared[patches.declared >= 0], patches.declared[place[kept]])
    template = np.full(len(patches.facets), -1)
    has = np.flatnonzero(patches.declared >= 0)
    template[patches.patch[has]] = patches.declared[has]
    wanted = np.where(kept, -1, template[np.maximum(patch, 0)])
    return _with_facets(mesh, result, facets, wanted, gone, origin, worked.facet_type)


def _with_facets(
    mesh: Mesh,
    result: Mesh,
    facets: Array,
    wanted: Array,
    gone: Array,
    origin: Array,
    kind: str,
) -> Mesh:
    """Take the declared facets that are gone out of a mesh, and put new ones in their blocks."""
    number = np.full(len(mesh.points), -1)
    number[origin[origin >= 0]] = np.flatnonzero(origin >= 0)
    blocks = []
    first = 0
    declaring = iter(block for block in mesh.blocks if block.type == kind)
    for block in result.blocks:
        if block.type != kind:
            blocks.append(block)
            continue
        old = next(declaring)
        rows = np.arange(first, first + len(old.cells))
        first += len(old.cells)
        # `result` lacks the rows whose vertices are gone.
        there = (number[old.cells] >= 0).all(axis=1)
        stays = ~np.isin(rows[there], gone)
        new = np.flatnonzero((wanted >= rows[:1].min(initial=0)) & np.isin(wanted, rows))
        source = wanted[new] - (rows[0] if len(rows) else 0)
        cells = np.concatenate([block.cells[stays], facets[new]])
        data = {
            name: np.concatenate([values[stays], old.data[name][source]])
            for name, values in block.data.items()
        }
        blocks.append(replace(block, cells=cells, data=data))
    return replace(result, blocks=blocks)
