"""What of a mesh is drawn: cells on one side of a cut, shrunk ones, the surroundings of a cell."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ..errors import ConfigError
from ..mesh.facets import CellSet, facets_of
from ..mesh.model import Array
from .scene import Scene

AXES = "xyz"
NONE = "none"  # a word for no cut at all


@dataclass(frozen=True)
class Cut:
    """A plane normal to an axis: cells whose centre lies below it are kept, whole.

    Attributes
    ----------
    axis : int
    place : float
    is_percent : bool
        Whether the place is one of 100 parts of the way that the mesh goes along the axis.
    """

    axis: int
    place: float
    is_percent: bool = False

    def within(self, ranges: Array) -> float:
        """The coordinate of the plane in a mesh that goes from one row of `ranges` to the other."""
        least, greatest = ranges[:, self.axis].tolist()
        return least + self.place / 100.0 * (greatest - least) if self.is_percent else self.place


def cut_of(text: str) -> Cut | None:
    """The cut that a text such as "x=0.5" or "z=50%" says; None for `NONE`.

    Raises
    ------
    ConfigError
        It says none.
    """
    if text.strip() == NONE:
        return None
    found = re.fullmatch(
        r"\s*([xyz])\s*=\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(%?)\s*", text, re.ASCII
    )
    if found is None:
        raise ConfigError(f"--cut {text}: a cut is such as x=0.5 or z=50%, or {NONE}")
    place = float(found[2])
    if not np.isfinite(place):
        raise ConfigError(f"--cut {text}: the place is not finite")
    return Cut(AXES.index(found[1]), place, bool(found[3]))


def middle(scene: Scene) -> Cut | None:
    """The cut through the middle that shows most: across the shortest way through the mesh.

    None where no cell would be left, as of a single one.
    """
    ranges = scene.ranges()
    ways = np.ptp(ranges, axis=0)
    # Of ways that are as good as equal the first.
    cut = Cut(int(np.flatnonzero(ways <= 1.01 * ways.min())[0]), 50.0, True)
    place = cut.within(ranges)
    is_left = any((scene.centres(f)[:, cut.axis] <= place).any() for f in scene.cells)
    return cut if is_left else None


def kept_rows(scene: Scene, cut: Cut | None) -> dict[str, Array]:
    """Rows of the cells that a cut leaves, by families; all without a cut.

    Raises
    ------
    ConfigError
        It leaves none.
    """
    if cut is None:
        return {family: np.arange(len(cells)) for family, cells in scene.cells.items()}
    ranges = scene.ranges()
    place = cut.within(ranges)
    kept = {f: np.flatnonzero(scene.centres(f)[:, cut.axis] <= place) for f in scene.cells}
    if not any(map(len, kept.values())):
        least, greatest = ranges[:, cut.axis].tolist()
        axis = AXES[cut.axis]
        raise ConfigError(
            f"--cut {axis}={place:g}: no cell lies below: {axis} goes from {least:g} to "
            f"{greatest:g}"
        )
    return kept


def exposed_rows(scene: Scene, rows: dict[str, Array]) -> dict[str, Array]:
    """Rows of those of some solids that others of them do not surround."""
    sets = _sets(scene, rows)
    seen = np.zeros(sum(map(len, rows.values())), dtype=bool)
    for facets in facets_of(sets, len(scene.points)):
        seen[facets.owners[facets.alone()]] = True
    return {one.family: rows[one.family][seen[one.numbers]] for one in sets}


def around(scene: Scene, family: str, row: int) -> dict[str, Array]:
    """Rows of the cells that have a vertex of a cell, itself left out, by families."""
    is_near = np.zeros(len(scene.points), dtype=bool)
    is_near[scene.cells[family][row]] = True
    rows = {f: np.flatnonzero(is_near[cells].any(axis=1)) for f, cells in scene.cells.items()}
    rows[family] = rows[family][rows[family] != row]
    return rows


@dataclass(frozen=True)
class Polygons:
    """Polygons of a mesh, each with the cell it is of.

    Attributes
    ----------
    points : (n, 3) float64
    corners : tuple of (m, w) int64
        By their number of corners.
    owners : tuple of (m,) int64
        For each of these, which of the cells: they are counted through all families.
    """

    points: Array
    corners: tuple[Array, ...]
    owners: tuple[Array, ...]

    @property
    def count(self) -> int:
        return sum(map(len, self.corners))


def polygons_of(scene: Scene, rows: dict[str, Array], shrink: float = 1.0) -> Polygons:
    """The faces of some cells, or the facets of solids, shrunk about the centres of cells.

    Parameters
    ----------
    shrink : float
        In (0, 1]; with 1, vertices are shared, and facets between two of the cells left out.
    """
    points, sets = (
        _apart(scene, rows, shrink) if shrink < 1.0 else (scene.points, _sets(scene, rows))
    )
    if scene.dimension == 3:
        found = [(f.rows[f.alone()], f.owners[f.alone()]) for f in facets_of(sets, len(points))]
        return Polygons(points, *map(tuple, zip(*found, strict=True)))
    return Polygons(points, tuple(s.cells for s in sets), tuple(s.numbers for s in sets))


def _sets(scene: Scene, rows: dict[str, Array]) -> list[CellSet]:
    """Some cells, numbered through all families."""
    sets, first = [], 0
    for family, some in rows.items():
        numbers = np.arange(first, first + len(some))
        sets.append(CellSet(family, scene.cells[family][some], numbers))
        first += len(some)
    return sets


def _apart(scene: Scene, rows: dict[str, Array], shrink: float) -> tuple[Array, list[CellSet]]:
    """Shrunk cells, each with vertices of its own."""
    points, sets, n_points = [np.empty((0, 3))], [], 0
    for one in _sets(scene, rows):
        places = scene.points[one.cells]
        centres = places.mean(axis=1, keepdims=True)
        points.append((centres + shrink * (places - centres)).reshape(-1, 3))
        cells = n_points + np.arange(one.cells.size).reshape(one.cells.shape)
        sets.append(CellSet(one.family, cells, one.numbers))
        n_points += one.cells.size
    return np.concatenate(points), sets
