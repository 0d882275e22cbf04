"""The measures of Verdict beside those of VTK's filter, on meshes.

`python tests/benchmarks/verdict.py MESH...` prints for each measure and family of cells over how
many cells VTK gave the same, and the greatest difference: that of two values by the greatest of
theirs, the mean over the mesh, and 1 where the ideal value is 0. Of a cell that is nearly flat, few
digits of the volume are left to either: so the difference is told for all cells, and for those with
a Q below 100. Where VTK is wrong (see `meshopt list measures`), only the cells are compared where
its fault does not show, and how many were not is told.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from meshopt_cli import formats
from meshopt_cli.cells import FAMILIES
from meshopt_cli.mesh.sizes import dihedral_angles
from meshopt_cli.quality.measurable import measurable
from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.quality.verdict import VERDICT, verdict_quality

Array = np.ndarray

GOOD, CLOSE = 100.0, 1e-12

KINDS = {  # what VTK calls them, its number for them, and how many measures it has
    "triangle": ("Triangle", 5, 15),
    "quad": ("Quad", 9, 24),
    "tetra": ("Tet", 10, 21),
    "pyramid": ("Pyramid", 14, 5),
    "wedge": ("Wedge", 13, 11),
    "hexahedron": ("Hex", 12, 22),
}


def mesh_of(x):
    """Points and cells of cells that have no points in common."""
    return x.reshape(-1, 3), np.arange(x.shape[0] * x.shape[1]).reshape(x.shape[:2])


def ours(x, kind, name):
    return verdict_quality(*mesh_of(x), kind, name)


def quality_filter():
    """VTK's filter."""
    from vtkmodules.vtkFiltersVerdict import vtkMeshQuality

    return vtkMeshQuality()


def by_vtk(x: Array, kind: str, name: str) -> Array:
    """What VTK measures of cells: infinite where that says 1e30."""
    from vtkmodules.util import numpy_support as arrays

    word, number, _ = KINDS[kind]
    used = quality_filter()
    used.SetInputData(_grid(x, number))
    getattr(used, f"Set{word}QualityMeasureTo{name.title().replace('-', '')}")()
    used.Update()
    values = arrays.vtk_to_numpy(used.GetOutput().GetCellData().GetArray("Quality")).copy()
    return np.where(np.abs(values) >= 1e30, np.copysign(math.inf, values), values)


def _grid(x: Array, number: int):
    from vtkmodules.util import numpy_support as arrays
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid

    coordinates, table = mesh_of(x)
    points, cells, result = vtkPoints(), vtkCellArray(), vtkUnstructuredGrid()
    points.SetData(arrays.numpy_to_vtk(np.ascontiguousarray(coordinates), deep=1))
    starts = np.arange(0, table.size + 1, table.shape[1])
    cells.SetData(*(arrays.numpy_to_vtkIdTypeArray(a, deep=1) for a in (starts, table.ravel())))
    result.SetPoints(points)
    result.SetCells(number, cells)
    return result


def _lengths(x, pairs):
    return [np.linalg.norm(x[:, a] - x[:, b], axis=1) for a, b in pairs]


def _longest_is_among(x, first, rest):
    return np.max(_lengths(x, first), axis=0) >= np.max(_lengths(x, rest), axis=0)


def _two_longest_are_same(x):
    """Whether edges 12 and 13, taken for each other, change nothing."""
    d01, d02, d03, d12, d13 = _lengths(x, [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3)])
    others = np.maximum(d12, d13)
    return (others <= np.maximum(d01, d02)) & (others <= np.maximum(d01, d03))


def _least_angle_is_elsewhere(x):
    """Whether the angles at the edges 02 and 13 do not count, nor what is left of 180 degrees."""
    row = FAMILIES["tetra"]
    edges = [set(row.facets[0][a]) & set(row.facets[0][b]) for a, b in row.hinges]
    angles = np.degrees(dihedral_angles(*mesh_of(x), "tetra"))
    swapped = angles[:, [edges.index({0, 2}), edges.index({1, 3})]]
    return angles.min(axis=1) < np.minimum(swapped, 180.0 - swapped).min(axis=1)


# Which cells VTK is right about, where it is not about all: see the notes of the rows.
RIGHT = {
    ("hexahedron", "edge-ratio"): lambda x: _longest_is_among(
        x, [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6)],
        [(6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]),
    ("pyramid", "shape"): lambda x: _longest_is_among(
        x, [(2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)], [(0, 1), (1, 2)]),
    ("tetra", "collapse-ratio"): _two_longest_are_same,
    ("tetra", "min-angle"): _least_angle_is_elsewhere,
}  # fmt: skip
# Where VTK has a constant with six digits, which the value of the ideal cell takes out.
ROUNDED = {
    ("wedge", name)
    for name in ("condition", "distortion", "max-aspect-frobenius", "mean-aspect-frobenius")
}


def compared(vtk, x, kind, name):
    """Our values and those of VTK, where that is right."""
    a, b = ours(x, kind, name), vtk(x, kind, name)
    if (kind, name) in ROUNDED:
        ideal = FAMILIES[kind].reference[None]
        b *= ours(ideal, kind, name) / vtk(ideal, kind, name)
    rows = RIGHT.get((kind, name), lambda x: np.full(len(x), True))(x)
    return a[rows], b[rows]


def difference(a: Array, b: Array, least: float) -> float:
    """Greatest difference of two values by the greatest of theirs, their mean, and `least`."""
    both = np.isinf(a) & (a == b)
    a, b = a[~both], b[~both]
    if not len(a):
        return 0.0
    size = np.maximum(np.abs(a), np.abs(b))
    mean = float(size[np.isfinite(size)].mean()) if np.isfinite(size).any() else 0.0
    with np.errstate(invalid="ignore"):
        return float(np.max(np.abs(a - b) / np.maximum(size, max(mean, least, 1e-300))))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", nargs="+", type=Path)
    found: dict[tuple[str, str], list[tuple[float, float, int, int, str]]] = {}
    for path in parser.parse_args().meshes:
        part = measurable(formats.read(path)[0])
        for kind, cells in part.cells.items():
            x = part.points[cells]
            good = MEASURES["aspect-ratio"].of(part.points, cells, kind) < GOOD
            for (of, name), row in VERDICT.items():
                if of == kind:
                    least = 1.0 if row.ideal == 0.0 else 0.0
                    a, b = compared(by_vtk, x, kind, name)
                    of_good = difference(*compared(by_vtk, x[good], kind, name), least)
                    told = (of_good, difference(a, b, least), len(a), len(x) - len(a), path.name)
                    found.setdefault((kind, name), []).append(told)
    table = Table("family", "measure", "cells", "left out", "Q below 100", "all", "worst on")
    for (kind, name), rows in found.items():
        n, left = sum(row[2] for row in rows), sum(row[3] for row in rows)
        good, _, _, _, worst = max(rows)
        table.add_row(
            kind, name, f"{n:,}", f"{left:,}" if left else "", f"{good:.1e}",
            f"{max(row[1] for row in rows):.1e}", worst if good > CLOSE else "",
        )  # fmt: skip
    Console(width=140).print(table)


if __name__ == "__main__":
    main()
