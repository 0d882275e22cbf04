"""The order of nodes in Gmsh's cells of second order.

meshio knows that of tetrahedra and hexahedra, and of wedges and pyramids without nodes on their
quads. Those with them have the same order, then the nodes of the quads.
"""

from __future__ import annotations

import numpy as np

from ...cells import FAMILIES
from ...mesh.model import Array

_AS_IN_VTK = {*FAMILIES, "line3", "triangle6"}
# For each node of a cell, in VTK's order, where Gmsh has it.
_PLACES = {
    "wedge18": np.array([0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16]),
    "pyramid14": np.array([0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12, 13]),
}


def from_gmsh(cell_type: str, cells: Array) -> Array:
    """Cells with their nodes as VTK has them."""
    if cell_type in _AS_IN_VTK:
        return cells
    from meshio.gmsh.common import _gmsh_to_meshio_order

    places = _PLACES.get(cell_type)
    return _gmsh_to_meshio_order(cell_type, cells) if places is None else cells[:, places]


def to_gmsh(cell_type: str, cells: Array) -> Array:
    """The other way round."""
    if cell_type in _AS_IN_VTK:
        return cells
    from meshio.gmsh.common import _meshio_to_gmsh_order

    places = _PLACES.get(cell_type)
    if places is None:
        return _meshio_to_gmsh_order(cell_type, cells)
    return cells[:, np.argsort(places)]
