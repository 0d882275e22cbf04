"""What a picture shows: polygons with their colours, and from where they are looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..mesh.model import Array
from ..mesh.sizes import area_vectors
from ..quality.measures import Measure
from .cut import Cut, around, exposed_rows, kept_rows, polygons_of
from .scale import BACK, EDGE_ON, FRONT, Scale, orientation, scale_of
from .scene import PLANE, SPACE, SURFACE, Scene

INK, FAINT, MARK = "#24292f", "#7d8590", "#c51b7d"
BAD = 10.0  # Q of facets that are marked: the last rank of Table 18.3

SHRINK = 0.86  # of the cells beside a cut, where nothing else is asked for
STRONG = 2.0  # width of outlines of what is to be found

# From where things are seen, and what is up: planes, solids and surfaces, cuts by their axis.
ABOVE = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
ISOMETRIC = np.array([0.9, -1.0, 0.65]), np.array([0.0, 0.0, 1.0])
FROM_BEHIND = np.array([-0.9, 1.0, 0.65]), np.array([0.0, 0.0, 1.0])
SIDES_OF_SURFACES = ("one side", "the other side")
BESIDE = (
    (np.array([1.0, -0.55, 0.4]), np.array([0.0, 0.0, 1.0])),
    (np.array([0.55, 1.0, 0.4]), np.array([0.0, 0.0, 1.0])),
    (np.array([-0.35, -0.55, 1.0]), np.array([0.0, 1.0, 0.0])),
)

# How much of a close-up is around its cell, beside the extent of the cell.
MARGIN = 0.45


@dataclass(frozen=True)
class Layer:
    """Polygons of one look.

    Attributes
    ----------
    points : (n, 3) float64
    corners : tuple of (m, w) int64
    colours : tuple of (m, 3) float64, optional
        Of each polygon, in [0, 1]; without them only outlines are drawn.
    line : str
        Colour of the outlines.
    width : float
        Of the outlines in points; those of many small polygons are thinner, or left out.
    """

    points: Array
    corners: tuple[Array, ...]
    colours: tuple[Array, ...] | None
    line: str = INK
    width: float = 0.6

    @property
    def count(self) -> int:
        return sum(map(len, self.corners))


@dataclass(frozen=True)
class Drawing:
    """A picture before it is drawn.

    Attributes
    ----------
    is_flat : bool
        Whether all lies in the plane z = 0 and is seen from above.
    layers : tuple of Layer
        The later ones over the earlier ones.
    axes : tuple of str
        Names of the coordinates.
    direction, up : (3,) float64
        Towards the viewer, and upwards.
    centre : (3,) float64
    half : (2,) float64
        Half the width and the height of what is to be seen around the centre.
    title : str
    """

    is_flat: bool
    layers: tuple[Layer, ...]
    axes: tuple[str, ...]
    direction: Array
    up: Array
    centre: Array
    half: Array
    title: str = ""


@dataclass(frozen=True)
class Paint:
    """What cells are coloured by: the values of a scene, or their orientation."""

    scale: Scale
    by_orientation: bool = False

    def of(self, scene: Scene, family: str, rows: Array, direction: Array) -> Array:
        """Colours of some cells, (n, 3) in [0, 1]."""
        if not self.by_orientation:
            return self.scale.colours(scene.values[family][rows])
        if scene.kind != SURFACE:
            return self.scale.at((1.0 + scene.signs[family][rows]) / 2.0)
        normals = area_vectors(scene.points, scene.cells[family][rows])
        side = normals @ direction
        return self.scale.at(np.select([side > 0.0, side < 0.0], [FRONT, BACK], EDGE_ON))


def paint_of(
    scene: Scene, measure: Measure, by_orientation: bool, values: Array | None = None
) -> Paint:
    """The colours of a scene; of the values of several scenes where they are compared."""
    if by_orientation:
        return Paint(orientation(scene.kind == SURFACE), True)
    return Paint(scale_of(measure, scene.every_value() if values is None else values))


def views(scene: Scene, paint: Paint, cut: Cut | None, shrink: float) -> list[Drawing]:
    """All of a mesh, or what a cut leaves of it; surfaces that are not cut from both sides.

    See `whole`.
    """
    if scene.kind != SURFACE or cut is not None:
        return [whole(scene, paint, cut, shrink)]
    sides = zip(SIDES_OF_SURFACES, (ISOMETRIC, FROM_BEHIND), strict=True)
    return [replace(whole(scene, paint, cut, shrink, view), title=name) for name, view in sides]


def whole(
    scene: Scene,
    paint: Paint,
    cut: Cut | None,
    shrink: float,
    view: tuple[Array, Array] = ISOMETRIC,
) -> Drawing:
    """All of a mesh, or what a cut leaves of it.

    Of solids those are drawn that others do not hide; those that are negative or flat are too,
    wherever they are, where colours tell them.

    Parameters
    ----------
    shrink : float
        In (0, 1]: how large cells are drawn.
    view : two of (3,) float64
        Towards the viewer, and upwards, of what is neither flat nor cut.

    Raises
    ------
    ConfigError
        The cut leaves nothing.
    """
    rows = kept_rows(scene, cut)
    if scene.kind == PLANE:
        return _seen(scene, [_layer(scene, paint, rows, shrink, ABOVE[0])], ABOVE)
    view = view if cut is None else BESIDE[cut.axis]
    if scene.kind == SURFACE:
        layers = [_layer(scene, paint, rows, shrink, view[0])]
        if not paint.by_orientation:
            layers += _marked(scene, rows, paint)
        return _seen(scene, layers, view)
    if paint.by_orientation and cut is None:
        hull = polygons_of(scene, rows)
        layers = [Layer(hull.points, hull.corners, None, FAINT, 0.5)]
    else:
        seen = exposed_rows(scene, rows) if shrink < 1.0 else rows
        layers = [_layer(scene, paint, seen, shrink, view[0])]
    if paint.by_orientation:
        bad = {f: np.flatnonzero(signs <= 0.0) for f, signs in scene.signs.items()}
        if any(map(len, bad.values())):
            layers.append(_layer(scene, paint, bad, shrink, view[0]))
    return _seen(scene, layers, view)


def alike(drawings: Sequence[Drawing]) -> list[Drawing]:
    """Drawings that are seen from one side, each with the same of space in it, so that they can be
    compared."""
    first = drawings[0]
    frame = np.stack([np.cross(first.up, first.direction), first.up])
    half = np.max([np.abs(frame @ (d.centre - first.centre)) + d.half for d in drawings], axis=0)
    return [replace(drawing, centre=first.centre, half=half) for drawing in drawings]


def close_up(scene: Scene, paint: Paint, family: str, row: int, title: str = "") -> Drawing:
    """A cell with those around it: filled in a plane and on a surface, as outlines in space."""
    one, others = {family: np.array([row])}, around(scene, family, row)
    corners = scene.points[scene.cells[family][row]]
    view = ABOVE if scene.kind == PLANE else _facing(corners)
    if scene.kind == SURFACE:  # from outside, as far as the facet says where that is
        normal = area_vectors(scene.points, scene.cells[family][row : row + 1])[0]
        view = (view[0] if view[0] @ normal >= 0.0 else -view[0], view[1])
    if scene.kind == SPACE:
        hull = polygons_of(scene, others, 1.0 - 1e-9)  # each with all its edges
        layers = [Layer(hull.points, hull.corners, None, FAINT, 0.5)]
    else:
        layers = [_layer(scene, paint, others, 1.0, view[0])]
    cell = _layer(scene, paint, one, 1.0, view[0])
    layers += [cell, Layer(cell.points, cell.corners, None, INK, STRONG)]
    least, greatest = corners.min(axis=0), corners.max(axis=0)
    half = float((greatest - least).max()) * (0.5 + MARGIN)
    if half <= 0.0:  # all corners are in one place
        half = float(np.ptp(scene.ranges(), axis=0).max()) / 20.0 or 1.0
    drawing = _seen(scene, layers, view)
    return replace(drawing, centre=(least + greatest) / 2, half=np.full(2, half), title=title)


def _seen(scene: Scene, layers: list[Layer], view: tuple[Array, Array]) -> Drawing:
    """A drawing of layers as large as they are."""
    towards, up = view
    towards = towards / np.linalg.norm(towards)
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    above = np.cross(towards, right)
    frame = np.stack([right, above, towards])
    places = [layer.points[c.ravel()] @ frame.T for layer in layers for c in layer.corners]
    least = np.min([place.min(axis=0) for place in places if len(place)], axis=0)
    greatest = np.max([place.max(axis=0) for place in places if len(place)], axis=0)
    centre, half = (least + greatest) / 2 @ frame, (greatest - least)[:2] / 2
    is_flat = scene.kind == PLANE
    return Drawing(is_flat, tuple(layers), scene.axes, towards, above, centre, half)


def _layer(
    scene: Scene, paint: Paint, rows: dict[str, Array], shrink: float, direction: Array
) -> Layer:
    """Cells in their colours."""
    found = polygons_of(scene, rows, shrink)
    parts = [paint.of(scene, family, some, direction) for family, some in rows.items()]
    colours = np.concatenate([np.empty((0, 3)), *parts])
    return Layer(found.points, found.corners, tuple(colours[owners] for owners in found.owners))


def _marked(scene: Scene, rows: dict[str, Array], paint: Paint) -> list[Layer]:
    """Outlines of the facets whose Q is bad."""
    if not paint.scale.is_inverse:
        return []
    bad = {f: some[~(scene.values[f][some] <= BAD)] for f, some in rows.items()}
    bad = {f: some[~np.isnan(scene.values[f][some])] for f, some in bad.items()}
    if not any(map(len, bad.values())):
        return []
    found = polygons_of(scene, bad)
    return [Layer(found.points, found.corners, None, MARK, STRONG)]


def _facing(corners: Array) -> tuple[Array, Array]:
    """From where a cell is seen best: along its thinnest way, turned a little; and what is up."""
    _, _, ways = np.linalg.svd(corners - corners.mean(axis=0))
    # Signs are arbitrary: let the greatest part of each be positive.
    greatest = np.abs(ways).argmax(axis=1)
    ways = ways * np.where(ways[np.arange(3), greatest] < 0.0, -1.0, 1.0)[:, None]
    along, across, thin = ways
    return thin + 0.5 * across + 0.3 * along, across
