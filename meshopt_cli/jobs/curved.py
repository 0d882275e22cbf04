"""Meshes of second order: which are taken, and what becomes of cells at curved edges."""

from __future__ import annotations

import logging

import numpy as np

from .. import validity
from ..errors import BadMeshError, UnsupportedMeshError
from ..mesh import adjacency
from ..mesh.cast import Simplices
from ..mesh.model import Array, Block, Mesh, top_blocks
from ..mesh.plane import flatness, precision_of, with_depth
from ..mesh.second_order import SecondOrder
from .admission import CURVED, InvalidMeshError

log = logging.getLogger("meshopt")


def require_plane(second: SecondOrder, part: Simplices) -> None:
    """Refuse triangles that lie in one plane by their corners only.

    Raises
    ------
    UnsupportedMeshError
        Their middle nodes lie outside of it.
    """
    if part.frame is None:
        return
    nodes = np.concatenate([b.cells.ravel() for b in top_blocks(second.mesh)])
    points = with_depth(second.mesh.points)[nodes]
    limit = flatness(points, precision_of(second.mesh.points)) * np.ptp(points, axis=0).max()
    # The plane may pass beside the origin of its frame.
    if np.ptp(points @ part.frame.axes[2]) > 2 * limit:
        raise UnsupportedMeshError(
            "the corners of the triangles lie in one plane, but not all of their middle nodes do: "
            "surfaces in space cannot be optimized here; meshopt check takes them"
        )


def warn_of_curved(second: SecondOrder) -> None:
    """Say which edges inside stay, because they are curved."""
    if second.n_inner:
        log.warning(
            "edges inside the mesh that are curved, and stay as they are with their ends: %d",
            second.n_inner,
        )


def to_be_kept(
    second: SecondOrder,
    result: Mesh,
    origin: Array,
    kept: Array | None,
    tangle: validity.Report | None,
) -> Array | None:
    """Which cells must stay as they were, lest a cell at a curved edge becomes invalid.

    Parameters
    ----------
    result : Mesh
        With its middle nodes.
    origin : (np',) int64
        The point of the input that each point of the result was, -1 for a new one.
    kept : (ne,) bool, optional
        Which cells of the input could not change in `result`.
    tangle : Report, optional
        What was wrong with the input, and to be mended.

    Returns
    -------
    (ne,) bool or None
        None where no cell of the result became invalid. Cells that were so are not kept.

    Raises
    ------
    InvalidMeshError
        Cells that were to be mended were not.
    BadMeshError
        All cells at curved edges were kept, and others are invalid all the same.
    """
    cells = _at_curved_edges(second, result, origin)
    cells = cells[_are_invalid(result, cells)]
    new = cells[~_were_there(second, result, origin, cells)]
    more = _more(second, origin[new], kept) if len(new) else None
    if tangle is not None and more is None and len(cells):
        raise InvalidMeshError(
            "cells at curved edges stay invalid: nothing written", second.mesh, tangle
        )
    if more is None and len(new):
        raise BadMeshError(
            f"cells at curved edges that would become invalid: {len(new)}; nothing written"
        )
    return more


def _more(second: SecondOrder, nodes: Array, kept: Array | None) -> Array | None:
    """The cells to be kept, after some with these nodes, in points of the input, are invalid.

    First those around the invalid ones, then all at curved edges; None where they are already.
    """
    every = np.concatenate([b.cells for b in top_blocks(second.mesh)])
    mine = nodes[(nodes >= 0) & second.curved[nodes]]
    near = second.cells_with(mine if kept is None else np.flatnonzero(second.curved))
    rows = np.flatnonzero(near)
    near[rows] = ~_are_invalid(second.mesh, every[rows])
    if kept is not None and kept[near].all():
        return None
    log.warning(
        "cells at curved edges that would become invalid: %d; the cells there stay as they are, "
        "and the mesh is optimized again", len(nodes),
    )  # fmt: skip
    return near


def _at_curved_edges(second: SecondOrder, result: Mesh, origin: Array) -> Array:
    """The cells with a curved edge, (n, k) int64: no others can be invalid."""
    curved = (origin >= 0) & second.curved[origin]
    return np.concatenate([b.cells[curved[b.cells].any(axis=1)] for b in top_blocks(result)])


def _are_invalid(mesh: Mesh, cells: Array) -> Array:
    """Which of some main cells have a Jacobian that is not positive, (n,) bool."""
    invalid = np.zeros(len(cells), bool)
    part = Mesh(mesh.points, [Block(top_blocks(mesh)[0].type, cells)])
    for group in validity.check(part, CURVED, overlaps=False).groups:
        if group.places.cells is not None:
            invalid[group.places.cells[:, 1]] = True
    return invalid


def _were_there(second: SecondOrder, result: Mesh, origin: Array, cells: Array) -> Array:
    """Which of some cells of a result the input had, with all nodes in the same places, (n,)."""
    was = origin[cells]
    same = (was >= 0) & (result.points[cells] == second.mesh.points[was]).all(axis=2)
    every = np.concatenate([b.cells for b in top_blocks(second.mesh)])
    every = every[second.cells_with(was[same])]
    _, number, _ = adjacency.distinct_rows(np.sort(np.concatenate([every, was]), axis=1))
    return same.all(axis=1) & np.isin(number[len(every) :], number[: len(every)])
