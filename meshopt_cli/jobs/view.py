"""Pictures of the mesh in a file."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .. import formats
from ..cells import FAMILIES
from ..errors import BadMeshError, ConfigError, WriteError, chosen, naming, reason, shown
from ..files.sink import is_stream, written
from ..formats import Source
from ..mesh.model import Mesh
from ..pictures.cut import Cut, cut_of, middle
from ..pictures.drawing import SHRINK, Drawing, close_up, paint_of, views
from ..pictures.library import require
from ..pictures.scale import Scale, scale_of
from ..pictures.scene import SPACE, SURFACE, Scene, scene_of
from ..pictures.solid import REMEDY
from ..quality.measurable import measurable
from ..quality.measures import DEFAULT_MEASURE, Measure
from ..quality.verdict.table import every_measure
from ..quality.worst import worst_rows
from ..reports.rows import figure, value
from ..validity import check
from .admission import READABLE, require_range
from .report import cell_name

log = logging.getLogger("meshopt")

PNG = ".png"


@dataclass(frozen=True)
class ViewTask:
    """What to draw, and how.

    Attributes
    ----------
    input : Path
    output : Path or None
        Where the picture goes; None for a window.
    measure : str, optional
        Of any kind; None for `DEFAULT_MEASURE`.
    cut : str or None
        See `cut.cut_of`; None for the middle of solids.
    shrink : float or None
        How large cells are drawn, in (0, 1].
    worst : int
        How many of the worst cells are drawn, each with its surroundings, instead of the mesh.
    negative : bool
        Whether colours tell the orientation of cells instead.
    width : int, optional
        Of the picture, in pixels.
    input_format, max_size : optional
        See `formats.read`.
    """

    input: Path
    output: Path | None = None
    measure: str | None = None
    cut: str | None = None
    shrink: float | None = None
    worst: int = 0
    negative: bool = False
    width: int | None = None
    input_format: str | None = None
    max_size: int | None = None


def form_of(path: Path) -> str:
    """The form that a picture is written in, by the suffix of its file.

    Raises
    ------
    ConfigError
        There is none: the message lists those that are.
    """
    from ..pictures.sheet import FORMS

    suffix = path.suffix.lower()
    if suffix not in FORMS and is_stream(path):
        return FORMS[PNG]
    if suffix not in FORMS:
        raise ConfigError(f"{path}: a picture ends in {', '.join(FORMS)}")
    return FORMS[suffix]


def view_file(task: ViewTask, prepare: Callable[[], None] | None = None) -> None:
    """Draw the mesh in a file.

    Parameters
    ----------
    prepare : function, optional
        Called once all that is asked for is known to be there: kernels are compiled then.

    Raises
    ------
    ConfigError
        Something of the task is wrong, or what pictures are drawn by is missing.
    ReadError, WriteError
        A file cannot be read, or written.
    BadMeshError
        There are no cells in it to draw.
    """
    require()
    measure = chosen(every_measure(), task.measure or DEFAULT_MEASURE, "measure")
    cut = None if task.cut is None else cut_of(task.cut)
    form = "" if task.output is None else form_of(task.output)
    if task.output is None:
        require_display()
    if prepare is not None:
        prepare()
    mesh, source = formats.read(task.input, task.input_format, task.max_size)
    with naming(task.input):
        scene = _scene(task.input, mesh, measure)
        drawings, scale, title = _drawings(task, scene, measure, cut, mesh, source)
    if task.output is None:
        from ..pictures.solid import show

        show(drawings, scale, title)
        return
    from ..pictures.sheet import PIXELS, sheet

    picture = sheet(drawings, scale, title, form, task.width or PIXELS)
    try:
        with written(task.output, []) as whole_file:
            whole_file.write_bytes(picture)
    except OSError as error:
        raise WriteError(f"{task.output}: cannot be written: {reason(error)}") from error


def _scene(path: Path, mesh: Mesh, measure: Measure) -> Scene:
    if not check(mesh, READABLE).is_valid:
        raise BadMeshError("the mesh is not valid: see meshopt check")
    require_range(mesh)
    part = measurable(mesh)
    for note in part.notes:
        log.warning("%s: %s", path, note)
    if not measure.ways.keys() & part.cells.keys():
        kinds = " and ".join(FAMILIES[family].plural for family in part.cells)
        raise ConfigError(f"{measure.name} is no measure of {kinds}: see meshopt list measures")
    return scene_of(mesh, part, measure)


def _drawings(
    task: ViewTask, scene: Scene, measure: Measure, cut: Cut | None, mesh: Mesh, source: Source
) -> tuple[list[Drawing], Scale, str]:
    paint = paint_of(scene, measure, task.negative)
    title = _title(scene, measure, source, task.negative)
    if not task.worst:
        if task.cut is None and scene.kind == SPACE and not task.negative:
            cut = middle(scene)
        default = SHRINK if cut is not None and scene.kind == SPACE else 1.0
        return views(scene, paint, cut, task.shrink or default), paint.scale, title
    drawings = []
    for family, row, worth in worst_of(scene, measure, task.worst):
        name = cell_name(mesh, formats.numbering(source.encoding, mesh), family, row)
        said = f"Q {figure(worth)}" if measure.is_quality else f"{measure.name} {value(worth)}"
        drawings.append(close_up(scene, paint, family, row, shown(f"{name}, {said}")))
    return drawings, paint.scale, title


def worst_of(scene: Scene, measure: Measure, n: int) -> list[tuple[str, int, float]]:
    """The worst cells of a scene by its measure, the very worst first: family, row and value."""
    scale = scale_of(measure, scene.every_value())
    found = []
    for family, values in scene.values.items():
        known = np.flatnonzero(~np.isnan(values))
        badness = -scale.places(values[known])
        for place in worst_rows(badness, n).tolist():
            row = int(known[place])
            found.append((float(badness[place]), family, row, float(values[row])))
    found.sort(key=lambda one: -one[0])
    return [(family, row, worth) for _, family, row, worth in found[:n]]


def _title(scene: Scene, measure: Measure, source: Source, negative: bool) -> str:
    """The file, how many cells there are, and from where to where the measure goes, or how many
    are negative and flat."""
    kinds = ", ".join(FAMILIES[f].counted(len(c)) for f, c in scene.cells.items())
    name = shown(source.path.name) or "stdin"
    if negative:
        signs = np.concatenate(list(scene.signs.values()))
        told = (f"{int(np.count_nonzero(signs == s)):,} {what}"
                for s, what in ((-1.0, "negative"), (0.0, "flat")))  # fmt: skip
        return f"{name}: {kinds}" + (f"; {', '.join(told)}" if scene.kind != SURFACE else "")
    values = scene.every_value()
    finite = values[np.isfinite(values)]
    spread = "not defined"
    if len(finite):
        greatest = np.inf if np.isinf(values).any() else finite.max()
        spread = f"{value(finite.min())} to {value(greatest)}, mean {value(finite.mean())}"
    return f"{name}: {kinds}; {measure.name.replace('-', ' ')} {spread}"


def require_display() -> None:
    """Find out whether a window can be opened.

    Raises
    ------
    ConfigError
        There is no display.
    """
    has_display = any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    if sys.platform.startswith("linux") and not has_display:
        raise ConfigError(f"no display for a window: {REMEDY}")
