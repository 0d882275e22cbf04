"""Meshes in memory: taken over as a `Mesh`, and handed back in the kind that they came in.

A kind is a row of `KINDS`. Arrays are shared with what was given where nothing of them has to
change. The libraries are not imported here: who gives a mesh of theirs has done so.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import ConfigError, ReadError, shown
from ...mesh.model import Mesh
from .. import Source, owned
from ..sniff import MEMORY, UnreadableError
from . import arrays, grids, of_meshio

__all__ = ["Held", "held"]

log = logging.getLogger("meshopt")


@dataclass(frozen=True)
class Kind:
    """A kind of mesh in memory.

    Attributes
    ----------
    name : function of what was given
        What messages call it: "meshio.Mesh".
    fits : function of what was given
        Whether it is of this kind.
    take : function of what was given
        Makes a mesh of it, and lists what it left out.
    back : function of a mesh and of what was given
        Makes the same kind of the mesh, and lists what that cannot hold.
    """

    name: Callable[[Any], str]
    fits: Callable[[Any], bool]
    take: Callable[[Any], tuple[Mesh, list[str]]]
    back: Callable[[Mesh, Any], tuple[Any, list[str]]]


KINDS = (
    Kind(lambda _: "meshio.Mesh", of_meshio.fits, of_meshio.take, of_meshio.back),
    Kind(lambda g: f"pyvista.{type(g).__name__}", grids.fits, grids.take, grids.back),
    Kind(lambda _: "(points, cells)", arrays.fits, arrays.take, arrays.back),
)


@dataclass(frozen=True)
class Held:
    """A mesh that somebody holds in memory.

    Attributes
    ----------
    mesh : Mesh
    source : Source
        Its path is the name of the kind.
    back : function of a mesh
        Makes the same kind of it; what that cannot hold is warned of.
    """

    mesh: Mesh
    source: Source
    back: Callable[[Mesh], Any]


def held(given: Any) -> Held:
    """Take over a mesh in memory.

    Parameters
    ----------
    given : meshio.Mesh, pyvista.UnstructuredGrid, pyvista.PolyData or (points, cells)
        Points are (n, 2) or (n, 3); cells are an (m, k) array, of triangles (k = 3), of
        tetrahedra (4, quads for points of a plane), pyramids (5), wedges (6) or hexahedra (8),
        or a dict, or pairs, of types as meshio spells them and arrays.

    Raises
    ------
    ConfigError
        It is nothing of these.
    ReadError
        It is one, and holds no mesh that can be taken over.
    """
    kind = next((kind for kind in KINDS if kind.fits(given)), None)
    if kind is None:
        raise ConfigError(
            f"{type(given).__name__}: a mesh is a path, a meshopt.Mesh, a meshio.Mesh, a "
            "pyvista.UnstructuredGrid or PolyData, or (points, cells)"
        )
    name = kind.name(given)
    try:
        mesh, dropped = kind.take(given)
        mesh = owned(mesh)
    except (UnreadableError, ValueError, TypeError) as error:
        raise ReadError(f"{name}: {shown(' '.join(str(error).split()))}") from error
    _warn(name, "dropped", dropped)

    def back(mesh: Mesh) -> Any:
        made, lost = kind.back(mesh, given)
        _warn(name, "cannot hold", lost)
        return made

    return Held(mesh, Source(Path(name), MEMORY, "", tuple(dropped)), back)


def _warn(name: str, what: str, lost: list[str]) -> None:
    if lost:
        log.warning("%s: %s %s", name, what, ", ".join(dict.fromkeys(map(shown, lost))))
