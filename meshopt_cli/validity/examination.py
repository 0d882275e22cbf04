"""What the rules of `check` take: a mesh under examination, with all that several of them need."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..mesh.adjacency import same_direction
from ..mesh.model import Array, Mesh
from ..quality.gates import NO_GATES, Gates
from . import contact
from .boundary import Domain, domain_of
from .coincidence import first_points
from .shape import Shape, shape_of
from .study import Study


class Examination(Study):
    """A mesh under examination, with all that several rules find out of it, each found once.

    Parameters
    ----------
    gates : Gates
        Limits that the user sets.
    """

    def __init__(self, mesh: Mesh, gates: Gates = NO_GATES, tolerance: float | None = None) -> None:
        super().__init__(mesh, tolerance)
        self.gates = gates

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
