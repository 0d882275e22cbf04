"""Pictures for reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..errors import ConfigError
from ..mesh.model import Mesh
from ..pictures.cut import AXES, Cut, middle
from ..pictures.drawing import BAD, SHRINK, Drawing, Paint, alike, close_up, paint_of, views
from ..pictures.library import missing
from ..pictures.scene import PLANE, SPACE, SURFACE, Scene, scene_of
from ..quality.measurable import measurable
from ..quality.measures import MEASURES
from ..quality.summary import Summary
from ..reports.model import Picture, Pictures, Report
from ..reports.rows import figure

WIDTH = 1100  # of pictures of whole meshes, in pixels
ASPECTS = (0.75, 3.0)  # between which the ratios of width and height are
SIDE = 300  # of pictures of single cells
N_COLOURS = 48  # in the bar that tells what they stand for


def illustrated(report: Report, meshes: Sequence[Mesh]) -> Report:
    """A report with pictures, or with the reason why there are none.

    Cells that have no name, as where a repair came before, have no picture.

    Parameters
    ----------
    meshes : sequence of Mesh
        That which it is on, or before and after.
    """
    if what := missing():
        return replace(report, pictures=Pictures(missing=what))
    measure = MEASURES[report.before.measure]
    scenes = [scene_of(mesh, measurable(mesh), measure) for mesh in meshes]
    summaries = [summary for summary in (report.before, report.after) if summary is not None]
    paint = paint_of(scenes[0], measure, False, np.concatenate([s.every_value() for s in scenes]))
    cut = middle(scenes[0]) if scenes[0].kind == SPACE else None
    try:
        sides = [views(scene, paint, cut, SHRINK if cut else 1.0) for scene in scenes]
        # Those of one side of all meshes show the same of space.
        same = zip(*(alike(one) for one in zip(*sides, strict=True)), strict=True)
        wholes = [
            _whole(scene, cut, drawing)
            for scene, drawings in zip(scenes, same, strict=True)
            for drawing in drawings
        ]
        worst = [_worst(scene, paint, s) for scene, s in zip(scenes, summaries, strict=True)]
    except ConfigError as error:  # nothing can be rendered on this machine
        return replace(report, pictures=Pictures(missing=str(error)))
    scale = paint.scale
    bar = np.rint(255.0 * scale.at(np.linspace(0.0, 1.0, N_COLOURS))).astype(int)
    colours = tuple("#{:02x}{:02x}{:02x}".format(*colour) for colour in bar.tolist())
    found = Pictures(tuple(wholes), tuple(worst), scale.title, colours, scale.ticks)
    return replace(report, pictures=found)


def _whole(scene: Scene, cut: Cut | None, drawing: Drawing) -> Picture:
    ratio = drawing.half[0] / drawing.half[1] if drawing.half.all() else 1.0
    height = round(WIDTH / float(np.clip(ratio, *ASPECTS)))
    return _picture(drawing, WIDTH, height, _shown(scene, cut, drawing))


def _shown(scene: Scene, cut: Cut | None, drawing: Drawing) -> str:
    """What a picture of a whole mesh shows, in words."""
    if scene.kind == PLANE:
        return f"cells coloured by Q, {scene.axes[0]} to the right, {scene.axes[1]} upwards"
    if scene.kind == SURFACE or cut is None:
        side = f"{drawing.title}, " if drawing.title else ""
        return f"{side}facets coloured by Q, those above {BAD:g} outlined"
    place = cut.within(scene.ranges())
    return f"whole cells with their centre below {AXES[cut.axis]} = {place:.4g}, coloured by Q"


def _worst(scene: Scene, paint: Paint, summary: Summary) -> tuple[Picture, ...]:
    found = []
    for one in summary.worst_cells:
        if one.cell:
            drawing = close_up(scene, paint, one.family, one.number)
            words = f"{one.cell}, Q {figure(one.quality)}"
            found.append(_picture(drawing, SIDE, SIDE, words))
    return tuple(found)


def _picture(drawing: Drawing, width: int, height: int, words: str) -> Picture:
    from ..pictures.sheet import bare

    return Picture(bare(drawing, width, height), width, height, words)
