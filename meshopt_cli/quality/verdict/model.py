"""What is known of a measure of Verdict besides its code: a row of the table.

A cell without extent where a measure divides by it counts as the worst there is: infinite where
less is better, 0 where more is. Verdict says 1e30 for infinite, and takes all below 1e-30 for no
extent, so that small cells in small units are lost to it; here only 0 is 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ...mesh.model import Array

LESS, MORE, SIZE = "less", "more", ""

# Units, and the power of a length that each is.
NUMBER, DEGREES, LENGTH, AREA, VOLUME = "", "degrees", "length", "area", "volume"
POWERS = {NUMBER: 0, DEGREES: 0, LENGTH: 1, AREA: 2, VOLUME: 3}


@dataclass(frozen=True)
class Row:
    """A measure of the cells of one family.

    Attributes
    ----------
    cell_type : str
        A family of cells.
    name : str
        That of Verdict, in kebab case.
    unit : str
        A key of `POWERS`.
    ideal : float or None
        Its value for the ideal cell; None where that depends on the size of the cell.
    better : str
        `LESS`, `MORE`, or `SIZE` where neither is.
    formula : str
        What it is, for people.
    function : function of corners (n, k, 3) float64
        Gives (n,) float64. It also takes the mean size of the cells of a mesh if `sized`.
    sized : bool
        Whether it compares with a mean size: an area for faces, a volume for solids.
    note : str
        Where it differs from what Verdict gives, and why.
    """

    cell_type: str
    name: str
    unit: str
    ideal: float | None
    better: str
    formula: str
    function: Callable[..., Array]
    sized: bool = False
    note: str = ""
