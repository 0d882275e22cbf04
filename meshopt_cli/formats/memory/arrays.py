"""Points and cells as plain arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...mesh.model import Array, Block, Mesh
from ..sniff import UnreadableError

# The type of cells with so many vertices, where nobody says it; in a plane four make a quad.
BY_VERTICES = {2: "line", 3: "triangle", 4: "tetra", 5: "pyramid", 6: "wedge", 8: "hexahedron"}
BY_VERTICES |= {10: "tetra10"}
IN_A_PLANE = {4: "quad", 6: "triangle6"}


def fits(given: Any) -> bool:
    """Whether it is a pair of points and cells."""
    return isinstance(given, tuple | list) and len(given) == 2


def take(given: Any) -> tuple[Mesh, list[str]]:
    """A mesh that shares the arrays of a pair of points and cells."""
    points, cells = np.asarray(given[0]), given[1]
    if points.ndim != 2 or points.shape[1] not in (2, 3) or points.dtype.kind not in "fiu":
        raise UnreadableError(f"points have to be (n, 2) or (n, 3) numbers, not {points.shape}")
    width = points.shape[1]
    return Mesh(points, [Block(kind, rows) for kind, rows in _typed(cells, width)]), []


def back(mesh: Mesh, given: Any) -> tuple[Any, list[str]]:
    """A pair like the one that was given, of the points and cells of a mesh."""
    cells = given[1]
    pairs = [(block.type, block.cells) for block in mesh.blocks]
    if isinstance(cells, Mapping):
        found: dict[str, list[Array]] = {}
        for kind, rows in pairs:
            found.setdefault(kind, []).append(rows)
        made: Any = {kind: _joined(rows) for kind, rows in found.items()}
    elif isinstance(cells, np.ndarray):
        made = _joined([rows for _, rows in pairs])
    else:
        made = pairs
    return type(given)((mesh.points, made)), []


def _joined(rows: list[Array]) -> Array:
    return rows[0] if len(rows) == 1 else np.concatenate(rows)


def _typed(cells: Any, width: int) -> list[tuple[str, Array]]:
    """Cells with their types."""
    if isinstance(cells, Mapping):
        pairs = list(cells.items())
    elif isinstance(cells, np.ndarray) or not _are_pairs(cells):
        rows = np.asarray(cells)
        known = BY_VERTICES | IN_A_PLANE if width == 2 else BY_VERTICES
        if rows.ndim != 2 or rows.shape[1] not in known:
            raise UnreadableError(
                f"cells of shape {rows.shape} have no type: give (type, cells), such as "
                '[("tetra", cells)]'
            )
        pairs = [(known[rows.shape[1]], rows)]
    else:
        pairs = list(cells)
    return [(kind, _whole(kind, np.asarray(rows))) for kind, rows in pairs]


def _are_pairs(cells: Any) -> bool:
    return bool(len(cells)) and isinstance(cells[0], tuple | list) and isinstance(cells[0][0], str)


def _whole(kind: str, rows: Array) -> Array:
    if rows.dtype.kind not in "iu" and rows.size:
        raise UnreadableError(f"cells of type {kind} have to be of whole numbers")
    return rows
