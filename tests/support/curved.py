"""Meshes of second order, made of those of first order and seen by themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from meshopt_cli.mesh.model import Block

# The ends of the edge that each node after the corners is in the middle of, as VTK has them.
SIDES = {
    "line": [(0, 1)],
    "triangle": [(0, 1), (1, 2), (2, 0)],
    "tetra": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
}
ORDER_2 = {"line": "line3", "triangle": "triangle6", "tetra": "tetra10"}
ORDER_1 = {high: low for low, high in ORDER_2.items()}


def of_second_order(one, place=None, only=tuple(ORDER_2)):
    """The mesh with a node in the middle of each edge, after all of its points.

    Parameters
    ----------
    place : function of a mesh, edges (n, 2) and their middles (n, 2 or 3), optional
        How far the nodes are from half way.
    only : tuple of str
        Types of which cells are raised.
    """
    number = {}
    blocks = []
    for block in one.blocks:
        if block.type not in only or not len(block.cells):
            blocks.append(block)
            continue
        nodes = [
            [number.setdefault(tuple(sorted((cell[a], cell[b]))), len(number))
             for a, b in SIDES[block.type]]
            for cell in block.cells.tolist()
        ]  # fmt: skip
        cells = np.hstack([block.cells, len(one.points) + np.array(nodes)])
        blocks.append(replace(block, type=ORDER_2[block.type], cells=cells))
    edges = np.array(list(number))
    middles = one.points[edges].astype(float).mean(axis=1)
    if place is not None:
        middles += place(one, edges, middles)
    points = np.concatenate([one.points, middles.astype(one.points.dtype)])
    return replace(one, points=points, blocks=blocks, point_data={})


def corners_only(two):
    """The mesh of first order with the same corners, without the points in the middle of edges.

    Returns
    -------
    one : Mesh
    middles : dict of (int, int) to int
        The points of `two` in the middle of edges, by sorted points of `one`.
    """
    is_middle = np.zeros(len(two.points), bool)
    for block in two.blocks:
        if block.type in ORDER_1:
            low = ORDER_1[block.type]
            is_middle[block.cells[:, -len(SIDES[low]) :]] = True
    number = np.cumsum(~is_middle) - 1
    blocks, middles = [], {}
    for block in two.blocks:
        low = ORDER_1.get(block.type, block.type)
        cells = block.cells
        if block.type in ORDER_1:
            width = cells.shape[1] - len(SIDES[low])
            cells, nodes = number[cells[:, :width]], cells[:, width:]
            for k, (a, b) in enumerate(SIDES[low]):
                keys = np.sort(cells[:, [a, b]], axis=1).tolist()
                for key, node in zip(map(tuple, keys), nodes[:, k].tolist(), strict=True):
                    assert middles.setdefault(key, node) == node
        else:
            cells = number[cells]
        blocks.append(Block(low, cells, block.data, block.entities))
    assert len(set(middles.values())) == len(middles)
    point_data = {name: values[~is_middle] for name, values in two.point_data.items()}
    return replace(
        two, points=two.points[~is_middle], blocks=blocks, point_data=point_data
    ), middles


def middles_by_place(two):
    """The places of middle nodes by those of the ends of their edges."""
    one, middles = corners_only(two)
    places = [tuple(place) for place in one.points.tolist()]
    return {
        frozenset((places[a], places[b])): tuple(two.points[node].tolist())
        for (a, b), node in middles.items()
    }


def jacobians(two, n=9):
    """Jacobians of the main cells over what they would be for a straight cell, (ne, m).

    They are taken in a grid of n places a side of the cell, its corners and sides included.
    """
    kind = "tetra" if two.dimension() == 3 else "triangle"
    cells = np.concatenate(
        [b.cells for b in two.blocks if b.type == ORDER_2[kind] and len(b.cells)]
    )
    d = 3 if kind == "tetra" else 2
    grid = np.stack(np.meshgrid(*[np.arange(n)] * d, indexing="ij"), -1).reshape(-1, d) / (n - 1)
    grid = grid[grid.sum(axis=1) <= 1 + 1e-12]
    share = np.column_stack([1 - grid.sum(axis=1), grid])
    slope = np.vstack([-np.ones(d), np.eye(d)])  # of the barycentric coordinates
    parts = [(4 * share[:, k, None] - 1) * slope[k] for k in range(d + 1)]
    parts += [4 * (share[:, a, None] * slope[b] + share[:, b, None] * slope[a])
              for a, b in SIDES[kind]]  # fmt: skip
    slopes = np.stack(parts, axis=1)  # (m, nodes, d)
    nodes = two.points[cells][..., :d].astype(float)
    edges = nodes[:, 1 : d + 1] - nodes[:, :1]
    return np.linalg.det(np.einsum("mkd,nkx->nmdx", slopes, nodes)) / np.linalg.det(edges)[:, None]


def disc(n):
    """Triangles that fill a disc: the corners of `hexagon(n)` moved out to circles."""
    from support.meshes import hexagon

    one = hexagon(n)
    x, y = one.points.T
    ring = np.max(np.abs([y / np.sqrt(0.75), x + y / np.sqrt(3), x - y / np.sqrt(3)]), axis=0)
    length = np.hypot(x, y)
    one.points *= np.where(length > 0, ring / np.where(length > 0, length, 1), 1)[:, None] / n
    return one


def on_circle(one, edges, middles):
    """The way to the unit circle, or sphere, from the middles of edges of the boundary."""
    length = np.linalg.norm(middles, axis=1)[:, None]
    length[~is_on_boundary(one, edges)] = 1.0
    return middles / length - middles


def bulging(amount, chosen=None):
    """Middles of edges of the boundary are off by this part of their length, away from 0.

    Parameters
    ----------
    chosen : function of middles, (n, 2 or 3), to (n,) bool, optional
        Which edges are curved instead, inside of the mesh too.
    """

    def place(one, edges, middles):
        wanted = is_on_boundary(one, edges) if chosen is None else chosen(middles)
        length = np.linalg.norm(np.diff(one.points[edges], axis=1)[:, 0], axis=1)
        away = middles / np.maximum(np.linalg.norm(middles, axis=1), 1e-300)[:, None]
        return amount * (wanted * length)[:, None] * away

    return place


def is_on_boundary(one, edges):
    """Whether edges, sorted pairs, are sides of facets that have one cell, (n,) bool."""
    known = set(map(tuple, boundary_edges(one).tolist()))
    return np.array([tuple(edge) in known for edge in edges.tolist()])


def boundary_edges(one):
    """The edges of facets that have one cell, as sorted pairs."""
    kind = "tetra" if one.dimension() == 3 else "triangle"
    cells = np.concatenate([b.cells for b in one.blocks if b.type == kind])
    facets = np.concatenate([np.delete(cells, k, axis=1) for k in range(cells.shape[1])])
    rows, times = np.unique(np.sort(facets, axis=1), axis=0, return_counts=True)
    rows = rows[times == 1]
    pairs = [rows[:, [a, b]] for b in range(rows.shape[1]) for a in range(b)]
    return np.unique(np.concatenate(pairs), axis=0)


def rim(two):
    """The places of the middle nodes on the boundary, by those of the ends of their edges."""
    one, middles = corners_only(two)
    return {
        frozenset((tuple(one.points[a].tolist()), tuple(one.points[b].tolist()))): tuple(
            two.points[middles[a, b]].tolist()
        )
        for a, b in boundary_edges(one).tolist()
    }


def renumbered(two, seed):
    """The mesh with its points in another order."""
    order = np.random.default_rng(seed).permutation(len(two.points))
    rank = np.argsort(order)
    blocks = [replace(b, cells=rank[b.cells]) for b in two.blocks]
    point_data = {name: values[order] for name, values in two.point_data.items()}
    return replace(two, points=two.points[order], blocks=blocks, point_data=point_data)
