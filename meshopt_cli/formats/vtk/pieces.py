"""Pieces of one mesh, put together: the points that they share are there once.

Points are the same where the file numbers them alike through all pieces, or else where they
agree in every bit of their coordinates. Points of one piece in one place stay apart.
"""

from __future__ import annotations

import numpy as np

from ...mesh.model import Array
from .cells import Cells, counted
from .dataset import MARKS, Dataset, marks_of, only

# Numbers of points through all pieces, by their name in small letters.
ALIASES = ("globalnodeid", "globalnodeids", "globalpointid", "globalpointids")
DUPLICATE = 1  # VTK's mark of a cell that another piece has too
_SAME_PLACE = 1e-5  # of the extent: points with one number are not farther apart


def join(pieces: list[Dataset], dropped: list[str]) -> Dataset:
    """Make one data set of pieces, and add to a list what does not go over.

    Ghosts, cells that another piece has too, are left out, with the points that no other cell
    has. Of a point that several pieces have, the values in the first of them count.
    """
    several = [piece for piece in pieces if len(piece.points)]
    if len(several) < 2:
        return several[0] if several else pieces[0]
    n_cells = sum(len(piece.cells.types) for piece in several)
    several = [_without_ghosts(piece) for piece in several]
    whole = _appended(several, dropped)
    if ghosts := n_cells - len(whole.cells.types):
        dropped.append(f"{counted(ghosts, 'ghost cell')}, which other pieces have")
    numbers = np.arange(len(several))
    piece_of = np.repeat(numbers, [len(piece.points) for piece in several])
    first = _first_alike(whole, piece_of)
    piece_of = np.repeat(numbers, [len(piece.cells.types) for piece in several])
    again = _cells_again(whole, first, piece_of)
    if again.any():
        dropped.append(f"{counted(int(again.sum()), 'cell')} that an earlier piece has too")
        whole = only(whole, ~again)
    return _merged(whole, first, dropped)


def _without_ghosts(piece: Dataset) -> Dataset:
    marks = marks_of(piece.cell_data)
    if marks is None or not (marks & DUPLICATE).any():
        return _unmarked(piece)
    rest = _unmarked(only(piece, (marks & DUPLICATE) == 0))
    lost = _used(piece) & ~_used(rest)
    number = np.cumsum(~lost) - 1
    vertices, n = rest.cells.connectivity, len(lost)
    vertices = np.where(_inside(vertices, n), number[np.clip(vertices, 0, n - 1)], -1)
    point_data = {name: values[~lost] for name, values in rest.point_data.items()}
    cells = rest.cells._replace(connectivity=vertices)
    return Dataset(rest.points[~lost], cells, point_data, rest.cell_data, rest.ids)


def _unmarked(piece: Dataset) -> Dataset:
    """Without the marks of ghosts, which say nothing of the whole, unless cells are hidden."""

    def without(arrays: dict[str, Array]) -> dict[str, Array]:
        marks = marks_of(arrays)
        if marks is None or (marks > DUPLICATE).any():
            return arrays
        return {name: values for name, values in arrays.items() if name not in MARKS}

    arrays = without(piece.point_data), without(piece.cell_data)
    return Dataset(piece.points, piece.cells, *arrays, piece.ids)


def _inside(vertices: Array, n: int) -> Array:
    return (vertices >= 0) & (vertices < n)


def _used(piece: Dataset) -> Array:
    """The points that cells have, (np,) bool."""
    used = np.zeros(len(piece.points), bool)
    vertices = piece.cells.connectivity
    used[vertices[_inside(vertices, len(used))]] = True
    return used


def _appended(pieces: list[Dataset], dropped: list[str]) -> Dataset:
    """All pieces one after another; a vertex number out of range becomes -1."""
    vertices, offsets = [], [np.zeros(1, np.int64)]
    n = size = 0
    for piece in pieces:
        start, end = piece.cells.offsets[[0, -1]]
        own = piece.cells.connectivity[start:end].astype(np.int64)
        vertices.append(np.where(_inside(own, len(piece.points)), own + n, -1))
        offsets.append(piece.cells.offsets[1:] - start + size)
        n, size = n + len(piece.points), size + len(own)
    types = np.concatenate([piece.cells.types for piece in pieces])
    cells = Cells(np.concatenate(vertices), np.concatenate(offsets), types)
    point_data = _common([piece.point_data for piece in pieces], dropped)
    filled = [piece.cell_data for piece in pieces if len(piece.cells.types)]
    cell_data = _common(filled, dropped)
    ids = next((piece.ids for piece in pieces if piece.ids), "")
    return Dataset(
        np.concatenate([piece.points for piece in pieces]), cells, point_data, cell_data, ids
    )


