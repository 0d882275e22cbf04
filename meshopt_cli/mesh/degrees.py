"""The degrees that vertices and edges should have (18.4.2), by the angles that cells claim."""

from __future__ import annotations

from functools import cache

import numpy as np

from ..cells import FAMILIES
from .facets import CellSet
from .model import Array
from .sizes import dihedral_angles

# How many cells of a family fill the full angle around a vertex: 6 triangles or 4 quads, 20 tets
# (footnote 9), 8 hexahedra, 12 wedges. Of pyramids it is their part of a ball in the ideal shape,
# half a regular octahedron, so many more at the base than at the apex.
_APEX = np.pi / np.arcsin(1.0 / 3.0)
_FILL: dict[str, list[float]] = {
    "triangle": [6.0] * 3,
    "quad": [4.0] * 4,
    "tetra": [20.0] * 4,
    "pyramid": [2.0 * _APEX] * 4 + [_APEX],
    "wedge": [12.0] * 6,
    "hexahedron": [8.0] * 8,
}
# What `full_degrees` gives at every vertex of a mesh of simplices, by dimension.
FULL = {2: 6.0, 3: 10.0}

DECIMALS = 9  # of a degree, as far as it is no rounding


def full_degrees(cell_sets: list[CellSet], n_points: int) -> Array:
    """By how much the cells of a full angle, such as those at each vertex, raise its degree.

    It follows from the relation of Euler for the faces of the link of a vertex. In the plane each
    cell raises the degree by one, so that it is 6 for triangles and 4 for quads. In space one with
    three edges at the vertex raises it by a half and one with four by one, and two more edges make
    the ball: 10 for tets, 4 for hexahedra.

    Parameters
    ----------
    cell_sets : list of CellSet
        Of dimension 2 or 3.

    Returns
    -------
    full : (np,) float64
        Where several families meet, as if cells went on in the same proportions; 0 without cells.
    """
    n_cells: dict[tuple[float, float], Array] = {}
    for group in cell_sets:
        family = FAMILIES[group.family]
        n_edges = np.bincount(family.edges.ravel())
        for corner, fill in enumerate(_FILL[family.name]):
            rise = 1.0 if family.dimension == 2 else n_edges[corner] / 2.0 - 1.0
            count = np.bincount(group.cells[:, corner], minlength=n_points)
            n_cells[rise, fill] = n_cells.get((rise, fill), 0) + count
    rise, claimed, common = np.zeros(n_points), np.zeros(n_points), np.zeros(n_points)
    for (up, fill), count in n_cells.items():
        rise += up * count
        claimed += count / fill
        # Cells of one kind only: no rounding.
        common = np.where(count > 0, up * fill, common)
    alone = sum((count > 0).astype(np.int64) for count in n_cells.values()) == 1
    mixed = np.divide(rise, claimed, out=np.zeros(n_points), where=claimed > 0.0)
    return np.where(alone, common, mixed)


def target_degrees(dimension: int, angle: Array, rim: Array, full: Array | float) -> Array:
    """The degree each vertex should have, (np,) float64: 6 in a plane ball, 12 in a full one.

    On the boundary it follows from the angle the cells fill, by Euler's relation: one more than
    the cells of the plane, and 1 + (tets + surface triangles) / 2 in space.

    Parameters
    ----------
    angle : (np,) float64
        That the cells fill around each vertex of the boundary, in radians or steradians.
    rim : (np,) int64
        Number of facets of the boundary at each vertex.
    full : (np,) float64
        See `full_degrees`.
    """
    # A right angle takes one and a half triangles: rounding may not choose between one and two.
    if dimension == 2:
        n_cells = np.maximum(np.round(np.round(full * angle / (2.0 * np.pi), DECIMALS)), 1.0)
        return np.where(rim > 0, n_cells + 1.0, np.round(full))
    rise = np.round(np.maximum(full * angle / (4.0 * np.pi), 0.5), DECIMALS)
    return np.where(rim > 0, np.round(1.0 + (rise + 0.5 * rim)), np.round(2.0 + full))


@cache
def edge_angles(family: str) -> tuple[float, ...]:
    """Dihedral angles of the ideal solid at its edges, in degrees, in the order of these."""
    row = FAMILIES[family]
    angles = np.degrees(
        dihedral_angles(row.reference, np.arange(row.n_corners)[None], family)
    ).round(6)
    facets = [set(facet) for table in row.facets for facet in table.tolist()]
    at_edge = {
        tuple(sorted(facets[i] & facets[j])): float(angle)
        for (i, j), angle in zip(row.hinges.tolist(), angles[0], strict=True)
    }
    return tuple(at_edge[tuple(edge)] for edge in row.edges.tolist())
