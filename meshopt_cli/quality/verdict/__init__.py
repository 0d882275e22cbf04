"""The measures of the Verdict library for cells of any family, by its names.

Verdict is what VTK, ParaView and Cubit measure meshes with (Stimpson et al., "The Verdict
Geometric Quality Library", SAND2007-1751). The formulas are its own, the code is not. Values are
those of VTK; `Row.note` tells where that is wrong, and what is here instead.
"""

from __future__ import annotations

import numpy as np

from ...cells import FAMILIES
from ...errors import chosen
from ...mesh.model import Array
from ...mesh.sizes import chunks
from . import hexahedron, pyramid, quad, tetra, triangle, wedge
from .model import Row

VERDICT: dict[tuple[str, str], Row] = {
    (row.cell_type, row.name): row
    for family in (triangle, quad, tetra, pyramid, wedge, hexahedron)
    for row in family.ROWS
}


def verdict_quality(points: Array, cells: Array, cell_type: str, name: str) -> Array:
    """A measure of each of some cells, (n,) float64.

    Parameters
    ----------
    points : (np, 3) float64
    cells : (n, k) int64
        All of one family, with their corners first. Measures that compare with a mean size take
        that of these cells.
    cell_type : str
        Their family.
    name : str
        That of the measure.

    Raises
    ------
    ConfigError
        There is no such measure, or none for such cells.
    """
    kinds = {kind: FAMILIES[kind] for kind, _ in VERDICT}
    corners = cells[:, : chosen(kinds, cell_type, "measured type of cells").n_corners]
    known = {row.name: row for row in VERDICT.values() if row.cell_type == cell_type}
    row = chosen(known, name, f"measure of {FAMILIES[cell_type].plural}")
    more = (mean_size(points, corners, cell_type),) if row.sized else ()
    parts = [row.function(points[corners[rows]], *more) for rows in chunks(len(cells))]
    return np.concatenate([np.empty(0), *parts])


def mean_size(points: Array, cells: Array, cell_type: str) -> float:
    """Mean area or volume of cells of one family, 0 if there are none.

    Volumes of inverted cells count below 0, as they do for VTK.

    Parameters
    ----------
    points : (np, 3) float64
    cells : (n, k) int64
        Corners.
    cell_type : str
        Their family.
    """
    row = VERDICT[cell_type, "area" if FAMILIES[cell_type].dimension == 2 else "volume"]
    sizes = [row.function(points[cells[rows]]).sum() for rows in chunks(len(cells))]
    return float(sum(sizes)) / max(len(cells), 1)
