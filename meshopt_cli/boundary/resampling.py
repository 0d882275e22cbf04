"""A boundary that keeps its shape and gets other vertices: which of its patches may.

Its edges are split, in planes and on the straight ridges between them, and what can move may
vanish. Facets that must stay do, and so do those of curved parts, whose shape they only come near
to.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..cells import SIMPLICES
from ..kernels.guide import LINE, STAYS
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.model import Mesh, main_blocks
from ..mesh.tags import REQUIRED, flagged
from .patches import Patches, declared_among, normals_of, sides_of_edges

Array = np.ndarray

# Facets that bend by less than this angle, and in which nothing can move, are pieces of a curve.
GENTLE = np.radians(40.0)


def resampled(patches: Patches, mesh: Mesh, source: Simplices) -> Patches:
    """The patches of a boundary whose edges may be split, and whose vertices may vanish.

    Parameters
    ----------
    patches : Patches
        What `patches_of` gave for the mesh.
    source : Simplices
        What `cast` gave for the mesh.
    """
    return (_of_chains if source.dimension == 2 else _of_planes)(patches, mesh, source)


def _of_chains(patches: Patches, mesh: Mesh, source: Simplices) -> Patches:
    """Those in the plane: edges in line from one vertex that stays to the next."""
    facets, guide = patches.facets, patches.guide
    n = len(facets)
    corner, edge = facets.ravel(), np.repeat(np.arange(n), 2)
    order = np.argsort(corner, kind="stable")
    corner, edge = corner[order], edge[order]
    # The two edges at a vertex, where there are two.
    first = np.flatnonzero(corner[1:] == corner[:-1])
    count = np.bincount(corner, minlength=len(guide))
    first = first[count[corner[first]] == 2]
    at, one, other = corner[first], edge[first], edge[first + 1]
    moves = guide[at, 0] == LINE
    patch = adjacency.first_of(n, one[moves], other[moves])
    curved = _curved(patches, patch, one, other, normals_of(patches.points, facets))
    whole = curved | _held(mesh, source, facets)
    return replace(patches, patch=patch, splits=~whole, whole=np.empty((0, 2), np.int64))


def _of_planes(patches: Patches, mesh: Mesh, source: Simplices) -> Patches:
    """Those in space: planes, whose ridges are split with them."""
    facets, patch, n_points = patches.facets, patches.patch, len(patches.points)
    edges, one, other, odd = sides_of_edges(facets, n_points)
    curved = _curved(patches, patch, one, other, normals_of(patches.points, facets))
    whole = curved | _held(mesh, source, facets)
    sides = adjacency.edges_of_triangles(facets)
    _, _, required = declared_among(mesh, "line", sides)
    # An edge of more than two facets cannot be split from one side.
    kept = required | (adjacency.places_in(odd, sides, n_points) >= 0)
    whole |= kept.reshape(-1, 3).any(axis=1)
    # Ridges between two patches that may be split are no more to be kept than edges within one.
    free = (patch[one] != patch[other]) & ~whole[one] & ~whole[other]
    stay = np.concatenate([source.edges, patches.ridges, sides[np.repeat(whole, 3)]])
    stay = stay[adjacency.places_in(edges[free], stay, n_points) < 0]
    guide = patches.guide.copy()
    guide[stay] = 0.0
    return replace(patches, guide=guide, splits=~whole, whole=stay)


def _curved(patches: Patches, patch: Array, one: Array, other: Array, normals: Array) -> Array:
    """Which facets, (n,) bool, are of patches without a vertex that may move, and bend gently.

    Parameters
    ----------
    one, other : (m,) int64
        Pairs of facets that meet.
    normals : (n, 3) float64
        Of the facets.
    """
    moves = np.zeros(len(patch), bool)
    moves[patch[(patches.guide[patches.facets, 0] > STAYS).any(axis=1)]] = True
    bend = np.linalg.norm(normals[one] - normals[other], axis=1)
    gently = (bend > patches.tolerance) & (bend < 2.0 * np.sin(GENTLE / 2.0))
    bends = np.zeros(len(patch), bool)
    bends[patch[one[gently]]] = bends[patch[other[gently]]] = True
    return (bends & ~moves)[patch]


def _held(mesh: Mesh, source: Simplices, facets: Array) -> Array:
    """Which facets, (n,) bool, the file requires or lists twice, or other cells of it match."""
    n_points = len(source.points)
    held = np.zeros(n_points, bool)
    for block in mesh.blocks:
        if block.type not in SIMPLICES:
            held[block.cells.ravel()] = True
    for link in mesh.periodic:
        held[link.pairs.ravel()] = True
    _, _, required = declared_among(mesh, source.facet_type, facets)
    found = held[facets].all(axis=1) | required
    for block in main_blocks(mesh, SIMPLICES[source.dimension]):
        if REQUIRED in block.data:
            rows = adjacency.facets(block.cells[flagged(block.data[REQUIRED])])
            found |= adjacency.places_in(rows, facets, n_points) >= 0
    return found
