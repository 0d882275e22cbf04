"""Unstructured grids and surfaces of pyvista."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from ...cells import dimension_of
from ...mesh.model import Array, Mesh
from ..sniff import MEMORY, UnreadableError
from ..tags import for_vtk
from ..vtk.cells import checked
from ..vtk.dataset import Dataset, mesh_of
from ..vtk.surface import surface
from ..vtk.write import cell_data_of, in_a_row, types_of, vertices_of


def fits(given: Any) -> bool:
    """Whether it is a grid or a surface; where nobody has imported pyvista, nothing is one."""
    pyvista = sys.modules.get("pyvista")
    return pyvista is not None and isinstance(given, pyvista.DataSet)


def take(given: Any) -> tuple[Mesh, list[str]]:
    """A mesh of a grid, or of a surface."""
    if hasattr(given, "celltypes"):
        cells = checked(*_section(given.GetCells()), np.asarray(given.celltypes))
    elif hasattr(given, "GetPolys"):
        parts = given.GetVerts(), given.GetLines(), given.GetPolys(), given.GetStrips()
        cells = surface([_section(part) for part in parts])
    else:
        raise UnreadableError("not an unstructured grid: cast_to_unstructured_grid() makes one")
    dropped: list[str] = []
    of_points, of_cells = _arrays(given.point_data), _arrays(given.cell_data)
    mesh = mesh_of(Dataset(np.asarray(given.points), cells, of_points, of_cells), dropped)
    mesh.fields = _arrays(given.field_data)
    return mesh, dropped


def back(mesh: Mesh, given: Any) -> tuple[Any, list[str]]:
    """The kind of data set that was given, of a mesh."""
    import pyvista

    fitted, dropped = for_vtk(mesh, MEMORY)
    if isinstance(given, pyvista.PolyData):
        # VTK has the cells of a surface in this order.
        fitted.blocks.sort(key=lambda block: dimension_of(block.type))
        made = pyvista.PolyData()
        made.points = fitted.points
        made.verts, made.lines, made.faces = (_padded(fitted, dimension) for dimension in range(3))
    else:
        made = pyvista.UnstructuredGrid(_padded(fitted), types_of(fitted, "u1"), fitted.points)
    tables = (made.point_data, fitted.point_data), (made.cell_data, cell_data_of(fitted))
    for table, arrays in (*tables, (made.field_data, fitted.fields)):
        for name, values in arrays.items():
            table[name] = values
    return made, dropped


def _section(part: Any) -> tuple[Array, Array]:
    """Connectivity and offsets of some cells of VTK."""
    from pyvista import convert_array

    return convert_array(part.GetConnectivityArray()), convert_array(part.GetOffsetsArray())


def _padded(mesh: Mesh, dimension: int | None = None) -> Array:
    """Cells of a dimension, or all, each as the number of its vertices, and these."""
    rows = [
        np.insert(vertices, 0, vertices.shape[1], axis=1)
        for block, vertices in zip(mesh.blocks, vertices_of(mesh), strict=True)
        if dimension in (None, dimension_of(block.type))
    ]
    return in_a_row(rows)


def _arrays(table: Any) -> dict[str, Array]:
    """The arrays of a data set, without those of words."""
    found = {name: np.asarray(table[name]) for name in table.keys()}  # noqa: SIM118 (no dict)
    return {name: values for name, values in found.items() if values.dtype.kind in "fiub"}
