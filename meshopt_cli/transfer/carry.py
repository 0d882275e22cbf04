"""Arrays of the input on the cells and vertices of the result.

A point that moved or is new takes its value from the interpolation of the input: linear (P1), or
quadratic (P2) in cells of second order. A new cell takes the value of the input's cell that holds
its centre. Both are found by point location (18.1.3) inside the region; what did not change keeps
every bit.

Numbers of points and cells stay unique: what is new gets those beyond the greatest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from ..cells import dimension_of
from ..mesh.cast import Simplices
from ..mesh.model import Array, Block, Mesh, main_blocks, main_type, top_blocks
from ..mesh.plane import with_depth
from ..mesh.tags import (
    ALONG,
    CORNER,
    DIM_TAGS,
    FLAGS,
    GEOMETRICAL,
    HELD,
    LIMIT,
    METRIC,
    NORMAL,
    PARAMETRIC,
    REF,
    REQUIRED,
    SET,
    TAG_NAMES,
    TANGENT,
    WITHIN,
    is_identity,
    numbered,
    regions_of,
)
from .places import cells_at

# What goes with the vertex, not with the place, and what a new vertex gets.
VERTEX_TAGS = {REF: 0, DIM_TAGS: 0, CORNER: 0, REQUIRED: 0, NORMAL: np.nan, TANGENT: np.nan}
VERTEX_TAGS |= {PARAMETRIC: np.nan, HELD: 0, ALONG: 0, WITHIN: 0, LIMIT: 0}


def _goes_with_vertex(name: str) -> bool:
    return name in VERTEX_TAGS or name.startswith(SET)


# Nodes of the input, and the share of each, that make the value in a place of a cell: from the
# corners of cells, (n, d + 1) int64, and barycentric coordinates in them.
Interpolation = Callable[[Array, Array], tuple[Array, Array]]


def linear(cells: Array, weights: Array) -> tuple[Array, Array]:
    """The interpolation between the vertices of a simplex (P1)."""
    return cells, weights


def tags_only(mesh: Mesh, regions: tuple[str, ...]) -> Mesh:
    """The mesh without any arrays but tags: those that make regions, and those of formats."""
    tags = {*TAG_NAMES, *FLAGS, *regions}
    point_data = {
        n: values for n, values in mesh.point_data.items() if n == METRIC or _goes_with_vertex(n)
    }
    blocks = [
        replace(block, data={n: a for n, a in block.data.items() if n in tags or n.startswith(SET)})
        for block in mesh.blocks
    ]
    return replace(mesh, point_data=point_data, blocks=blocks, fields={})


def carry_on_cells(
    mesh: Mesh, result: Mesh, before: Simplices, origin: Array
) -> tuple[Mesh, list[str]]:
    """Give the cells of a result the arrays of the mesh that it was made from.

    Parameters
    ----------
    mesh : Mesh
        What was read, by its corners.
    result : Mesh
        What `with_simplices` made of it, with the tags that make regions.
    before : Simplices
        What `cast` gives for `mesh`.
    origin : (np',) int64
        The point of `mesh` that each point of `result` was, -1 for a new one.

    Returns
    -------
    mesh : Mesh
        With all arrays on cells, in their order.
    dropped : list of str
        Arrays without a meaning on the result: of something else than numbers, or of
        whole numbers on a part of the cells of a region.
    """
    blocks, dropped = _carry_cell_data(mesh, result, before, _Cells(result), origin)
    return replace(result, blocks=blocks), dropped


def carry_on_points(
    mesh: Mesh,
    result: Mesh,
    before: Simplices,
    origin: Array,
    interpolation: Interpolation = linear,
) -> tuple[Mesh, list[str]]:
    """Give the points of a result the arrays of the mesh that it was made from.

    Parameters
    ----------
    mesh, result : Mesh
        Of any order: what was read, and what is to be written.
    before : Simplices
        What `cast` gives for `mesh` by its corners.
    origin : (np',) int64
        The point of `mesh` that each point of `result` was, -1 for a new one.
    interpolation : function
        Gives points of `mesh`.

    Returns
    -------
    mesh : Mesh
        With all arrays on points, in their order; integers come from the nearest one.
    dropped : list of str
        Arrays of something else than numbers.
    """
    dropped = [n for n, values in mesh.point_data.items() if values.dtype.kind not in "fiub"]
    names = [name for name in mesh.point_data if name not in dropped]
    carried = {name: mesh.point_data[name][origin] for name in names}
    for name in names:
        if _goes_with_vertex(name):
            carried[name][origin < 0] = VERTEX_TAGS.get(name, 0)
    if PARAMETRIC in carried:  # true of the place that a point was in
        carried[PARAMETRIC][_is_moved(mesh, result, origin)] = np.nan
    fields = [name for name in names if not _goes_with_vertex(name)]
    if fields:
        rows, nodes, shares = _sources(mesh, result, before, origin, interpolation)
        nearest = np.take_along_axis(nodes, shares.argmax(axis=1)[:, None], axis=1)[:, 0]
    for name in fields:
        values = mesh.point_data[name]
        if is_identity(name, values):
            carried[name] = numbered(carried[name], origin < 0, values)
        elif values.dtype.kind == "f":
            at_nodes = values[nodes].astype(np.float64)
            carried[name][rows] = np.einsum("ij,ij...->i...", shares, at_nodes)
        else:
            carried[name][rows] = values[nearest]
    if DIM_TAGS in carried:
        _classify(carried[DIM_TAGS], np.flatnonzero(origin < 0), result)
    return replace(result, point_data=carried), dropped


class _Cells:
    """The cells of a result, in the order of its blocks, and their regions, once wanted."""

    def __init__(self, result: Mesh) -> None:
        self._blocks = top_blocks(result)
        self._regions = result.regions

    @cached_property
    def cells(self) -> Array:
        return np.concatenate([block.cells for block in self._blocks])

    @cached_property
    def region(self) -> Array:
        return regions_of(self._blocks, self._regions)


def _is_moved(mesh: Mesh, result: Mesh, origin: Array) -> Array:
    """Whether each point of a result is new or lies elsewhere than in the input."""
    moved = origin < 0
    moved[~moved] = np.any(result.points[~moved] != mesh.points[origin[~moved]], axis=1)
    return moved


def _sources(
    mesh: Mesh, result: Mesh, before: Simplices, origin: Array, interpolation: Interpolation
) -> tuple[Array, Array, Array]:
    """The points of a result that take new values, and from which nodes, in which shares."""
    after = _Cells(result)
    moved = _is_moved(mesh, result, origin)
    region = np.zeros(len(moved), np.int64)
    region[after.cells.ravel()] = np.repeat(after.region, after.cells.shape[1])
    used = np.zeros(len(moved), bool)
    used[after.cells] = True
    rows = np.flatnonzero(moved & used)
    found, weights = cells_at(before, _places(before, result, rows), region[rows])
    nodes, shares = interpolation(before.cells[found], weights)
    return rows, nodes, shares


def _places(before: Simplices, result: Mesh, rows: Array) -> Array:
    """Points of a result where `before` has its own: in its plane, if it has one."""
    points = with_depth(result.points[rows])
    return points if before.frame is None else before.frame.flatten(points)


def _carry_cell_data(
    mesh: Mesh, result: Mesh, before: Simplices, after: _Cells, origin: Array
) -> tuple[list[Block], list[str]]:
    cell_type = main_type(mesh)
    old_blocks, new_blocks = main_blocks(mesh, cell_type), main_blocks(result, cell_type)
    names = dict.fromkeys(name for block in old_blocks for name in block.data)
    waiting = [n for n in names if any(n not in block.data for block in new_blocks)]
    if not waiting:
        return result.blocks, []
    twins, donors = _donors(mesh, result, before, after, origin)
    data: list[dict[str, Array]] = [dict(block.data) for block in new_blocks]
    ends = np.cumsum([len(block.cells) for block in new_blocks])
    parts = [slice(e - len(b.cells), e) for e, b in zip(ends, new_blocks, strict=True)]
    dropped = []
    for name in waiting:
        values, here = _joined(old_blocks, name)
        if values is None or not all(
            values.dtype.kind == "f" or here[donors[part]].all() or not here[donors[part]].any()
            for part in parts
        ):
            dropped.append(name)
            continue
        there, carried = here[donors], values[donors]
        if is_identity(name, values[here]):
            taken = [block.data[name] for block in mesh.blocks if name in block.data]
            carried = numbered(values[twins], there & (twins < 0), *taken)
        for own, part in zip(data, parts, strict=True):
            if there[part].any():
                own[name] = carried[part]
    ordered = iter({n: own[n] for n in names if n in own} for own in data)
    blocks = [
        replace(b, data=next(ordered)) if b.type == cell_type and len(b.cells) else b
        for b in result.blocks
    ]
    return blocks, dropped


def _joined(blocks: list[Block], name: str) -> tuple[Array | None, Array]:
    """An array over all blocks, NaN where it is not, and where it is.

    It is None where the blocks do not agree on its shape, or it is not of numbers.
    """
    here = np.concatenate([np.full(len(b.cells), name in b.data) for b in blocks])
    some = [block.data[name] for block in blocks if name in block.data]
    if len({a.shape[1:] for a in some}) != 1 or any(a.dtype.kind not in "fiub" for a in some):
        return None, here
    kind = np.result_type(*some)
    values = np.full((len(here), *some[0].shape[1:]), np.nan if kind.kind == "f" else 0, kind)
    values[here] = np.concatenate(some)
    return values, here


def _donors(
    mesh: Mesh, result: Mesh, before: Simplices, after: _Cells, origin: Array
) -> tuple[Array, Array]:
    """The cells of the input that those of a result were, and take their values from, (ne',).

    A cell with the vertices of one of the input is that one, -1 where there is none. Where they
    did not move it takes its values from there, any other from the cell that holds its centre.
    """
    twins = np.full(len(after.cells), -1)
    known = np.flatnonzero((origin[after.cells] >= 0).all(axis=1))
    twins[known] = _twins(before.cells, origin[after.cells[known]])
    donors = np.where(_is_moved(mesh, result, origin)[after.cells].any(axis=1), -1, twins)
    rows = np.flatnonzero(donors < 0)
    corners = _places(before, result, after.cells[rows].ravel())
    centres = corners.reshape(len(rows), after.cells.shape[1], 3).mean(axis=1)
    donors[rows], _ = cells_at(before, centres, after.region[rows])
    return twins, donors


def _twins(cells: Array, wanted: Array) -> Array:
    """The cell with the same vertices as each wanted one, -1 where there is none."""
    # Cells are told apart by the sum of a random number for each vertex, and then looked at.
    number = np.random.default_rng(0).integers(2**62, size=int(cells.max(initial=0)) + 1)
    keys = number[cells].sum(axis=1)
    order = np.argsort(keys)
    at = np.searchsorted(keys, number[wanted].sum(axis=1), sorter=order)
    twins = order[np.minimum(at, len(order) - 1)]
    alike = np.all(np.sort(cells[twins], axis=1) == np.sort(wanted, axis=1), axis=1)
    return np.where(alike, twins, -1)


def _classify(dim_tags: Array, new: Array, result: Mesh) -> None:
    """Put new points on the entities of the cells they belong to, where Gmsh's are known.

    Of several, on the entity of the lowest dimension.
    """
    is_new = np.zeros(len(dim_tags), bool)
    is_new[new] = True
    for block in sorted(result.blocks, key=lambda block: -dimension_of(block.type)):
        if GEOMETRICAL in block.data and len(block.cells):
            here = is_new[block.cells]
            tags = np.repeat(block.data[GEOMETRICAL][:, None], block.cells.shape[1], axis=1)
            dim_tags[block.cells[here], 0] = dimension_of(block.type)
            dim_tags[block.cells[here], 1] = tags[here]
