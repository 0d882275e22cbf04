"""Limits that a user sets, and the quantities of cells that they are put on."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..errors import ConfigError
from ..mesh.model import Array
from ..mesh.sizes import chunks, contents, dihedral_angles, facet_normals, norms, unfolded

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


def gates_of(
    fail_above: float | None = None,
    measure: str | None = None,
    min_angle: float | None = None,
    max_angle: float | None = None,
    min_size: float | None = None,
    max_aspect: float | None = None,
    gates: Iterable[str] = (),
) -> Gates:
    """The limits that have options of their own, and all others as `limit_of` reads them.

    Raises
    ------
    ConfigError
        A gate that cannot be understood, or a measure that there is not.
    """
    if measure is not None:
        from ..quality.summary import measure_named

        measure_named(measure)
    limits = [limit_of(text) for text in gates]
    both = ("dihedral", "corner")
    if min_angle is not None:
        limits += [Limit(f"{kind}-min", True, min_angle, code="M402") for kind in both]
    if max_angle is not None:
        limits += [Limit(f"{kind}-max", False, max_angle, code="M402") for kind in both]
    if min_size is not None:
        limits.append(Limit("edge-min", True, min_size, code="M403"))
    if max_aspect is not None:
        limits.append(Limit("aspect-ratio", False, max_aspect))
    return Gates(fail_above, measure, tuple(limits))


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
    from ..quality.summary import MEASURES

    return (*QUANTITIES, *MEASURES)


def families_of(quantity: str) -> tuple[str, ...]:
    """The types of cells that have a quantity."""
    return QUANTITIES[quantity].families if quantity in QUANTITIES else MEASURED


def measured(quantity: str, points: Array, cells: Array, family: str) -> Array:
    """A quantity of each cell, (n,) float64.

    Parameters
    ----------
    points : (np, 3) float64
    cells : (n, k) int64
        Corners.
    family : str
        One of `families_of(quantity)`.
    """
    if quantity in QUANTITIES:
        function = QUANTITIES[quantity].function
        parts = [function(points, cells[rows], family) for rows in chunks(len(cells))]
        return np.concatenate([np.empty(0), *parts])
    # The measures are kernels: imported when a limit asks for them.
    from ..quality.summary import as_degradation, cell_quality, measure_named

    if FAMILIES[family].dimension == 2:
        points, cells = unfolded(points, cells)
    return as_degradation(np.abs(cell_quality(points, cells, measure_named(quantity))))


def _edges(points: Array, cells: Array, family: str) -> Array:
    ends = FAMILIES[family].edges
    return norms(points[cells[:, ends[:, 1]]] - points[cells[:, ends[:, 0]]])


def _edge_min(points: Array, cells: Array, family: str) -> Array:
    return _edges(points, cells, family).min(axis=1, initial=np.inf)


def _edge_max(points: Array, cells: Array, family: str) -> Array:
    return _edges(points, cells, family).max(axis=1, initial=0.0)


def _content(points: Array, cells: Array, family: str) -> Array:
    return np.abs(contents(points, cells, family))


def _height_min(points: Array, cells: Array, family: str) -> Array:
    if FAMILIES[family].dimension == 2:
        longest = _edge_max(points, cells, family)
        return 2 * _content(points, cells, family) / longest
    normals = facet_normals(points, cells, family)
    return 6 * _content(points, cells, family) / norms(normals).max(axis=1, initial=0.0)


def _corners(points: Array, cells: Array) -> Array:
    """Angles at the corners of triangles and quads, in degrees."""
    corners = points[cells]
    a = np.roll(corners, -1, axis=1) - corners
    b = np.roll(corners, 1, axis=1) - corners
    return np.degrees(np.arctan2(norms(np.cross(a, b)), (a * b).sum(axis=-1)))


def _corner_min(points: Array, cells: Array, family: str) -> Array:
    return _corners(points, cells).min(axis=1, initial=180.0)


def _corner_max(points: Array, cells: Array, family: str) -> Array:
    return _corners(points, cells).max(axis=1, initial=0.0)


def _dihedral_min(points: Array, cells: Array, family: str) -> Array:
    return np.degrees(dihedral_angles(points, cells, family).min(axis=1, initial=np.pi))


def _dihedral_max(points: Array, cells: Array, family: str) -> Array:
    return np.degrees(dihedral_angles(points, cells, family).max(axis=1, initial=0.0))


@dataclass(frozen=True)
class Quantity:
    """A row of `QUANTITIES`.

    Attributes
    ----------
    function : function of points, cells and family
    families : tuple of str
        Types of the cells that have it.
    power : int or None
        The power of a length that it is; None for that of the dimension.
    """

    function: Callable[[Array, Array, str], Array]
    families: tuple[str, ...]
    power: int | None = 0


MEASURED = SIMPLICES[2:]  # what has a quality
PLANE, SOLIDS = (
    tuple(name for name, family in FAMILIES.items() if family.dimension == d) for d in (2, 3)
)

# Angles in degrees; lengths, areas and volumes in the unit of the file.
QUANTITIES: dict[str, Quantity] = {
    "dihedral-min": Quantity(_dihedral_min, SOLIDS),
    "dihedral-max": Quantity(_dihedral_max, SOLIDS),
    "corner-min": Quantity(_corner_min, PLANE),
    "corner-max": Quantity(_corner_max, PLANE),
    "edge-min": Quantity(_edge_min, PLANE + SOLIDS, 1),
    "edge-max": Quantity(_edge_max, PLANE + SOLIDS, 1),
    "height-min": Quantity(_height_min, MEASURED, 1),
    "content": Quantity(_content, PLANE + SOLIDS, None),
}
