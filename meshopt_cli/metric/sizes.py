"""Sizes by formulas: for parts of a mesh that have a name, and for the rest of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..cells import dimension_of
from ..errors import ConfigError, hint, shown
from ..mesh.groups import cells_named, names_of_groups
from ..mesh.model import Array, Mesh
from ..mesh.plane import with_depth
from .formula import Formula, formula_of

MOST_NAMED = 20  # groups that a message offers


@dataclass(frozen=True)
class Sizes:
    """Sizes of the vertices of a mesh.

    Attributes
    ----------
    rest : Formula, optional
        For all that has no other.
    parts : tuple of (str, Formula)
        For physical groups, regions and entities, as `mesh.groups.cells_named` takes them.
    """

    rest: Formula | None = None
    parts: tuple[tuple[str, Formula], ...] = ()

    @property
    def everywhere(self) -> Formula | None:
        """The formula that holds in every point, if there is one."""
        return None if self.parts else self.rest

    def __str__(self) -> str:
        plain = [] if self.rest is None else [self.rest.text]
        return ", ".join([*plain, *(f"{shown(name)}={f.text}" for name, f in self.parts)])

    def at(self, mesh: Mesh) -> Array:
        """Sizes at the points of a mesh, (np,): infinite where none is given.

        A vertex has the least of the sizes of the groups that its cells are in. The formula for the
        rest holds in the cells of greatest dimension that are in none of them.

        Raises
        ------
        ConfigError
            There is no such group: the nearest name is given.
        """
        points = with_depth(mesh.points)
        result = np.full(len(points), np.inf)
        top = mesh.dimension()
        others = [
            np.full(len(block.cells), dimension_of(block.type) == top) for block in mesh.blocks
        ]
        for name, formula in self.parts:
            inside = cells_named(mesh, name)
            if inside is None:
                known = names_of_groups(mesh)[:MOST_NAMED]
                there = hint(name, known) if known else ": the mesh has none"
                raise ConfigError(f"--size: no cell is in a group {shown(repr(name))}{there}")
            _lower(result, points, mesh, inside, formula)
            others = [one & ~chosen for one, chosen in zip(others, inside, strict=True)]
        if self.everywhere is not None:
            return self.everywhere.at(points)
        if self.rest is not None:
            _lower(result, points, mesh, others, self.rest)
        return result


def _lower(sizes: Array, points: Array, mesh: Mesh, inside: list[Array], formula: Formula) -> None:
    """Give the vertices of some cells the sizes of a formula where these are less."""
    corners = [b.cells[chosen].ravel() for b, chosen in zip(mesh.blocks, inside, strict=True)]
    vertices = np.unique(np.concatenate([np.empty(0, np.int64), *corners]))
    sizes[vertices] = np.minimum(sizes[vertices], formula.at(points[vertices]))


def sizes_of(texts: Sequence[str]) -> Sizes:
    """Sizes as they are written: "FORMULA" for the rest, and "NAME=FORMULA" for each part.

    Raises
    ------
    ConfigError
        One is no formula, or something is given twice.
    """
    rest: Formula | None = None
    parts: dict[str, Formula] = {}
    for text in texts:
        name, equals, formula = text.rpartition("=")  # a formula has none, a name may
        name = name.strip()
        if not equals and rest is not None:
            raise ConfigError(
                f"--size is given twice: {shown(rest.text)} and {shown(text.strip())}; only one "
                "may be without a name"
            )
        if not equals:
            rest = formula_of(text)
        elif not name:
            raise ConfigError(f"--size {shown(repr(text))}: no name before =")
        elif name in parts:
            raise ConfigError(f"--size is given twice for {shown(name)}")
        else:
            parts[name] = formula_of(formula)
    return Sizes(rest, tuple(parts.items()))
