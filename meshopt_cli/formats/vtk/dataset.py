"""What a file of VTK holds, before it is a `Mesh`: points, cells and arrays, and what stays out."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...mesh.model import Array, Mesh
from .cells import Cells, blocks_of, counted

# Arrays that mark ghosts and hidden cells; the second one until version 6 of VTK.
MARKS = _GHOSTS, _LEVELS = "vtkGhostType", "vtkGhostLevels"
_HIDDEN_CELL, _HIDDEN_POINT = 32, 2


@dataclass
class Dataset:
    """A data set of VTK, or a piece of one.

    Attributes
    ----------
    points : (np, 3) array
    cells : Cells
    point_data, cell_data : dict of str to array
        With a row for each point, or cell of the file.
    ids : str
        The array of the points that the file calls their global numbers; "" if there is none.
    """

    points: Array
    cells: Cells
    point_data: dict[str, Array] = field(default_factory=dict)
    cell_data: dict[str, Array] = field(default_factory=dict)
    ids: str = ""


def keep(
    arrays: dict[str, Array], name: str, values: Array, count: int, dropped: list[str]
) -> None:
    """Add an array, unless it does not have a row for each point or cell, or its name is taken."""
    if len(values) != count:
        dropped.append(f"{name} ({len(values)} rows for {count})")
    elif name in arrays:
        dropped.append(f"the second array {name}")
    else:
        arrays[name] = values


def mesh_of(data: Dataset, dropped: list[str]) -> Mesh:
    """Make a mesh, and add what it lacks to a list.

    Raises
    ------
    UnreadableError
        It has cells that are not supported and that it cannot do without.
    """
    data = without_hidden(data, dropped)
    return Mesh(data.points, blocks_of(data.cells, data.cell_data, dropped), data.point_data)


def without_hidden(data: Dataset, dropped: list[str]) -> Dataset:
    """Leave out the cells that a file hides, or of which it hides a vertex."""
    marks = marks_of(data.cell_data)
    hidden = np.zeros(len(data.cells.types), bool)
    if marks is not None:
        hidden |= (marks & _HIDDEN_CELL) > 0
    marks = marks_of(data.point_data)
    if marks is not None and (marks & _HIDDEN_POINT).any():
        cell_of = np.repeat(np.arange(len(hidden)), np.diff(data.cells.offsets))
        vertices = data.cells.connectivity[data.cells.offsets[0] :][: len(cell_of)]
        known = (vertices >= 0) & (vertices < len(marks))
        hidden[cell_of[known][(marks[vertices[known]] & _HIDDEN_POINT) > 0]] = True
    if not hidden.any():
        return data
    dropped.append(counted(int(hidden.sum()), "hidden cell"))
    return only(data, ~hidden)


def marks_of(arrays: dict[str, Array]) -> Array | None:
    """VTK's marks of ghosts (1) and hidden ones, (n,) uint8, if there are any."""
    marks = arrays.get(_GHOSTS)
    levels = arrays.get(_LEVELS)
    if marks is None and levels is not None and levels.ndim == 1:
        return (levels > 0).astype(np.uint8)
    if marks is None or marks.ndim > 1 or marks.dtype.kind not in "iu":
        return None
    return marks.astype(np.uint8)


def only(data: Dataset, wanted: Array) -> Dataset:
    """The data set with some of its cells, (n,) bool, and all of its points."""
    offsets, sizes = data.cells.offsets, np.diff(data.cells.offsets)
    inside = np.repeat(wanted, sizes)
    vertices = data.cells.connectivity[offsets[0] :][: len(inside)][inside]
    cells = Cells(vertices, np.append(0, np.cumsum(sizes[wanted])), data.cells.types[wanted])
    cell_data = {name: values[wanted] for name, values in data.cell_data.items()}
    return Dataset(data.points, cells, data.point_data, cell_data, data.ids)
