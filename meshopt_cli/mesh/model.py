"""What a file holds: `Mesh`, in the file's own order and precision."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..cells import FAMILIES, SIMPLICES, dimension_of, family_of
from ..errors import BadMeshError, UnsupportedMeshError
from .periodic import Link, renumbered

Array = np.ndarray


@dataclass
class Block:
    """Cells of one type that stand together in a file.

    Attributes
    ----------
    type : str
        Name of the cell type as meshio spells it: "triangle", "tetra", ...
    cells : (n, k) int64
        Vertices of each cell, counted from 0. Not checked against the points.
    data : dict of str to (n, ...) array
        Arrays with one row a cell, by the name the file gives them.
    entities : (m,) int array, optional
        Tags of the entities that bound this one (Gmsh 4.1).
    numbers : (n,) int64, optional
        Which cell of its file each one is, counted from 0, where some of the file stay out or
        make several; None where they follow each other, through all blocks.
    """

    type: str
    cells: Array
    data: dict[str, Array] = field(default_factory=dict)
    entities: Array | None = None
    numbers: Array | None = None


@dataclass(frozen=True)
class View:
    """What an array is where a file holds several steps of one quantity.

    Attributes
    ----------
    name : str
        Of the quantity.
    time : float
    step : int
    """

    name: str
    time: float = 0.0
    step: int = 0


@dataclass
class Mesh:
    """All that a mesh file holds.

    Attributes
    ----------
    points : (np, 2) or (np, 3) float32 or float64
    blocks : list of Block
    point_data : dict of str to (np, ...) array
    names : dict of (dimension, tag) to str
        Names of physical groups.
    more_groups : dict of (dimension, tag) to tuple of int
        The physical groups that an entity of Gmsh is in besides that of its cells.
    periodic : list of Link
        Points that stand for each other.
    fields : dict of str to array
        Arrays of the mesh as a whole, such as a time, with any number of rows.
    views : dict of str to View
        What arrays are that are called otherwise than their quantity, or have a time or a step.
    numbers : (np,) int64, optional
        Which point of the file each one is, counted from 0; None where they follow each other.
    regions : tuple of str, optional
        Arrays that make regions, instead of all that `tags.is_tag` takes for tags.
    """

    points: Array
    blocks: list[Block]
    point_data: dict[str, Array] = field(default_factory=dict)
    names: dict[tuple[int, int], str] = field(default_factory=dict)
    more_groups: dict[tuple[int, int], tuple[int, ...]] = field(default_factory=dict)
    periodic: list[Link] = field(default_factory=list)
    fields: dict[str, Array] = field(default_factory=dict)
    views: dict[str, View] = field(default_factory=dict)
    numbers: Array | None = None
    regions: tuple[str, ...] | None = None

    def dimension(self) -> int:
        """Greatest dimension of the cells, second-order ones included; -1 without cells."""
        return max((dimension_of(b.type) for b in self.blocks if len(b.cells)), default=-1)

    def numbered_anew(self) -> Mesh:
        """The mesh in a new file, where its points and cells follow each other."""
        blocks = [block if block.numbers is None else replace(block, numbers=None)
                  for block in self.blocks]  # fmt: skip
        return replace(self, blocks=blocks, numbers=None)

    def with_points(self, kept: Array, number: Array, blocks: list[Block]) -> Mesh:
        """The mesh with some of its points only, and blocks that have the numbers of these.

        Parameters
        ----------
        kept : (np,) bool
        number : (np,) int64
            The new number of each point, that of another where this takes its place, or -1.
        """
        return replace(
            self,
            points=self.points[kept],
            blocks=blocks,
            point_data={name: values[kept] for name, values in self.point_data.items()},
            periodic=renumbered(self.periodic, number),
            numbers=None,
        )


def top_blocks(mesh: Mesh) -> list[Block]:
    """The blocks with cells of the greatest dimension: those that a mesh is made of."""
    top = mesh.dimension()
    return [b for b in mesh.blocks if len(b.cells) and dimension_of(b.type) == top]


def main_type(mesh: Mesh) -> str:
    """The type of the cells to optimize, "triangle" or "tetra".

    Cells of lower dimension, of whatever type, do not matter to it.

    Raises
    ------
    BadMeshError
        The mesh has no cells of dimension 2 or 3.
    UnsupportedMeshError
        It has others than these of the greatest dimension.
    """
    dimension = mesh.dimension()
    if dimension < 2:
        what = {-1: "no cells", 0: "points only", 1: "lines only"}[dimension]
        raise BadMeshError(f"{what}: a mesh of triangles or tetrahedra is needed")
    others = {b.type for b in top_blocks(mesh)} - {SIMPLICES[dimension]}
    if others:
        curved = all(cell_type not in FAMILIES for cell_type in others)
        remedy = "save it with cells of first order" if curved else "cut them into simplices first"
        raise UnsupportedMeshError(
            f"cells of type {', '.join(sorted(others))} cannot be optimized, only cells of first "
            "order can, and triangles in a plane and tetrahedra that are all of second order: "
            f"{remedy}; meshopt check takes them as they are"
        )
    return SIMPLICES[dimension]


def main_blocks(mesh: Mesh, cell_type: str) -> list[Block]:
    """The blocks of one type that have cells."""
    return [b for b in mesh.blocks if b.type == cell_type and len(b.cells)]


def declared(mesh: Mesh, name: str) -> Array:
    """Corners of the cells of one family over all blocks, of whatever order, (n, k) int64."""
    family = FAMILIES[name]
    found = [b.cells[:, : family.n_corners] for b in mesh.blocks if family_of(b.type) is family]
    return np.concatenate([np.empty((0, family.n_corners), np.int64), *found])
