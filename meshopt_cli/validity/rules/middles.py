"""Middle nodes of cells that share an edge or a face: M106."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...elements import element_of
from ...mesh.adjacency import distinct_rows
from ...mesh.model import Array, Block, top_blocks
from ...mesh.second_order import MIDDLES
from ..examination import Examination
from ..model import ERROR, Places, at_cells, rule
from ..study import Study, n_corners

WIDEST = 4  # corners of an edge or a face that has a middle node


class _Middles(NamedTuple):
    """Middle nodes, a row for each that a cell has, in the order of the cells."""

    sides: Array  # (n, 4): corners of the edge or face, sorted, -1 where there are fewer
    nodes: Array
    owners: Array  # numbers of the cells


@rule(
    "M106",
    ERROR,
    "middle nodes do not match",
    explanation="Two cells have different middle nodes on a common edge or face, or a middle node "
    "belongs to something else too.",
    fix="Make nodes common where cells meet, or put the nodes in the order of the format.",
)
def find_mismatched(study: Examination) -> Places:
    middles = _middles(study)
    if not len(middles.nodes):
        return Places(())
    _, side, _ = distinct_rows(middles.sides)
    first_at_side = _first(side)[side]
    _, node = np.unique(middles.nodes, return_inverse=True)
    first_with_node = _first(node)[node]
    corner_of = _corners(study)[middles.nodes]
    rows = np.arange(len(side))
    kinds = np.select(
        [
            middles.nodes != middles.nodes[first_at_side],
            side != side[first_with_node],
            corner_of >= 0,
        ],
        [0, 1, 2],
        -1,
    )
    owners = middles.owners
    others = np.choose(
        np.maximum(kinds, 0), [owners[first_at_side], owners[first_with_node], corner_of]
    )
    found = rows[kinds >= 0]
    # One finding a cell: that of its first node.
    numbers, first = np.unique(owners[found], return_index=True)
    found = found[first]
    others = np.where(others[found] == numbers, -1, others[found])
    return at_cells(
        study,
        numbers,
        "another cell has another middle node on the same edge or face",
        "a middle node of the cell is that of another edge or face too",
        "a middle node of the cell is a corner of a cell too",
        kinds=kinds[found],
        others=others[:, None],
    )


def _first(group: Array) -> Array:
    """The first row of each group, by its number."""
    first = np.zeros(int(group.max(initial=-1)) + 1, np.int64)
    first[group[::-1]] = np.arange(len(group))[::-1]
    return first


def _middles(study: Study) -> _Middles:
    """All middle nodes of edges and faces."""
    parts = [_Middles(np.empty((0, WIDEST), np.int64), *[np.empty(0, np.int64)] * 2)]
    of_order = [block for block in study.mesh.blocks if _sides(block)]
    for cells, numbers, block in _sound(study, of_order):
        for place, corners in enumerate(_sides(block), n_corners(block)):
            sides = np.full((len(cells), WIDEST), -1)
            sides[:, : len(corners)] = np.sort(cells[:, list(corners)], axis=1)
            parts.append(_Middles(sides, cells[:, place], numbers))
    sides, nodes, owners = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(owners, kind="stable")
    return _Middles(sides[order], nodes[order], owners[order])


def _sides(block: Block) -> list[tuple[int, ...]]:
    """The corners that each node of an edge or a face is in the middle of, in order."""
    if block.type in MIDDLES:
        return [tuple(ends) for ends in MIDDLES[block.type].tolist()]
    element = element_of(block.type, np.shape(block.cells)[-1])
    middles = () if element is None else element.middles
    return [corners for corners in middles if len(corners) <= WIDEST]


def _corners(study: Study) -> Array:
    """A cell of the top dimension that each point is a corner of, (np,) int64; -1 without one.

    Cells of lower dimension may be attached to middle nodes.
    """
    corner_of = np.full(study.n_points, -1)
    for cells, numbers, block in _sound(study, top_blocks(study.mesh)):
        corner_of[cells[:, : n_corners(block)]] = numbers[:, None]
    return corner_of


def _sound(study: Study, blocks: list[Block]) -> list[tuple[Array, Array, Block]]:
    """Cells of some blocks whose vertices exist, their numbers, and their blocks."""
    found = []
    for block, first in zip(study.mesh.blocks, study.offsets, strict=False):
        if any(block is one for one in blocks):
            cells = np.asarray(block.cells)
            rows = np.flatnonzero(~study.out_of_range[first : first + len(cells)])
            found.append((cells[rows], first + rows, block))
    return found
