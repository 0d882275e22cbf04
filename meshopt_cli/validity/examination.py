"""What the rules of `check` take: a mesh under examination, with all that several of them need."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from ..cells import dimension_of
from ..mesh.adjacency import same_direction
from ..mesh.facets import CellSet
from ..mesh.model import Array, Mesh
from ..mesh.tags import combinations, tags_of
from ..quality.gates import NO_GATES, Gates
from . import contact
from .boundary import Domain, domain_of
from .coincidence import first_points, merged, places_of
from .lower import Lower, lower_of
from .shape import Shape, shape_of
from .sheets import Sheets, sheets_of
from .study import Study, has_repeated


class Examination(Study):
    """A mesh under examination, with all that several rules find out of it, each found once.

    Parameters
    ----------
    gates : Gates
        Limits that the user sets.
    figures : mapping of str to float, optional
        What the mesh has of `quality.gates.FIGURES`.
    """

    def __init__(
        self,
        mesh: Mesh,
        gates: Gates = NO_GATES,
        tolerance: float | None = None,
        figures: Mapping[str, float] | None = None,
    ) -> None:
        super().__init__(mesh, tolerance)
        self.gates = gates
        self.figures = figures or {}

    @cached_property
    def cell_sets(self) -> list[CellSet]:
        """The sound cells; those of a mesh in pieces as if points in one place were one."""
        return merged(self, self.first_points) if self.is_in_pieces else self.sound_sets

    @cached_property
    def places(self) -> tuple[int, int]:
        """How many points the sound cells have, and in how many places these are."""
        return places_of(self, self.first_points)

    @cached_property
    def is_in_pieces(self) -> bool:
        """Whether the cells share no points, or so few that each place has more than two of them.

        One crack, or two bodies in contact, have two in a place. What there is to say of such a
        mesh is said once, and the other rules look at the cells as if they shared them.
        """
        n_points, n_places = self.places
        return n_points > 2 * n_places

    @cached_property
    def shares_nothing(self) -> bool:
        """Whether no vertex of the file is one of two cells."""
        return self.places[0] == sum(group.cells.size for group in self.sound_sets)

    @cached_property
    def shape(self) -> Shape:
        """What the volumes, or the areas, of all sound cells say."""
        return shape_of(self)

    @cached_property
    def explained(self) -> Array:
        """Mask of the cells whose own shape is found wrong, so that more about them is moot."""
        return self.shape.inverted | self.shape.flat | (self.shape.quads > 0)

    @cached_property
    def first_points(self) -> Array:
        """The first point in the same place as each point, itself if there is no other."""
        return first_points(self)

    @cached_property
    def hanging(self) -> tuple[Array, Array]:
        """Vertices that lie on a facet without being its vertices, and the cells of these."""
        return contact.hanging_nodes(self, self.first_points, self.shape.flat)

    @cached_property
    def cracks(self) -> tuple[Array, Array]:
        """Numbers of the cells of boundary facets that coincide."""
        return contact.cracks(self, self.first_points)

    @cached_property
    def domain(self) -> Domain:
        """The boundary of the mesh, and the cells that are missing."""
        return domain_of(self, self.explained)

    @cached_property
    def reversed(self) -> Array:
        """Mask of the inverted cells that agree with their neighbours once they are turned."""
        inverted = self.shape.inverted
        result = inverted & ~self.shape.partly
        if result.any():
            for facets in self.facet_sets:
                one, other = facets.pairs()
                same = same_direction(facets.rows[one], facets.rows[other])
                one, other = facets.owners[one], facets.owners[other]
                odd = same != (inverted[one] != inverted[other])
                result[one[odd]] = result[other[odd]] = False
        return result

    @cached_property
    def lower(self) -> Lower:
        """Cells of lower dimension that bound no cell."""
        return lower_of(self, self.first_points if self.is_in_pieces else None)

    @cached_property
    def repeated_lower(self) -> Array:
        """Which cells of lower dimension that stand by themselves have one vertex twice."""
        result = np.zeros(self.n_cells, dtype=bool)
        lower = (rows for d in range(self.dimension) for _, rows, _ in self.blocks_of(d))
        if any(has_repeated(rows).any() for rows in lower):  # to know which stand takes longer
            for group in self.lower.sets:
                result[group.numbers] = has_repeated(group.cells)
        return result

    @cached_property
    def disagreeing(self) -> tuple[Array, Array]:
        """Numbers of the cells that run round a common facet in the same direction."""
        ones, others = [], []
        for facets in self.facet_sets:
            one, other = facets.pairs()
            same = same_direction(facets.rows[one], facets.rows[other])
            ones.append(facets.owners[one[same]])
            others.append(facets.owners[other[same]])
        none = np.empty(0, dtype=np.int64)
        return np.concatenate([none, *ones]), np.concatenate([none, *others])

    @cached_property
    def sheets(self) -> Sheets:
        """The sheets of a surface in space, and where they may disagree in orientation."""
        return sheets_of(self, *self.disagreeing, self.region)

    @cached_property
    def region(self) -> Array | None:
        """Region of each cell of the top dimension, another number for all others; None without
        tags.

        Regions are those that `optimize` keeps: see `mesh.tags`.
        """
        mesh, top = self.mesh, self.mesh.dimension()
        numbered = [
            (block, np.arange(first, first + len(block.cells)))
            for block, first in zip(mesh.blocks, self.offsets, strict=False)
            if len(block.cells) and dimension_of(block.type) == top
        ]
        tags = tags_of([block for block, _ in numbered], mesh.regions)
        if top < 2 or not tags:
            return None
        number = combinations(tags)
        region = np.full(self.n_cells, number.max() + 1)
        region[np.concatenate([numbers for _, numbers in numbered])] = number
        return region
