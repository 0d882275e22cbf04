"""The types of elements of Gmsh: those that a mesh can hold, and the names of the others."""

from __future__ import annotations

from functools import cache
from string import ascii_letters
from typing import NamedTuple

from ...cells import FAMILIES, dimension_of

# The rest of Gmsh's list: name, dimension and number of nodes, 0 where that varies.
_OTHERS = {
    20: ("Triangle 9", 2, 9), 22: ("Triangle 12", 2, 12), 24: ("Triangle 15I", 2, 15),
    32: ("Tetrahedron 22", 3, 22), 33: ("Tetrahedron 28", 3, 28), 34: ("Polygon", 2, 0),
    35: ("Polyhedron", 3, 0), 39: ("Quadrilateral 12", 2, 12), 40: ("Quadrilateral 16I", 2, 16),
    41: ("Quadrilateral 20", 2, 20), 52: ("Triangle 18", 2, 18), 53: ("Triangle 21I", 2, 21),
    54: ("Triangle 24", 2, 24), 55: ("Triangle 27", 2, 27), 56: ("Triangle 30", 2, 30),
    57: ("Quadrilateral 24", 2, 24), 58: ("Quadrilateral 28", 2, 28),
    59: ("Quadrilateral 32", 2, 32), 60: ("Quadrilateral 36I", 2, 36),
    61: ("Quadrilateral 40", 2, 40), 67: ("Line Border", 1, 2), 68: ("Triangle Border", 2, 3),
    69: ("Polygon Border", 2, 0), 70: ("Line Child", 1, 2), 79: ("Tetrahedron 34", 3, 34),
    80: ("Tetrahedron 40", 3, 40), 81: ("Tetrahedron 46", 3, 46), 82: ("Tetrahedron 52", 3, 52),
    83: ("Tetrahedron 58", 3, 58), 84: ("Line 1", 1, 1), 85: ("Triangle 1", 2, 1),
    86: ("Quadrilateral 1", 2, 1), 87: ("Tetrahedron 1", 3, 1), 88: ("Hexahedron 1", 3, 1),
    89: ("Prism 1", 3, 1), 99: ("Hexahedron 32", 3, 32), 100: ("Hexahedron 44", 3, 44),
    101: ("Hexahedron 56", 3, 56), 102: ("Hexahedron 68", 3, 68), 103: ("Hexahedron 80", 3, 80),
    104: ("Hexahedron 92", 3, 92), 105: ("Hexahedron 104", 3, 104), 118: ("Pyramid 30", 3, 30),
    119: ("Pyramid 55", 3, 55), 120: ("Pyramid 91", 3, 91), 121: ("Pyramid 140", 3, 140),
    122: ("Pyramid 204", 3, 204), 123: ("Pyramid 285", 3, 285), 124: ("Pyramid 385", 3, 385),
    125: ("Pyramid 21", 3, 21), 126: ("Pyramid 29", 3, 29), 127: ("Pyramid 37", 3, 37),
    128: ("Pyramid 45", 3, 45), 129: ("Pyramid 53", 3, 53), 130: ("Pyramid 61", 3, 61),
    131: ("Pyramid 69", 3, 69), 132: ("Pyramid 1", 3, 1), 133: ("Point Xfem", 0, 0),
    134: ("Line Xfem", 1, 0), 135: ("Triangle Xfem", 2, 0), 136: ("Tetrahedron Xfem", 3, 0),
    137: ("Tetrahedron 16", 3, 16), 140: ("Trihedron 4", 3, 4),
}  # fmt: skip


# What nearly every file is made of: for these meshio, which takes its time to import, is not asked.
FREQUENT = {
    1: "line", 2: "triangle", 3: "quad", 4: "tetra", 5: "hexahedron", 6: "wedge", 7: "pyramid",
    8: "line3", 9: "triangle6", 11: "tetra10", 15: "vertex",
}  # fmt: skip
_CODES = {kind: code for code, kind in FREQUENT.items()}


class Element(NamedTuple):
    """A type of elements.

    Attributes
    ----------
    kind : str
        Name of the type of the cells in a Block; "" for one that no Block can hold.
    name : str
        What messages call it.
    dimension : int
    n_nodes : int
        0 where it varies.
    """

    kind: str
    name: str
    dimension: int
    n_nodes: int


def cell_types() -> dict[str, int]:
    """Gmsh's number of each type of element, by its name in a Block."""
    from meshio.gmsh.common import _meshio_to_gmsh_type

    return _meshio_to_gmsh_type


def code_of(kind: str) -> int:
    """Gmsh's number of the type of a Block.

    Raises
    ------
    KeyError
        It has none.
    """
    return _CODES.get(kind) or cell_types()[kind]


def has_code(kind: str) -> bool:
    """Whether Gmsh has such cells."""
    return kind in _CODES or kind in cell_types()


def element_of(code: int) -> Element | None:
    """The type of elements with this number, None where there is none."""
    if (kind := FREQUENT.get(code)) is None:
        return known_elements().get(code)
    n_nodes = int(kind.lstrip(ascii_letters) or FAMILIES[kind].n_corners)
    return Element(kind, kind, dimension_of(kind), n_nodes)


@cache
def known_elements() -> dict[int, Element]:
    """All types of elements by Gmsh's number."""
    from meshio._common import num_nodes_per_cell

    held = {
        code: Element(kind, kind, dimension_of(kind), num_nodes_per_cell[kind])
        for kind, code in cell_types().items()
    }
    others = {code: Element("", f"{code} ({row[0]})", *row[1:]) for code, row in _OTHERS.items()}
    return {**others, **held}
