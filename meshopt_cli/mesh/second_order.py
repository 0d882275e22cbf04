"""Simplices of second order: taken apart into corners and middle nodes, and put together again.

Cells are worked on by their corners. An edge that is still there afterwards, between the same ends
in the same places, has its middle node as it was, bit for bit, curved or not; any other gets a node
half way between its ends. So that no curved edge is lost, those are declared, with their ends.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..cells import SIMPLICES, dimension_of, family_of
from ..elements import ELEMENTS
from . import adjacency
from .curved import Edges, curved_edges
from .model import Array, Block, Mesh, declared, top_blocks
from .periodic import renumbered
from .tags import REQUIRED, STAY, flagged

# Simplices of second order, by the type of first order: as a file calls them.
OF_SECOND_ORDER = {"line": "line3", "triangle": "triangle6", "tetra": "tetra10"}

# The edge, by its ends, that each node after the corners is in the middle of.
MIDDLES: dict[str, Array] = {
    "line3": np.array([[0, 1]]),
    **{name: np.array(ELEMENTS[name].middles) for name in ("triangle6", "tetra10")},
}


class Restored(NamedTuple):
    """A mesh of second order after the work.

    Attributes
    ----------
    mesh : Mesh
        Without arrays on points.
    origin : (np',) int64
        The point of the input that each point was, -1 for a new one.
    """

    mesh: Mesh
    origin: Array


@dataclass(frozen=True)
class SecondOrder:
    """A mesh of second order, taken apart.

    Attributes
    ----------
    mesh : Mesh
        As it was.
    linear : Mesh
        By its corners, with no points but those that are no middle nodes; what must not change is
        declared in blocks after its own.
    points : (np',) int64
        The point of `mesh` that each point of `linear` is, ascending.
    edges : Edges
        Ends in points of `linear`, nodes in points of `mesh`.
    curved : (np,) bool
        Which points of `mesh` are the middle nodes of curved edges.
    n_inner : int
        How many curved edges are inside of the mesh and not declared.
    attached : tuple of (n,) bool
        Which cells of each block of `mesh` are not in `linear`: those of lower dimension that
        have a middle node of others where a cell of first order has a vertex.
    """

    mesh: Mesh
    linear: Mesh
    points: Array
    edges: Edges
    curved: Array
    n_inner: int
    attached: tuple[Array, ...]

    def interpolation(self, cells: Array, weights: Array) -> tuple[Array, Array]:
        """Nodes of the input and their shares in places of its cells (quadratic interpolation).

        Parameters
        ----------
        cells : (n, d + 1) int64
            Corners of cells of `linear`.
        weights : (n, d + 1) float64
            Barycentric coordinates in them.

        Returns
        -------
        nodes, shares : (n, k)
        """
        cell_type = OF_SECOND_ORDER[SIMPLICES[cells.shape[1] - 1]]
        ends = cells[:, MIDDLES[cell_type]]
        middles = self._nodes_of(ends.reshape(-1, 2)).reshape(ends.shape[:2])
        shares = ELEMENTS[cell_type].values(weights[:, 1:])
        return np.hstack([self.points[cells], middles]), shares

    def _nodes_of(self, ends: Array) -> Array:
        """The middle nodes of some edges of `linear`, -1 where there is no such edge."""
        place = adjacency.places_in(self.edges.ends, ends, len(self.points))
        return np.where(place >= 0, self.edges.nodes[place], -1)

    def cells_with(self, nodes: Array) -> Array:
        """Which main cells have some of these points of `mesh` as nodes, (ne,) bool."""
        wanted = np.zeros(len(self.mesh.points), bool)
        wanted[nodes] = True
        return wanted[np.concatenate([b.cells for b in top_blocks(self.mesh)])].any(axis=1)

    def restored(self, result: Mesh, origin: Array) -> Restored:
        """Put the middle nodes back.

        Parameters
        ----------
        result : Mesh
            What was made of `linear`.
        origin : (np',) int64
            The point of `linear` that each point of `result` was, -1 for a new one.
        """
        olds = self._former(result)
        typed = [replace(b, type=old.type) for b, old in zip(result.blocks, olds, strict=False)]
        blocks, ends = _with_middles(typed, len(origin))
        node, middles = self._middles(result.points, ends, origin)
        was = np.concatenate([np.where(origin < 0, -1, self.points[origin]), node])
        # The points of the input in their order, then the new ones.
        order = np.argsort(np.where(was < 0, len(self.mesh.points), was), kind="stable")
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        points, was = np.concatenate([result.points, middles])[order], was[order]
        number = np.full(len(self.mesh.points), -1)
        number[was[was >= 0]] = np.flatnonzero(was >= 0)
        blocks = [
            self._with_attached(replace(b, cells=rank[b.cells]), old, number)
            for b, old in zip(blocks, olds, strict=True)
        ]
        periodic = renumbered(self.mesh.periodic, number)
        return Restored(replace(result, points=points, blocks=blocks, periodic=periodic), was)

    def _former(self, result: Mesh) -> list[Block]:
        """The block of `mesh` that each of a result was; of main cells, any of their type."""
        main = SIMPLICES[self.mesh.dimension()]
        lower = iter([b for b in self.mesh.blocks if not _is_main(b, OF_SECOND_ORDER[main])])
        n_added = len(self.linear.blocks) - len(self.mesh.blocks)
        some = top_blocks(self.mesh)[0]
        return [
            some if _is_main(block, main) else next(lower)
            for block in result.blocks[: len(result.blocks) - n_added]
        ]

    def _with_attached(self, block: Block, old: Block, number: Array) -> Block:
        """A block of a result with the cells that are not in `linear`, as they were."""
        pairs = zip(self.mesh.blocks, self.attached, strict=True)
        rows = next(rows for one, rows in pairs if one is old)
        if not rows.any():
            return block
        old = replace(old, data={name: old.data[name] for name in block.data})
        if dimension_of(old.type) < self.mesh.dimension() - 1:  # others are none of its facets
            return _kept(old, number)
        more = _kept(_chosen(old, rows), number)
        data = {n: np.concatenate([values, more.data[n]]) for n, values in block.data.items()}
        return replace(block, cells=np.concatenate([block.cells, more.cells]), data=data)

    def _middles(self, points: Array, ends: Array, origin: Array) -> tuple[Array, Array]:
        """What the middle nodes of edges of a result were, -1 for new ones, and where they are."""
        was = origin[ends]
        node = np.where((was >= 0).all(axis=1), self._nodes_of(np.maximum(was, 0)), -1)
        middles = points[ends].astype(np.float64).mean(axis=1).astype(points.dtype)
        moved = (points[ends] != self.linear.points[was]).any(axis=(1, 2))
        stays = (node >= 0) & ~moved
        middles[stays] = self.mesh.points[node[stays]]
        return node, middles


def is_second_order(mesh: Mesh) -> bool:
    """Whether the main cells are triangles or tetrahedra of second order, all of them."""
    return mesh.dimension() >= 2 and all(b.type in MIDDLES for b in top_blocks(mesh))


def has_known_nodes(cell_type: str) -> bool:
    """Whether it is known where the nodes of a type are: of first or second order."""
    return cell_type in ELEMENTS or cell_type in MIDDLES or cell_type in SIMPLICES


def taken_in_order(cell_type: str, corners: list[int]) -> list[int]:
    """The nodes of a cell of first or second order whose corners are taken in another order."""
    if cell_type in MIDDLES:
        middles = [tuple(ends) for ends in MIDDLES[cell_type].tolist()]
    else:
        middles = list(ELEMENTS[cell_type].middles) if cell_type in ELEMENTS else []
    of = [frozenset(middle) for middle in middles]
    taken = [frozenset(corners[corner] for corner in middle) for middle in middles]
    return [*corners, *(len(corners) + of.index(middle) for middle in taken)]


def by_corners(mesh: Mesh) -> Mesh:
    """The mesh with its simplices of second order as those of first order, and all its points."""
    return replace(mesh, blocks=[_linear(block) for block in mesh.blocks])


def separated(mesh: Mesh, frozen: Array | None = None) -> SecondOrder:
    """Take a mesh of second order apart.

    Its main cells are of second order; those below may be of either. An edge has one middle node,
    which is no vertex of another cell.

    Parameters
    ----------
    frozen : (ne,) bool, optional
        Main cells that must not change at all.
    """
    attached = _attached(mesh)
    ends, nodes = _edges_of(mesh, attached)
    is_middle = np.zeros(len(mesh.points), bool)
    is_middle[nodes] = True
    points = np.flatnonzero(~is_middle)
    number = np.full(len(mesh.points), -1)
    number[points] = np.arange(len(points))
    edges = Edges(number[ends], nodes)
    blocks = [
        _kept(_linear(_chosen(block, ~rows)), number)
        for block, rows in zip(mesh.blocks, attached, strict=True)
    ]
    held = _held_by(mesh, attached)
    point_data = {name: values[points] for name, values in mesh.point_data.items()}
    point_data[REQUIRED] = (held | _flagged(mesh, REQUIRED))[points].astype(np.uint8)
    linear = replace(mesh, points=mesh.points[points], blocks=blocks, point_data=point_data)
    linear = replace(linear, periodic=renumbered(mesh.periodic, number), numbers=None)
    found = curved_edges(mesh, linear, edges)
    curved = np.zeros(len(mesh.points), bool)
    curved[nodes[found.edges]] = True
    kept = found.inner | (held | _declared_nodes(mesh))[nodes]
    added = _added(linear, edges.ends[kept], found.facets, frozen)
    linear = replace(linear, blocks=[*blocks, *added])
    n_inner = int(np.count_nonzero(found.inner))
    return SecondOrder(mesh, linear, points, edges, curved, n_inner, attached)


def _attached(mesh: Mesh) -> tuple[Array, ...]:
    """See `SecondOrder.attached`."""
    middle = np.zeros(len(mesh.points), bool)
    for block in mesh.blocks:
        if block.type in MIDDLES:
            middle[_middle_nodes(block)] = True
    return tuple(
        middle[_linear(block).cells].any(axis=1) & (dimension_of(block.type) < mesh.dimension())
        for block in mesh.blocks
    )


def _held_by(mesh: Mesh, attached: tuple[Array, ...]) -> Array:
    """Points that cells of lower dimension have which are not in the mesh by corners, (np,) bool.

    Vertices are none of these cells.
    """
    held = np.zeros(len(mesh.points), bool)
    for block, rows in zip(mesh.blocks, attached, strict=True):
        if block.type != SIMPLICES[0]:
            held[block.cells[rows]] = True
    return held


def _flagged(mesh: Mesh, name: str) -> Array:
    """Where an array on points is set; nowhere without it."""
    values = mesh.point_data.get(name)
    return np.zeros(len(mesh.points), bool) if values is None else flagged(values)


def _chosen(block: Block, rows: Array) -> Block:
    """Some cells of a block, by a mask."""
    data = {name: values[rows] for name, values in block.data.items()}
    return replace(block, cells=block.cells[rows], data=data, numbers=None)


def _linear(block: Block) -> Block:
    """A block by its corners, if it is of second order."""
    family = family_of(block.type)
    if block.type not in MIDDLES or family is None:
        return block
    cells = np.ascontiguousarray(block.cells[:, : family.n_corners])
    return replace(block, type=family.name, cells=cells)


def _kept(block: Block, number: Array) -> Block:
    """A block with other numbers of points, without the cells that have a -1."""
    cells = number[block.cells]
    return _chosen(replace(block, cells=cells), (cells >= 0).all(axis=1))


def _is_main(block: Block, cell_type: str) -> bool:
    return block.type == cell_type and len(block.cells) > 0


def _ends(block: Block) -> Array:
    """Ends of the edges of cells of second order, (n, k, 2)."""
    return block.cells[:, MIDDLES[block.type]]


def _with_middles(blocks: list[Block], first: int) -> tuple[list[Block], Array]:
    """Blocks with nodes in the middle of their edges, from a number on, and the ends of these.

    Cells of types of second order are given by their corners.
    """
    of_block = [_ends(b) if b.type in MIDDLES else np.empty((0, 0, 2), np.int64) for b in blocks]
    every = np.concatenate([ends.reshape(-1, 2) for ends in of_block])
    distinct, number, _ = adjacency.distinct_rows(np.sort(every, axis=1))
    stops = np.cumsum([ends[..., 0].size for ends in of_block])
    parts = np.split(first + number, stops[:-1])
    rows = [
        np.hstack([b.cells, part.reshape(ends.shape[:2])]) if b.type in MIDDLES else b.cells
        for b, ends, part in zip(blocks, of_block, parts, strict=True)
    ]
    return [replace(b, cells=cells) for b, cells in zip(blocks, rows, strict=True)], distinct


def _edges_of(mesh: Mesh, attached: tuple[Array, ...]) -> Edges:
    """Every edge that has a middle node, once; those of attached cells left out."""
    pairs = zip(mesh.blocks, attached, strict=True)
    blocks = [_chosen(block, ~rows) for block, rows in pairs if block.type in MIDDLES]
    ends = np.concatenate([_ends(b).reshape(-1, 2) for b in blocks])
    nodes = np.concatenate([_middle_nodes(b).ravel() for b in blocks])
    ends = np.sort(ends, axis=1)
    order = np.argsort(adjacency.row_keys(ends, len(mesh.points)), kind="stable")
    ends, nodes = ends[order], nodes[order]
    is_new = np.ones(len(ends), bool)
    is_new[1:] = (ends[1:] != ends[:-1]).any(axis=1)
    return Edges(ends[is_new], nodes[is_new])


def _middle_nodes(block: Block) -> Array:
    """The middle nodes of cells of second order, (n, k)."""
    return block.cells[:, -len(MIDDLES[block.type]) :]


def _declared_nodes(mesh: Mesh) -> Array:
    """Which points are declared as vertices, or flagged as what must stay, (np,) bool."""
    nodes = np.zeros(len(mesh.points), bool)
    nodes[declared(mesh, SIMPLICES[0])] = True
    used = np.zeros(len(mesh.points), bool)
    for block in top_blocks(mesh):
        used[block.cells] = True
    if nodes[used].all():  # a file that declares every node says nothing by it
        nodes[:] = False
    return np.logical_or.reduce([nodes, *(_flagged(mesh, name) for name in STAY)])


def _added(linear: Mesh, edges: Array, facets: Array, frozen: Array | None) -> list[Block]:
    """Blocks that declare edges, facets, and the facets of cells, as such that must stay."""
    line, facet = SIMPLICES[1], SIMPLICES[linear.dimension() - 1]
    rows = [(line, edges), (facet, facets)]
    if frozen is not None:
        rows.append(
            (facet, adjacency.facets(declared(linear, SIMPLICES[linear.dimension()])[frozen]))
        )
    blocks = []
    for kind in dict.fromkeys((line, facet)):
        cells = np.concatenate([np.sort(more, axis=1) for of, more in rows if of == kind])
        cells = adjacency.distinct_rows(cells)[0]
        if len(cells):
            blocks.append(Block(kind, cells, {REQUIRED: np.ones(len(cells), np.uint8)}))
    return blocks
