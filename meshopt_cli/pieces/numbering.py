"""Arrays that number points and cells through all pieces: what is new gets numbers of its own.

A step does not know how many new ones others make, so it gives them numbers that no other step
gives; in the end, when all are known, these follow the numbers that there were.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..mesh.model import Array, Mesh
from ..mesh.tags import is_identity

NEW = 1 << 40  # so many numbers to each step
POINTS, CELLS = "points", "cells"


@dataclass(frozen=True)
class Numbered:
    """An array that numbers points, or cells.

    Attributes
    ----------
    where : str
        `POINTS` or `CELLS`.
    name : str
    kind : str
        The type of its numbers, as numpy spells it.
    last : int
        The greatest number that there was in any piece.
    """

    where: str
    name: str
    kind: str
    last: int

    @property
    def key(self) -> str:
        return f"{self.where} {self.name}"


def tables(mesh: Mesh, where: str) -> list[dict[str, Array]]:
    """The arrays of points, or those of the cells of each block."""
    return [mesh.point_data] if where == POINTS else [block.data for block in mesh.blocks]


def numbered_in(mesh: Mesh) -> list[list[Any]]:
    """The arrays of a piece that number something, each as the fields of a `Numbered`."""
    found = []
    for where in (POINTS, CELLS):
        arrays = tables(mesh, where)
        for name in dict.fromkeys(name for table in arrays for name in table):
            parts = [table[name] for table in arrays if name in table]
            values = np.concatenate(parts) if all(p.ndim == 1 for p in parts) else np.zeros((1, 2))
            if values.ndim == 1 and len(values) and is_identity(name, values):
                found.append([where, name, values.dtype.str, int(values.max())])
    return found


def numbered_in_all(pieces: Sequence[Sequence[Sequence[Any]]]) -> list[Numbered]:
    """The arrays that number something in each of some pieces."""
    rows: dict[tuple[str, str], list[Numbered]] = {}
    for piece in pieces:
        for row in piece:
            one = Numbered(*row)
            rows.setdefault((one.where, one.name), []).append(one)
    return [
        Numbered(several[0].where, several[0].name, several[0].kind, max(o.last for o in several))
        for several in rows.values()
        if len(several) == len(pieces)
    ]


def count_new(before: Mesh, after: Mesh, arrays: Sequence[Numbered], first: int) -> dict[str, int]:
    """Number what is new after a step from a first number on; returns how many there are of each.

    They have numbers after the greatest there was, as `tags.numbered` gives them.
    """
    counts = {}
    for one in arrays:
        old = [table[one.name] for table in tables(before, one.where) if one.name in table]
        last = max((int(values.max(initial=-1)) for values in old), default=-1)
        n = 0
        for table in tables(after, one.where):
            if one.name in table:
                values = table[one.name].astype(np.int64)
                is_new = values > last
                values[is_new] += first - last - 1
                n = max(n, int((values[is_new] - first).max(initial=-1)) + 1)
                table[one.name] = values
        counts[one.key] = n
    return counts


def settled(
    mesh: Mesh, arrays: Sequence[Numbered], firsts: Array, counts: dict[str, Array]
) -> None:
    """Give what is new the numbers it has in the end, those of one step after another.

    Parameters
    ----------
    firsts : (n,) int64
        The first number of each step, ascending.
    counts : dict of (n,) int64
        How many new ones there are of each array, by its key.
    """
    for one in arrays:
        n = counts[one.key]
        starts = one.last + 1 + np.cumsum(n) - n
        for table in _with(mesh, one):
            values = table[one.name].astype(np.int64)
            step = np.searchsorted(firsts, values, side="right") - 1
            is_new = values >= NEW
            values[is_new] += (starts - firsts)[step[is_new]]
            kind = np.dtype(one.kind)
            is_small = kind.kind == "f" or values.max(initial=0) <= np.iinfo(kind).max
            table[one.name] = values.astype(kind) if is_small else values


def _with(mesh: Mesh, one: Numbered) -> Iterator[dict[str, Array]]:
    return (table for table in tables(mesh, one.where) if one.name in table)
