"""What a part of a mesh cannot know of the whole."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Bounds:
    """What passes hold the mesh that they work on against.

    A working mesh makes its own, as it is the whole; one that is a part of another can be given
    what it cannot find out.

    Attributes
    ----------
    target : float
        Q of the best cell that the worst facet of the boundary allows; 1 when that is not known.
    n_input_vertices : int
        Vertices of the input: how many may vanish goes by them.
    n_input_points : int
        Points of the input, those that no cell uses included: how many may come goes by them.
    worst : float, optional
        q of the worst cell, by the measure that steers; without it that of the mesh as it is now.
    """

    target: float
    n_input_vertices: int
    n_input_points: int
    worst: float | None = None
