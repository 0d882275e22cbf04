"""Drawings in space, by pyvista, with a display or without."""

from __future__ import annotations

import contextlib
import ctypes
import math
from typing import Any

import numpy as np

from ..errors import ConfigError
from ..mesh.model import Array
from .drawing import INK, STRONG, Drawing, Layer
from .scale import INFINITE, Scale

BY_EGL, BY_OSMESA = "vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow"
WANTED = "EGL or OSMesa is missing, as libegl1 of Debian"
REMEDY = "name a file for the picture, -o FILE.png"
LIGHT = (-0.5, 0.8, 1.5)  # beside and above the viewer
AMBIENT, DIFFUSE = 0.62, 0.42
DISTANCE = 50.0  # of the camera, where what is seen goes from -1 to 1
NEARER = 0.01  # by how much what must not be hidden is moved to the viewer, likewise
LEAST_SIZE = 4.0  # of polygons with outlines, in pixels


def _pyvista() -> Any:
    """The library; what it says of displays that are not there is left out."""
    try:
        import pyvista
        from vtkmodules.vtkCommonCore import vtkLogger
    except ImportError as error:
        raise ConfigError(
            f"pyvista cannot be loaded ({error}): libraries of the system are missing, as libgl1 "
            "and libxrender1 of Debian"
        ) from error
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    return pyvista


def rendered(drawing: Drawing, width: int, height: int) -> Array:
    """A drawing as (height, width, 4) uint8, transparent where there is nothing.

    Raises
    ------
    ConfigError
        Nothing can be rendered on this machine.
    """
    pyvista = _pyvista()
    plotter = pyvista.Plotter(off_screen=True, window_size=(width, height), lighting="none")
    try:
        if _way(plotter) == BY_OSMESA and not _has_osmesa():
            raise ConfigError(f"no picture can be rendered here: {WANTED}")
        _fill(pyvista, plotter, drawing, width, height)
        plotter.enable_anti_aliasing("msaa", multi_samples=8)
        image = plotter.screenshot(None, transparent_background=True, return_img=True)
    finally:
        plotter.close()
    if image is None or image.shape != (height, width, 4):
        raise ConfigError(f"no picture can be rendered here: {WANTED}")
    return np.asarray(image)


def _way(plotter: Any) -> str:
    """What VTK renders by on this machine."""
    return str(plotter.render_window.GetClassName())


def _has_osmesa() -> bool:
    """Whether there is the library without which `BY_OSMESA` ends the process."""
    for version in ("", ".8", ".6"):
        with contextlib.suppress(OSError):
            ctypes.CDLL(f"libOSMesa.so{version}")
            return True
    return False


def show(drawings: list[Drawing], scale: Scale, title: str) -> None:
    """Show drawings in a window until it is closed.

    Raises
    ------
    ConfigError
        No window can be opened.
    """
    pyvista = _pyvista()
    columns = math.ceil(math.sqrt(len(drawings)))
    shape = math.ceil(len(drawings) / columns), columns
    size = 1200, 900
    plotter = pyvista.Plotter(window_size=size, title=title, shape=shape, lighting="none")
    if _way(plotter) in (BY_EGL, BY_OSMESA):
        plotter.close()
        raise ConfigError(f"no window can be opened here: {REMEDY}")
    for i, drawing in enumerate(drawings):
        plotter.subplot(*divmod(i, columns))
        _fill(pyvista, plotter, drawing, size[0] // columns, size[1] // shape[0])
        if drawing.title:
            plotter.add_text(drawing.title, font_size=8, color=INK)
    labels = [label.replace(INFINITE, "inf") for _, label in sorted(scale.ticks)]
    words = f"{scale.title}, the worst first: {', '.join(labels)}"  # red, to blue
    plotter.add_text(words, position="lower_left", font_size=8, color=INK)
    plotter.show()


def _fill(pyvista: Any, plotter: Any, drawing: Drawing, width: int, height: int) -> None:
    """Put what is drawn into a plotter, and place its camera."""
    unit = float(drawing.half.max()) or 1.0
    plotter.renderer.remove_all_lights()
    plotter.renderer.add_light(pyvista.Light(position=LIGHT, light_type="camera light"))
    for layer in drawing.layers:
        points = (layer.points - drawing.centre) / unit
        if layer.width >= STRONG:
            points = points + NEARER * drawing.direction
        for i, corners in enumerate(layer.corners):
            if not len(corners):
                continue
            used, inverse = np.unique(corners, return_inverse=True)
            mesh = pyvista.PolyData.from_regular_faces(points[used], inverse.reshape(corners.shape))
            line = _width(layer, width, height)
            if layer.colours is None:
                mesh = mesh.extract_all_edges()
                plotter.add_mesh(mesh, lighting=False, color=layer.line, line_width=line)
                continue
            mesh.cell_data["colours"] = np.rint(255.0 * layer.colours[i]).astype(np.uint8)
            plotter.add_mesh(
                mesh, scalars="colours", rgb=True, show_edges=line > 0.0, line_width=line,
                edge_color=layer.line, edge_opacity=_strength(layer, width, height),
                ambient=AMBIENT, diffuse=DIFFUSE,
                specular=0.0, show_scalar_bar=False,
            )  # fmt: skip
    plotter.enable_parallel_projection()
    plotter.camera.focal_point = (0.0, 0.0, 0.0)
    plotter.camera.position = tuple(DISTANCE * drawing.direction)
    plotter.camera.up = tuple(drawing.up)
    high = max(drawing.half[1], drawing.half[0] * height / width) / unit
    plotter.camera.parallel_scale = 1.03 * high
    plotter.camera.clipping_range = (0.01, 2.0 * DISTANCE)


def _width(layer: Layer, width: int, height: int) -> float:
    """Of outlines in pixels: none for the smallest polygons."""
    scale = height / 900.0
    if layer.width >= STRONG:
        return max(2.0, 2.0 * layer.width * scale)
    if layer.colours is None:
        return 1.0
    size = _size(layer, width, height)
    return 0.0 if size < LEAST_SIZE else max(0.5, min(1.2, size / 12.0))


def _strength(layer: Layer, width: int, height: int) -> float:
    """How much of what is under outlines these hide: less for small polygons."""
    return min(1.0, max(0.25, _size(layer, width, height) / 20.0))


def _size(layer: Layer, width: int, height: int) -> float:
    """About how large polygons are in pixels."""
    return float(np.sqrt(width * height / max(layer.count, 1)))
