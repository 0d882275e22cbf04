"""The cells and points that `check` complains of, as a mesh to look at."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .. import formats
from ..formats import Source
from ..mesh.adjacency import distinct
from ..mesh.model import Array, Block, Mesh
from ..mesh.plane import with_depth
from ..mesh.tags import OWN
from ..validity import Group, Report

# Names of the arrays; each code has one of its own besides.
CODE, CELL, POINT = f"{OWN}code", f"{OWN}cell", f"{OWN}point"


def write_marks(path: Path, source: Source, mesh: Mesh, report: Report) -> None:
    """Write the cells that have a part in a finding, and the points as cells of type vertex.

    Cells with vertices that do not exist, and points that are nowhere, cannot be shown.

    Raises
    ------
    WriteError
        The file cannot be written, or its extension is unknown.
    """
    encoding = formats.encoding_for(path)
    marked = marks(mesh, report)
    formats.write(path, marked, encoding)


def marks(mesh: Mesh, report: Report) -> Mesh:
    """The marked mesh: `meshopt:code` is the number of the first rule that each cell breaks.

    An array named like the code tells for each rule which cells break it; `meshopt:cell` is
    the row of the cell in its block, -1 for points; `meshopt:point` the row of the point.
    """
    points = with_depth(mesh.points) if mesh.points.shape[1] < 3 else mesh.points
    finite = np.isfinite(points).all(axis=1)
    broken = [
        {code: _cells(report, code, number) for code in report.codes}
        for number in range(len(mesh.blocks))
    ]
    blocks = []
    for block, by_code in zip(mesh.blocks, broken, strict=True):
        rows = distinct(np.concatenate([np.empty(0, np.int64), *by_code.values()]))
        cells = block.cells[rows]
        inside = (cells >= 0) & (cells < len(points))
        sound = inside.all(axis=1)
        sound[sound] = finite[cells[sound]].all(axis=1)
        rows = rows[sound]
        if len(rows):
            data = _arrays({code: np.isin(rows, own) for code, own in by_code.items()})
            data |= {CELL: rows, POINT: np.full(len(rows), -1)}
            blocks.append(Block(block.type, block.cells[rows], data))
    by_code = {group.code: _points(group) for group in report.groups}
    tips = distinct(np.concatenate([np.empty(0, np.int64), *by_code.values()]))
    tips = tips[finite[tips]]
    if len(tips):
        data = _arrays({code: np.isin(tips, own) for code, own in by_code.items()})
        data |= {CELL: np.full(len(tips), -1), POINT: tips}
        blocks.append(Block("vertex", tips[:, None], data))
    used = distinct(np.concatenate([np.empty(0, np.int64), *(b.cells.ravel() for b in blocks)]))
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    for block in blocks:
        block.cells = number[block.cells]
    return Mesh(np.ascontiguousarray(points[used]), blocks)


def _cells(report: Report, code: str, block: int) -> Array:
    """Rows of a block that have a part in what breaks a rule."""
    places = next(group.places for group in report.groups if group.code == code)
    found = [np.empty((0, 2), np.int64)]
    found += [cells.reshape(-1, 2) for cells in (places.cells, places.other_cells)
              if cells is not None]  # fmt: skip
    cells = np.concatenate(found)
    return cells[cells[:, 0] == block, 1]


def _points(group: Group) -> Array:
    """Points that have a part in what breaks a rule."""
    found = [np.empty(0, np.int64)]
    found += [points.ravel() for points in (group.places.points, group.places.other_points)
              if points is not None]  # fmt: skip
    points = np.concatenate(found)
    return points[points >= 0]


def _arrays(masks: dict[str, Array]) -> dict[str, Array]:
    data = {code: mask.astype(np.int64) for code, mask in masks.items()}
    numbers = [np.where(mask, int(code[1:]), 1000) for code, mask in masks.items()]
    return {CODE: np.min(numbers, axis=0), **data}
