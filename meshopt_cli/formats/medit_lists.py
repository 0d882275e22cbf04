"""Medit's lists of vertices and cells that are corners, ridges or required, and of normals.

A list becomes an array of 0 and 1 over the vertices or over the cells of a type, and normals
and tangents become vectors at vertices, NaN where there are none: so they are numbered anew
with what they belong to, and other formats can hold them as arrays.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from ..mesh.model import Array, Mesh
from ..mesh.tags import CORNER, NORMAL, REQUIRED, RIDGE, TANGENT

# section: its code in binary files, the array, and what it lists: vertices or cells of a type
LISTS = {
    "Corners": (13, CORNER, "vertex"),
    "RequiredVertices": (15, REQUIRED, "vertex"),
    "Ridges": (14, RIDGE, "line"),
    "RequiredEdges": (16, REQUIRED, "line"),
    "RequiredTriangles": (17, REQUIRED, "triangle"),
    "RequiredQuadrilaterals": (18, REQUIRED, "quad"),
    "RequiredTetrahedra": (12, REQUIRED, "tetra"),  # a code of Mmg's
}
# section of vectors and its code, then the section that says which vertex has which
VECTORS = {
    "Normals": (60, NORMAL, "NormalAtVertices", 20),
    "Tangents": (59, TANGENT, "TangentAtVertices", 61),
}
_PAIRS = {pairs: code for _, _, pairs, code in VECTORS.values()}
SECTIONS = (*LISTS, *VECTORS, *_PAIRS)
CODES = {row[0]: name for table in (LISTS, VECTORS) for name, row in table.items()}
CODES |= {code: name for name, code in _PAIRS.items()}
ARRAYS = {CORNER, REQUIRED, RIDGE, NORMAL, TANGENT}


def width_of(section: str, dimension: int) -> int:
    """How many numbers a row of a section has."""
    return dimension if section in VECTORS else 2 if section in _PAIRS else 1


def kind_of(section: str) -> str:
    """What the numbers of a section are: "f", reals, or "i"."""
    return "f" if section in VECTORS else "i"


def attach(mesh: Mesh, found: dict[str, Array]) -> list[str]:
    """Turn what stands in sections into arrays of a mesh.

    Parameters
    ----------
    found : dict of str to (n, width) array
        Numbers of vertices, cells and vectors count from 1.

    Returns
    -------
    list of str
        What could not be kept.
    """
    lost: list[str] = []
    for section, (_, name, cell_type) in LISTS.items():
        if section not in found:
            continue
        rows = found[section][:, :1] - 1
        if cell_type == "vertex":
            parts = [mesh.point_data]
            ends = np.array([len(mesh.points)])
        else:
            alike = [block for block in mesh.blocks if block.type == cell_type]
            parts = [block.data for block in alike]
            ends = np.cumsum([0, *(len(block.cells) for block in alike)])[1:]
        n = int(ends[-1]) if len(ends) else 0
        flags = np.zeros(n, np.uint8)
        flags[_there(section, rows, (n,), lost)] = 1
        for data, part in zip(parts, np.split(flags, ends[:-1]), strict=True):
            data[name] = part
    for section, (_, name, pairs, _) in VECTORS.items():
        if section not in found or pairs not in found:
            lost += [one for one in (section, pairs) if one in found]
            continue
        vectors = found[section]
        at = np.array([len(mesh.points), len(vectors)])
        vertices, numbers = _there(pairs, found[pairs] - 1, at, lost).T
        if len(np.unique(vertices)) < len(vertices):
            lost.append(f"all but the last of several {section} at a vertex")
        if len(vertices):
            values = np.full((len(mesh.points), vectors.shape[1]), np.nan)
            values[vertices] = vectors[numbers]
            mesh.point_data[name] = values
    return lost


def _there(section: str, rows: Array, n: ArrayLike, lost: list[str]) -> Array:
    """The rows that name what is there: in each column, one of n."""
    fit = np.all((rows >= 0) & (rows < n), axis=1)
    if not fit.all():
        lost.append(f"{section} with numbers of what is not there")
    return rows[fit]


def pick(data: dict[str, Array]) -> dict[str, Array]:
    """The arrays that can be written as lists or vectors."""
    return {
        name: values
        for name, values in data.items()
        if name in ARRAYS and values.ndim == (2 if name in (NORMAL, TANGENT) else 1)
    }


def sections_of(mesh: Mesh) -> Iterator[tuple[str, int, Array]]:
    """What is to be written of a mesh that has one block a type: section, code, rows."""
    for section, (code, name, cell_type) in LISTS.items():
        holders = [block.data for block in mesh.blocks if block.type == cell_type]
        for data in [mesh.point_data] if cell_type == "vertex" else holders:
            rows = np.flatnonzero(np.nan_to_num(data.get(name, np.empty(0)))) + 1
            if len(rows):
                yield section, code, rows[:, None]
    for section, (code, name, pairs, pairs_code) in VECTORS.items():
        vectors = mesh.point_data.get(name, np.empty((0, 1)))
        vertices = np.flatnonzero(np.isfinite(vectors).all(axis=1))
        if len(vertices):
            dimension = mesh.points.shape[1]
            rows = np.zeros((len(vertices), dimension), mesh.points.dtype)
            width = min(dimension, vectors.shape[1])
            rows[:, :width] = vectors[vertices, :width]
            yield section, code, rows
            numbers = np.arange(1, len(vertices) + 1)
            yield pairs, pairs_code, np.column_stack([vertices + 1, numbers])
