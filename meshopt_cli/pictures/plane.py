"""Drawings in the plane, by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .drawing import STRONG, Drawing, Layer

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_VECTORS = 20_000  # polygons of an SVG that are not drawn as a picture in it
LEAST_SIZE = 3.0  # of polygons with outlines, in points


def draw(axes: Axes, drawing: Drawing) -> None:
    """Put a flat drawing into axes, which have their place already."""
    from matplotlib.collections import PolyCollection

    box = axes.get_window_extent()
    # The axes show all of it, and what is beside it where they are wider or higher.
    scale = max(drawing.half[0] / box.width, drawing.half[1] / box.height) * 1.02
    scale = scale or 1.0  # all may be in one place
    half = scale * np.array([box.width, box.height])
    axes.set_xlim(drawing.centre[0] - half[0], drawing.centre[0] + half[0])
    axes.set_ylim(drawing.centre[1] - half[1], drawing.centre[1] + half[1])
    for order, layer in enumerate(drawing.layers):
        width = _width(layer, box.width * box.height * (72.0 / axes.figure.dpi) ** 2)
        for i, corners in enumerate(layer.corners):
            polygons = PolyCollection(
                layer.points[corners][:, :, :2],
                facecolors="none" if layer.colours is None else layer.colours[i],
                edgecolors=layer.line if width else "none",
                linewidths=width,
                joinstyle="round",
                antialiased=width > 0.0,
                zorder=order + 1,
            )
            polygons.set_rasterized(layer.count > MOST_VECTORS)
            axes.add_collection(polygons, autolim=False)


def _width(layer: Layer, area: float) -> float:
    """Of outlines in points, where polygons share an area: none for the smallest."""
    if layer.width >= STRONG:
        return layer.width
    size = float(np.sqrt(area / max(layer.count, 1)))
    return 0.0 if size < LEAST_SIZE else min(layer.width, size / 20.0)
