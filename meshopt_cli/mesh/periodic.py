"""Points that stand for each other: those of periodic sides."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Link:
    """An entity of Gmsh that is the image of another one, point by point.

    Attributes
    ----------
    dimension : int
    tag, master : int
        The entity, and the one it is the image of, both of this dimension.
    affine : tuple of float
        The matrix, 4 x 4 by rows, of the map from the master to the entity; () where it is not
        known.
    pairs : (n, 2) int64
        Points of the entity, and the point of the master that each stands for.
    """

    dimension: int
    tag: int
    master: int
    affine: tuple[float, ...]
    pairs: Array


def renumbered(links: list[Link], new_number: Array) -> list[Link]:
    """The links of a mesh whose points have new numbers, -1 for those that are gone.

    A pair goes with either of its points.
    """
    result = []
    for link in links:
        pairs = new_number[link.pairs]
        result.append(replace(link, pairs=pairs[(pairs >= 0).all(axis=1)]))
    return result
