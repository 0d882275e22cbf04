"""A picture as a file: drawings side by side, with what their colours say."""

from __future__ import annotations

import contextlib
import io
import logging
import math
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from .drawing import FAINT, INK, Drawing
from .scale import Scale

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH = 10.0  # of a picture in inches
DPI = 160  # pixels an inch of pictures without words
PIXELS = 1600  # across a picture, where nothing else is asked for
FORMS = {".png": "png", ".svg": "svg"}  # by the suffix of a file
# What makes the same picture the same bytes.
SETTINGS: dict[Any, Any] = {
    "svg.hashsalt": "meshopt",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
}
METADATA: dict[str, dict[str, Any]] = {"png": {"Software": None}, "svg": {"Date": None}}
MOST_COLUMNS = 4
LONGEST = 110  # title, in letters
Box = tuple[float, float, float, float]  # left, bottom, width, height in parts of a figure


def sheet(
    drawings: list[Drawing], scale: Scale, title: str, form: str, width: int = PIXELS
) -> bytes:
    """Drawings with a title and a bar of colours.

    Parameters
    ----------
    form : str
        One of `FORMS`.
    width : int
        In pixels.
    """
    with _quiet():
        return _written(_figure(drawings, scale, title, width / WIDTH), form)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """What matplotlib says of its folders, and of signs that its fonts lack, is for nobody."""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    from matplotlib import rc_context

    with warnings.catch_warnings(), rc_context(SETTINGS):
        warnings.filterwarnings("ignore", "Glyph", UserWarning)
        yield


def _figure(drawings: list[Drawing], scale: Scale, title: str, dpi: float) -> Figure:
    from matplotlib.figure import Figure

    columns = min(len(drawings), MOST_COLUMNS, math.ceil(math.sqrt(len(drawings))))
    rows = math.ceil(len(drawings) / columns)
    is_one = len(drawings) == 1
    aspect = min(map(_aspect, drawings))
    left, right, low, high = (0.6 if is_one and drawings[0].is_flat else 0.15), 1.2, 0.4, 0.6
    gap = 0.3 if drawings[0].title else 0.0
    wide = (WIDTH - left - right) / columns
    tall = wide / aspect
    height = rows * (tall + gap) + low + high
    figure = Figure((WIDTH, height), dpi=dpi, facecolor="white")
    words = title if len(title) <= LONGEST else f"{title[:LONGEST]}..."
    figure.text(left / WIDTH, 1.0 - 0.3 / height, words, fontsize=11, color=INK, va="center",
                parse_math=False)  # fmt: skip
    for i, drawing in enumerate(drawings):
        x = left + wide * (i % columns)
        y = height - high - (tall + gap) * (i // columns + 1)
        box = (x / WIDTH, y / height, wide / WIDTH * (1.0 if is_one else 0.96), tall / height)
        _place(figure, box, drawing, is_one)
    place = ((WIDTH - right + 0.25) / WIDTH, max(0.12, 1.0 - 3.4 / height),
             0.17 / WIDTH, min(0.76, 2.7 / height))  # fmt: skip
    _bar(figure, place, scale)
    return figure


def _aspect(drawing: Drawing) -> float:
    """Width by height of a picture that shows one drawing."""
    half = np.maximum(drawing.half, 1e-6 * drawing.half.max())
    return float(np.clip(half[0] / half[1], 0.8, 4.0)) if half.all() else 1.0


def _place(figure: Figure, box: Box, drawing: Drawing, has_ticks: bool) -> None:
    """Draw into a box of the figure, (left, bottom, width, height) in parts of it."""
    axes = figure.add_axes(box)
    if drawing.is_flat:
        from .plane import draw

        draw(axes, drawing)
    else:
        from .solid import rendered

        size = axes.get_window_extent()
        axes.imshow(rendered(drawing, round(size.width), round(size.height)), aspect="auto")
        has_ticks = False
    for spine in axes.spines.values():
        spine.set_visible(False)
    if has_ticks:
        axes.tick_params(labelsize=8, colors=FAINT)
        axes.set_xlabel(drawing.axes[0], fontsize=8, color=FAINT)
        axes.set_ylabel(drawing.axes[1], fontsize=8, color=FAINT)
    else:
        axes.set_xticks([])
        axes.set_yticks([])
    if drawing.title:
        axes.set_title(drawing.title, fontsize=9, color=INK, pad=3, parse_math=False)


def _bar(figure: Figure, box: Box, scale: Scale) -> None:
    """What the colours say."""
    axes = figure.add_axes(box)
    n = len(scale.stops) if scale.is_stepped else 256
    places = np.linspace(0.0, 1.0, n)
    margin = 0.5 / (n - 1)
    axes.imshow(scale.at(places)[:, None], origin="lower", aspect="auto",
                extent=(0.0, 1.0, -margin, 1.0 + margin))  # fmt: skip
    axes.set_xticks([])
    axes.yaxis.tick_right()
    axes.set_yticks([place for place, _ in scale.ticks], [label for _, label in scale.ticks])
    axes.tick_params(labelsize=8, colors=INK, length=2)
    title = scale.title.replace(", ", ",\n").replace(" (", "\n(")
    axes.set_title(title, fontsize=8, color=INK, loc="left", parse_math=False)  # fmt: skip
    for spine in axes.spines.values():
        spine.set_color(FAINT)


def bare(drawing: Drawing, width: int, height: int) -> bytes:
    """A drawing alone as PNG of so many pixels, transparent where there is nothing."""
    from PIL import Image

    if not drawing.is_flat:
        from .solid import rendered

        image = Image.fromarray(rendered(drawing, width, height))
    else:
        from matplotlib.figure import Figure

        with _quiet():
            figure = Figure((width / DPI, height / DPI), dpi=DPI)
            figure.patch.set_alpha(0.0)
            _place(figure, (0.0, 0.0, 1.0, 1.0), drawing, False)
            figure.axes[0].set_axis_off()
            image = Image.open(io.BytesIO(_written(figure, "png")))
    out = io.BytesIO()
    # A palette is a third as large, and has colours enough.
    image.quantize(255, Image.Quantize.FASTOCTREE).save(out, "png", optimize=True)
    return out.getvalue()


def _written(figure: Figure, form: str) -> bytes:
    out = io.BytesIO()
    figure.savefig(out, format=form, metadata=METADATA[form])
    return out.getvalue()