def _common(tables: list[dict[str, Array]], dropped: list[str]) -> dict[str, Array]:
    """The arrays that all pieces have, of one width."""
    result = {}
    for name in dict.fromkeys(name for table in tables for name in table):
        parts = [table[name] for table in tables if name in table]
        if len(parts) == len(tables) and len({part.shape[1:] for part in parts}) == 1:
            result[name] = np.concatenate(parts)
        else:
            dropped.append(f"{name}, which is not the same array in all pieces")
    return result


def _first_alike(whole: Dataset, piece_of: Array) -> Array:
    """For each point, the first point that is the same, (np,) int64."""
    for name in [whole.ids, *(n for n in whole.point_data if n.lower() in ALIASES)]:
        ids = whole.point_data.get(name)
        if ids is not None and ids.ndim == 1 and ids.dtype.kind in "iu":
            first, apart = _grouped([ids], piece_of)
            with np.errstate(invalid="ignore"):  # between coordinates that are not finite
                reach = np.abs(whole.points - whole.points[first]).max(initial=0.0)
                extent = np.ptp(whole.points, axis=0).max()
            if not apart and reach <= _SAME_PLACE * extent:
                return first
    real = whole.points.dtype.newbyteorder("=")
    bits = (whole.points.astype(real) + real.type(0)).view(f"i{real.itemsize}")  # -0 is 0
    return _grouped(list(bits.T), piece_of)[0]


def _grouped(keys: list[Array], piece_of: Array) -> tuple[Array, bool]:
    """The first of the points with the same keys, where they are in one piece only once each.

    Returns
    -------
    first : (np,) int64
    apart : bool
        Some keys are in a piece several times: those points stay apart.
    """
    order = np.lexsort([piece_of, *keys])
    same = np.logical_and.reduce([key[order][1:] == key[order][:-1] for key in keys])
    group = np.append(0, np.cumsum(~same))
    twice = np.append(False, same & (piece_of[order][1:] == piece_of[order][:-1]))
    bad = np.zeros(group[-1] + 1, bool)
    bad[group[twice]] = True
    starts = order[np.append(True, ~same)]
    first = np.arange(len(order))
    merged = ~bad[group]
    first[order[merged]] = starts[group[merged]]
    return first, bool(bad.any())


def _cells_again(whole: Dataset, first: Array, piece_of: Array) -> Array:
    """The cells whose vertices an earlier piece has as a cell, (n,) bool."""
    shared = np.zeros(len(first) + 1, bool)  # the last one is for the vertex -1
    merged = first != np.arange(len(first))
    shared[:-1] = merged
    shared[first[merged]] = True
    cells = whole.cells
    sizes = np.diff(cells.offsets)
    cell_of = np.repeat(np.arange(len(sizes)), sizes)
    inside = np.bincount(cell_of[shared[cells.connectivity]], minlength=len(sizes))
    vertices = np.append(first, -1)[cells.connectivity]
    again = np.zeros(len(sizes), bool)
    owner: dict[tuple[int, ...], int] = {}
    for cell in np.flatnonzero((inside == sizes) & (sizes > 0)).tolist():
        own = sorted(vertices[cells.offsets[cell] : cells.offsets[cell + 1]].tolist())
        piece = int(piece_of[cell])
        again[cell] = owner.setdefault((int(cells.types[cell]), *own), piece) != piece
    return again


def _merged(whole: Dataset, first: Array, dropped: list[str]) -> Dataset:
    """Keep the first of the points that are the same."""
    kept = first == np.arange(len(first))
    number = np.append(np.cumsum(kept)[first] - 1, -1)  # -1 stays
    for name, values in whole.point_data.items():
        own, others = values[~kept], values[first[~kept]]
        differ = own != others
        if values.dtype.kind == "f":
            differ &= ~(np.isnan(own) & np.isnan(others))
        n = np.count_nonzero(differ.reshape(len(own), -1).any(axis=1)) if len(own) else 0
        if n:
            dropped.append(f"other values of {name} at {n} points that several pieces have")
    cells = whole.cells._replace(connectivity=number[whole.cells.connectivity])
    point_data = {name: values[kept] for name, values in whole.point_data.items()}
    return Dataset(whole.points[kept], cells, point_data, whole.cell_data, whole.ids)
