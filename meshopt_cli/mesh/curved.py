"""Curved edges of meshes of second order, and the facets of the boundary that have some."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..cells import SIMPLICES
from . import adjacency
from .model import Array, Mesh, declared, main_blocks, top_blocks
from .plane import precision_of, with_depth
from .sizes import norms
from .tags import regions_of

# An edge is straight when its middle node is no farther from the middle of its ends than this part
# of its length: on the boundary, whose shape must stay, and inside.
STRAIGHT = 1e-6, 1e-4


class Edges(NamedTuple):
    """Edges of a mesh: their ends, (n, 2) int64, sorted, and their middle nodes, (n,) int64."""

    ends: Array
    nodes: Array


class Curved(NamedTuple):
    """Which edges are curved, which of these inside, and facets of the boundary with such edges."""

    edges: Array
    inner: Array
    facets: Array


def curved_edges(mesh: Mesh, linear: Mesh, edges: Edges) -> Curved:
    """Find the curved edges, and the facets of the boundary that have some."""
    points = with_depth(linear.points)
    ends = points[edges.ends]
    off = norms(with_depth(mesh.points)[edges.nodes] - ends.mean(axis=1))
    noise = 4 * precision_of(mesh.points) * np.abs(points).max(initial=0.0)
    length = norms(ends[:, 1] - ends[:, 0])
    bent, much = (off > part * length + noise for part in STRAIGHT)
    at_bent = np.zeros(len(mesh.points), bool)
    at_bent[edges.nodes[bent]] = True
    facets = _boundary_at(mesh, linear, at_bent)
    in_space = facets.shape[1] == 3
    sides = adjacency.edges_of_triangles(facets) if in_space else facets
    own = adjacency.places_in(edges.ends, sides, len(points)).reshape(-1, 3 if in_space else 1)
    facets = facets[(bent[own] & (own >= 0)).any(axis=1)]
    outside = np.zeros(len(bent), bool)
    line = adjacency.places_in(edges.ends, declared(linear, SIMPLICES[1]), len(points))
    for rows in (own, line):
        outside[rows[rows >= 0]] = True
    return Curved(bent & (outside | much), bent & much & ~outside, facets)


def _boundary_at(mesh: Mesh, linear: Mesh, nodes: Array) -> Array:
    """Facets of the boundary and of interfaces that have some nodes, and others, (n, d) int64.

    They have all that the mask `nodes` of the points of `mesh` says, in points of `linear`.
    """
    dimension = mesh.dimension()
    blocks = main_blocks(linear, SIMPLICES[dimension])
    chosen = nodes[np.concatenate([b.cells for b in top_blocks(mesh)])].any(axis=1)
    cells = np.concatenate([b.cells for b in blocks])[chosen]
    region = regions_of(blocks, linear.regions)[chosen]
    facets = declared(linear, SIMPLICES[dimension - 1])
    # A facet with such a node has all its cells among the chosen ones.
    beyond = adjacency.neighbours(cells, region, len(linear.points), facets)
    return np.concatenate([adjacency.boundary_facets(cells, beyond), facets])
