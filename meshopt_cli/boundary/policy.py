"""What of a boundary stays: the policies that a user chooses from.

A policy is bound to a mesh before it is worked on. What is bound says where vertices may move,
puts the boundary back into the mesh of the file, and proves that nothing else of it changed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from ..mesh.cast import Simplices
from ..mesh.model import Mesh
from .patches import Patches, patches_of
from .proof import prove_fixed, prove_patches, prove_volumes
from .redeclare import homes, redeclared
from .resampling import resampled
from .ridges import lines_anew
from .splitting import OFF, declared_anew, prove_split, splittable

Array = np.ndarray

# Sine of the angle within which facets lie in one plane, where nothing else is said.
TOLERANCE = 1e-6


class Boundary(Protocol):
    """A policy that is bound to a mesh.

    Attributes
    ----------
    patches : Patches or None
        Where vertices of the boundary may move; None where none does.
    splittable : (n, 2) int64 or None
        Edges that may be split, in the points of the mesh; None where none may.
    keeps_facets : bool
        Whether every facet stays, so that what the boundary allows stays too.
    """

    @property
    def splittable(self) -> Array | None: ...

    @property
    def patches(self) -> Patches | None: ...

    @property
    def keeps_facets(self) -> bool: ...

    def restore(self, result: Mesh, worked: Simplices, origin: Array) -> Mesh:
        """Declare the facets of a result as they were.

        Parameters
        ----------
        result : Mesh
            As `cast.with_simplices` gives it.
        origin : (np',) int64
            The point of the input that each point of the result was, -1 for a new one.
        """

    def prove(self, result: Mesh, after: Simplices, worked: Simplices, origin: Array) -> None:
        """Compare the boundary and the volumes of a result with those of the input.

        Parameters
        ----------
        result : Mesh
            As it will be written.
        after : Simplices
            What `cast` gives for it.
        worked : Simplices
            Before it was put back into the mesh.

        Raises
        ------
        InvariantError
            Something changed that must stay.
        """


class Policy(Protocol):
    """A row of `POLICIES`."""

    name: ClassVar[str]
    summary: ClassVar[str]

    def bound_to(self, mesh: Mesh, source: Simplices) -> Boundary:
        """The policy for one mesh; `source` is what `cast` gave for it."""


@dataclass(frozen=True)
class Fixed:
    """Every vertex and every facet of the boundary and of interfaces stays, bit for bit."""

    name: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "all of the boundary stays as it is"

    def bound_to(self, mesh: Mesh, source: Simplices) -> Boundary:
        return FixedBoundary(mesh, source)


@dataclass(frozen=True)
class Slide:
    """The shape of the boundary stays: vertices move in its planes and along straight ridges.

    Attributes
    ----------
    tolerance : float
        Sine of the angle within which facets lie in one plane, and edges in one line.
    resamples : bool
        Whether edges in the planes and along the ridges may be split, too, and vertices vanish.
    """

    name: ClassVar[str] = "slide"
    summary: ClassVar[str] = "the shape of the boundary stays: its planes and straight ridges"

    tolerance: float = TOLERANCE
    resamples: bool = False

    def bound_to(self, mesh: Mesh, source: Simplices) -> Boundary:
        patches = patches_of(mesh, source, self.tolerance)
        if self.resamples:
            patches = resampled(patches, mesh, source)
        return SlidingBoundary(mesh, source, patches)


@dataclass(frozen=True)
class Split:
    """The boundary and interfaces of triangles in the plane stay, but their edges may be split."""

    name: ClassVar[str] = "split"
    summary: ClassVar[str] = "all of the boundary stays, but vertices may be added on its edges"

    def bound_to(self, mesh: Mesh, source: Simplices) -> Boundary:
        return SplitBoundary(mesh, source, splittable(mesh, source))


@dataclass(frozen=True)
class FixedBoundary:
    """A boundary that stays as it is."""

    mesh: Mesh
    source: Simplices
    patches: None = None
    splittable: None = None
    keeps_facets: bool = True

    def restore(self, result: Mesh, worked: Simplices, origin: Array) -> Mesh:
        return result

    def prove(self, result: Mesh, after: Simplices, worked: Simplices, origin: Array) -> None:
        prove_fixed(self.source, after, self.mesh.points, result.points, origin)
        prove_volumes(self.source, after)


@dataclass(frozen=True)
class SlidingBoundary:
    """A boundary whose shape stays."""

    mesh: Mesh
    source: Simplices
    patches: Patches
    splittable: None = None
    keeps_facets: bool = False

    def restore(self, result: Mesh, worked: Simplices, origin: Array) -> Mesh:
        result = redeclared(self.mesh, result, self.patches, worked, origin)
        if worked.patch is None or self.source.dimension == 2:
            return result
        patch = homes(self.patches, worked, origin)
        return lines_anew(self.mesh, result, self.patches, worked, patch, origin)

    def prove(self, result: Mesh, after: Simplices, worked: Simplices, origin: Array) -> None:
        prove_patches(self.source, worked, self.patches, origin)
        prove_volumes(self.source, after, self.patches.tolerance)


@dataclass(frozen=True)
class SplitBoundary:
    """A boundary whose vertices stay and whose edges may be split."""

    mesh: Mesh
    source: Simplices
    splittable: Array
    patches: None = None
    keeps_facets: bool = False

    def restore(self, result: Mesh, worked: Simplices, origin: Array) -> Mesh:
        return declared_anew(self.mesh, result, self.source, worked, origin)

    def prove(self, result: Mesh, after: Simplices, worked: Simplices, origin: Array) -> None:
        prove_split(self.source, worked, self.mesh.points, result.points, origin)
        prove_volumes(self.source, after, OFF[self.source.single])


POLICIES: dict[str, type[Fixed] | type[Slide] | type[Split]] = {
    p.name: p for p in (Fixed, Slide, Split)
}
