"""A mesh as it is looked at: what there is to draw, and what each cell is worth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..mesh.model import Array, Mesh, declared
from ..mesh.plane import plane_of, precision_of, with_depth
from ..mesh.sizes import contents, norms
from ..quality.measurable import Part
from ..quality.measures import Measure
from ..quality.statistics import values_of

PLANE, SURFACE, SPACE = "plane", "surface", "space"

# Cells are flat whose corners hold less than this part of a cube on their longest edge.
FLAT = 1e-12


@dataclass(frozen=True)
class Scene:
    """The cells of greatest dimension of a mesh.

    Attributes
    ----------
    kind : str
        `PLANE`, `SURFACE` or `SPACE`.
    points : (np, 3) float64
        Those of a plane in it, seen upright, with z = 0.
    places : (np, 3) float64
        The same as the file has them.
    axes : tuple of str
        Names of the coordinates: of a plane that is inclined they are not those of the file.
    cells : dict of str to (n, k) int64
        Corners, by families, in the order of the mesh.
    values : dict of str to (n,) float64
        Of a measure; not a number where a family does not have it.
    signs : dict of str to (n,) float64
        1, 0 or -1 as the least area or volume at a corner is positive, none or negative; 1 on a
        surface.
    """

    kind: str
    points: Array
    places: Array
    axes: tuple[str, ...]
    cells: dict[str, Array]
    values: dict[str, Array]
    signs: dict[str, Array]

    @property
    def dimension(self) -> int:
        return 3 if self.kind == SPACE else 2

    def every_value(self) -> Array:
        """The values of all cells, a family after the other, (ne,)."""
        return np.concatenate(list(self.values.values()))

    def centres(self, family: str) -> Array:
        """Centres of the cells of a family as the file has its points, (n, 3)."""
        return self.places[self.cells[family]].mean(axis=1)

    def ranges(self) -> Array:
        """From where to where the vertices of cells go in the file, (2, 3)."""
        used = np.zeros(len(self.points), dtype=bool)
        for cells in self.cells.values():
            used[cells] = True
        points = self.places[used]
        return np.stack([points.min(axis=0), points.max(axis=0)])


def scene_of(mesh: Mesh, part: Part, measure: Measure) -> Scene:
    """What there is to draw of a mesh.

    Parameters
    ----------
    part : Part
        What `measurable` takes from it.
    measure : Measure
    """
    cells = {family: declared(mesh, family) for family in part.cells}
    points, kind = with_depth(mesh.points), SPACE
    places = points
    axes: tuple[str, ...] = ("x", "y", "z")
    if mesh.dimension() == 2:
        halves = [c[:, half] for family, c in cells.items()
                  for half in FAMILIES[family].partitions[0]]  # fmt: skip
        frame = plane_of(points, np.concatenate(halves), precision_of(mesh.points))
        kind = SURFACE if frame is None else PLANE
        if frame is not None:
            frame = frame.upright()
            axes = ("u", "v", "w")
            if frame.normal_axis >= 0:
                axes = tuple("xyz"[int(np.argmax(np.abs(row)))] for row in frame.axes)
            points = frame.flatten(points)
    values = {
        family: values_of(part, measure, family)
        if family in measure.ways
        else np.full(len(rows), np.nan)
        for family, rows in cells.items()
    }
    signs = {family: _signs(part, family) for family in cells}
    return Scene(kind, points, places, axes, cells, values, signs)


def _signs(part: Part, family: str) -> Array:
    """The least sign of the simplices at the corners of cells, (n,)."""
    cells, row = part.cells[family], FAMILIES[family]
    if not part.has_signs:
        return np.ones(len(cells))
    points = part.points[:, : row.dimension]
    longest = np.zeros(len(cells))
    for one, other in row.edges:
        longest = np.maximum(longest, norms(points[cells[:, one]] - points[cells[:, other]]))
    flat = FLAT * longest**row.dimension
    signs = np.ones(len(cells))
    for corner in row.corners:
        content = contents(points, cells[:, corner], SIMPLICES[row.dimension])
        signs = np.minimum(signs, np.select([content > flat, content < -flat], [1.0, -1.0], 0.0))
    return signs
