"""From values of a measure to colours: from red, the worst, to blue, which colour-blind people
tell from each other too."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..mesh.model import Array
from ..quality.measures import LESS, Measure
from ..quality.statistics import WIDE

# From the worst to the best, evenly spaced: red, orange, yellow, blue.
STOPS = ("#a50026", "#d73027", "#f46d43", "#fdae61", "#fee090",
         "#eef3d3", "#c9e4ee", "#9bcae3", "#6aaad4")  # fmt: skip
UNKNOWN = "#b8bcc2"  # of cells that do not have the measure
QUALITY_TICKS = (1.0, 1.25, 1.5, 2.0, 3.0, 5.0, 10.0, math.inf)
INFINITE = "\u221e"
N_TICKS = 5

# Of cells by their direction, see `orientation`.
SIDES = ("#c51b7d", "#1b1f24", "#a8ddb5")
BACK, EDGE_ON, FRONT = 0.0, 0.5, 1.0


@dataclass(frozen=True)
class Scale:
    """How values become colours.

    Attributes
    ----------
    title : str
        What the values are.
    stops : tuple of str
        Colours as "#rrggbb", evenly spaced from the worst value to the best.
    ticks : tuple of (float, str)
        Places in [0, 1], 1 the best, with the values there.
    least, greatest : float
        The finite values that are told apart; of a Q it is 1/Q that is, from 0 to 1.
    is_inverse : bool
        Whether it is a Q.
    is_logarithmic : bool
    less_is_better : bool
    is_stepped : bool
        Whether only the stops are colours, and nothing between them.
    """

    title: str
    stops: tuple[str, ...]
    ticks: tuple[tuple[float, str], ...]
    least: float = 0.0
    greatest: float = 1.0
    is_inverse: bool = False
    is_logarithmic: bool = False
    less_is_better: bool = False
    is_stepped: bool = False

    def places(self, values: Array) -> Array:
        """Where values are between the worst, 0, and the best, 1; not a number where undefined."""
        values = np.asarray(values, dtype=np.float64)
        if self.is_inverse:
            with np.errstate(divide="ignore", over="ignore"):
                return np.where(np.isnan(values), np.nan, np.clip(1.0 / np.abs(values), 0.0, 1.0))
        ends = np.array([self.least, self.greatest])
        inside = np.clip(values, *ends)
        if self.is_logarithmic:
            inside, ends = np.log(inside), np.log(ends)
        # halves, for the whole way may be more than the greatest number
        way = ends[1] / 2 - ends[0] / 2
        part = (
            (inside / 2 - ends[0] / 2) / way
            if way > 0.0
            else np.where(np.isnan(values), np.nan, 0.5)
        )
        part = np.clip(1.0 - part if self.less_is_better else part, 0.0, 1.0)
        return np.where(np.isinf(values), 0.0, part)

    def colours(self, values: Array) -> Array:
        """Colours of values, (n, 3) in [0, 1]."""
        return self.at(self.places(values))

    def at(self, places: Array) -> Array:
        """Colours at places in [0, 1], (n, 3)."""
        table = np.array([rgb(stop) for stop in self.stops])
        known = np.isfinite(places)
        along = np.where(known, places, 0.0) * (len(table) - 1)
        if self.is_stepped:
            along = np.rint(along)
        colours = np.stack(
            [np.interp(along, np.arange(len(table)), channel) for channel in table.T], axis=-1
        )
        return np.where(known[:, None], colours, rgb(UNKNOWN))


def rgb(colour: str) -> tuple[float, ...]:
    """The three parts, in [0, 1], of a colour "#rrggbb"."""
    return tuple(int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))


def scale_of(measure: Measure, values: Array) -> Scale:
    """The scale of a measure: that of a Q is the same for all meshes, others go from the least
    to the greatest of the finite values, by their logarithm where these spread far.

    Parameters
    ----------
    values : (n,) float64
        Of all cells that are to be compared.
    """
    title = measure.name.replace("-", " ")
    if measure.is_quality:
        ticks = tuple((1.0 / q, INFINITE if math.isinf(q) else f"{q:g}") for q in QUALITY_TICKS)
        return Scale(f"Q, {title}", STOPS, ticks, is_inverse=True)
    finite = values[np.isfinite(values)]
    least, greatest = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    less = measure.better == LESS
    is_logarithmic = least > 0.0 and greatest / WIDE > least
    along = np.linspace(0.0, 1.0, N_TICKS if greatest > least else 1)
    if is_logarithmic:
        with np.errstate(over="ignore"):
            marks = np.exp((1.0 - along) * math.log(least) + along * math.log(greatest))
        marks = np.clip(marks, least, greatest)
    else:
        marks = (1.0 - along) * least + along * greatest
    unit = "" if measure.unit == "1" else f" ({measure.unit})"
    scale = Scale(f"{title}{unit}", STOPS, (), least, greatest, False, is_logarithmic, less)
    places = scale.places(marks).tolist()
    ticks = tuple(
        (place, f"{mark:.4g}") for place, mark in zip(places, marks.tolist(), strict=True)
    )
    return Scale(scale.title, STOPS, ticks, least, greatest, False, is_logarithmic, less)


def orientation(is_surface: bool) -> Scale:
    """The scale of the direction of cells: `BACK`, `EDGE_ON` and `FRONT` (18.7.1).

    Parameters
    ----------
    is_surface : bool
        Whether it is the side that facets are seen from; else the sign of areas and volumes.
    """
    labels = ("back", "edge-on", "front")
    if not is_surface:
        labels = ("negative", "flat", "positive")
    ticks = tuple(zip((BACK, EDGE_ON, FRONT), labels, strict=True))
    return Scale("side seen" if is_surface else "orientation", SIDES, ticks, is_stepped=True)
