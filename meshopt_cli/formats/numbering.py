"""How a file counts its cells and points, so that people find them in it."""

from __future__ import annotations

from dataclasses import dataclass

from ..mesh.model import Array, Mesh
from .sniff import MEMORY, Encoding
from .table import FORMATS

# what a type is called where each type is counted by itself
_TYPES = {"line": "edge", "quad": "quadrilateral", "tetra": "tetrahedron", "wedge": "prism"}


@dataclass(frozen=True)
class Numbering:
    """The cells and points of a mesh as its file counts them, in the order they stand there.

    Attributes
    ----------
    blocks : tuple of (str, int, array or None)
        What the cells of each block are called, the number of the first, and which ones they
        are where they do not follow each other: see `Block.numbers`.
    points : (str, int, array or None)
        The same for the points.
    """

    blocks: tuple[tuple[str, int, Array | None], ...]
    points: tuple[str, int, Array | None]

    def cell(self, block: int, row: int) -> str:
        """A row of a block: "element 12"."""
        name, first, numbers = self.blocks[block]
        return f"{name} {first + (row if numbers is None else int(numbers[row]))}"

    def point(self, i: int) -> str:
        """A point: "node 7"."""
        name, first, numbers = self.points
        return f"{name} {first + (i if numbers is None else int(numbers[i]))}"


def numbering(encoding: Encoding, mesh: Mesh) -> Numbering:
    """Find out how a file counts the cells and points of the mesh that was read from it."""
    row = FORMATS["vtu" if encoding == MEMORY else encoding.format]  # numbered from 0, through all
    following: dict[str, int] = {}
    blocks = []
    for block in mesh.blocks:
        name = row.cell_name or _TYPES.get(block.type, block.type)
        first = following.get(name, row.first_number)
        following[name] = first + len(block.cells)
        first = first if block.numbers is None else row.first_number
        blocks.append((name, first, block.numbers))
    return Numbering(tuple(blocks), (row.point_name, row.first_number, mesh.numbers))
