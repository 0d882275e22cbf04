"""Limits that a user sets, and the quantities of cells that they are put on."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..errors import ConfigError
from . import geometry
from .geometry import Array

# A gate as it is written: a quantity, a limit, and where it holds only in a region, that region.
GATE = re.compile(r"\s*([a-z][a-z0-9-]*)\s*(<=|>=)\s*([^@\s]+)\s*(?:@\s*(.*\S)\s*)?")


@dataclass(frozen=True)
class Limit:
    """A limit on a quantity of each cell.

    Attributes
    ----------
    quantity : str
        A key of `QUANTITIES`, or the name of a quality measure.
    is_least : bool
        Whether the value is the least allowed; else it is the greatest.
    value : float
        In degrees for angles, in the unit of the file for lengths.
    region : str, optional
        Name or tag of the only region where it holds.
    code : str
        The rule that reports it.
    """

    quantity: str
    is_least: bool
    value: float
    region: str | None = None
    code: str = "M404"

    def __str__(self) -> str:
        where = "" if self.region is None else f" @ {self.region}"
        return f"{self.quantity} {'>=' if self.is_least else '<='} {self.value:g}{where}"


@dataclass(frozen=True)
class Gates:
    """Limits that the user sets; None where there is none.

    Attributes
    ----------
    fail_above : float or None
        Greatest Q allowed.
    measure : str or None
        By which measure; None means the default one.
    limits : tuple of Limit
        All the others.
    """

    fail_above: float | None = None
    measure: str | None = None
    limits: tuple[Limit, ...] = ()

    @property
    def codes(self) -> tuple[str, ...]:
        """The rules that report what is beyond these limits."""
        own = () if self.fail_above is None else ("M401",)
        return tuple(sorted({*own, *(limit.code for limit in self.limits)}))


NO_GATES = Gates()


def limit_of(text: str) -> Limit:
    """A limit as it is written: "dihedral-min>=10", "aspect-ratio<=5 @ steel".

    Raises
    ------
    ConfigError
        It has another form, or names no quantity.
    """
    match = GATE.fullmatch(text)
    try:
        if match is None:
            raise ValueError
        value = float(match[3])
        if not np.isfinite(value):
            raise ValueError
    except ValueError:
        form = '"QUANTITY>=VALUE" or "QUANTITY<=VALUE", and "@ REGION" after it if it has one'
        raise ConfigError(f"gate {text!r}: must be {form}") from None
    known = quantities()
    if match[1] not in known:
        raise ConfigError(
            f"gate {text!r}: no quantity {match[1]!r}: choose one of {', '.join(known)}"
        )
    return Limit(match[1], match[2] == ">=", value, match[4])


def quantities() -> tuple[str, ...]:
    """All that a gate can be put on: sizes and angles, then Q by each measure."""
    from ..quality import MEASURES

    return (*QUANTITIES, *MEASURES)


def measured(quantity: str, points: Array, cells: Array, family: str) -> Array | None:
    """A quantity of each cell, (n,) float64; None where cells of this family have none.

    Parameters
    ----------
    points : (np, 3) float64
    cells : (n, k) int64
        Corners.
    family : str
        "triangle", "quad", "tetra", "pyramid", "wedge" or "hexahedron".
    """
    if quantity in QUANTITIES:
        return QUANTITIES[quantity](points, cells, family)
    if family not in ("triangle", "tetra"):
        return None
    # The measures are kernels: imported when a limit asks for them.
    from ..quality import as_degradation, cell_quality, measure_named

    if family == "triangle":
        points, cells = geometry.unfolded(points, cells)
    return as_degradation(np.abs(cell_quality(points, cells, measure_named(quantity))))


def _edges(points: Array, cells: Array, family: str) -> Array:
    ends = geometry.EDGES[family]
    return geometry.norms(points[cells[:, ends[:, 1]]] - points[cells[:, ends[:, 0]]])


def _edge_min(points: Array, cells: Array, family: str) -> Array:
    return _edges(points, cells, family).min(axis=1, initial=np.inf)


def _edge_max(points: Array, cells: Array, family: str) -> Array:
    return _edges(points, cells, family).max(axis=1, initial=0.0)


def _content(points: Array, cells: Array, family: str) -> Array:
    return np.abs(geometry.contents(points, cells, family))


def _height_min(points: Array, cells: Array, family: str) -> Array | None:
    if family == "triangle":
        longest = _edge_max(points, cells, family)
        return 2 * _content(points, cells, family) / longest
    if family != "tetra":
        return None
    normals = geometry.facet_normals(points, cells, family)
    return 6 * _content(points, cells, family) / geometry.norms(normals).max(axis=1, initial=0.0)


def _corners(points: Array, cells: Array, family: str) -> Array | None:
    """Angles at the corners of triangles and quads, in degrees."""
    if family not in ("triangle", "quad"):
        return None
    corners = points[cells]
    a = np.roll(corners, -1, axis=1) - corners
    b = np.roll(corners, 1, axis=1) - corners
    return np.degrees(np.arctan2(geometry.norms(np.cross(a, b)), (a * b).sum(axis=-1)))


def _dihedrals(points: Array, cells: Array, family: str) -> Array | None:
    """Dihedral angles of solids, in degrees (Definition 18.1)."""
    if family not in geometry.CORNERS:
        return None
    normals = geometry.facet_normals(points, cells, family)
    one, other = (normals[:, side] for side in geometry.HINGES[family].T)
    return np.degrees(np.arctan2(geometry.norms(np.cross(one, other)), -(one * other).sum(axis=-1)))


def _least(angles: Callable[[Array, Array, str], Array | None]):
    def least(points: Array, cells: Array, family: str) -> Array | None:
        found = angles(points, cells, family)
        return None if found is None else found.min(axis=1, initial=180.0)

    return least


def _greatest(angles: Callable[[Array, Array, str], Array | None]):
    def greatest(points: Array, cells: Array, family: str) -> Array | None:
        found = angles(points, cells, family)
        return None if found is None else found.max(axis=1, initial=0.0)

    return greatest


# Angles in degrees; lengths, areas and volumes in the unit of the file.
QUANTITIES: dict[str, Callable[[Array, Array, str], Array | None]] = {
    "dihedral-min": _least(_dihedrals),
    "dihedral-max": _greatest(_dihedrals),
    "corner-min": _least(_corners),
    "corner-max": _greatest(_corners),
    "edge-min": _edge_min,
    "edge-max": _edge_max,
    "height-min": _height_min,
    "content": _content,
}
# The power of a length that each is, where it is one.
POWERS = {"edge-min": 1, "edge-max": 1, "height-min": 1}
