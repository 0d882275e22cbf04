"""Which meshes are optimized: what is refused, and what is mended on the way in."""

from __future__ import annotations

import logging

import numpy as np

from .. import validity
from ..errors import BadMeshError, UnsupportedMeshError
from ..mesh.any_cells import is_of_any_cells
from ..mesh.model import Mesh, main_type, top_blocks
from ..mesh.orientation import hangs_together, with_agreeing_cells, with_positive_cells
from ..mesh.second_order import by_corners, is_second_order

log = logging.getLogger("meshopt")

# Rules without which cells have no shape to measure.
READABLE = ("M00",)

# Extents of a mesh between which the sixth power of a length is a number.
EXTENTS = 1e-40, 1e40

# Rules that turning cells may mend.
ORIENTATION = {"M101", "M103", "M207"}

# Rules that a tangle breaks: cells with a negative volume, and those that they lie across. Its
# neighbours agree about their facets, whatever their volume.
WRONG = {"M101", "M102"}
TANGLE = WRONG | {"M205", "M209", "M210"}

# The rule that a flat cell at a curved edge breaks, and a better one there does not.
CURVED = {"M105"}

# The rule that bodies break which reach into each other.
OVERLAPPING = {"M209"}

REPAIR = "repair "  # what calls begin with that mend a mesh without optimizing it

TURNED = "cells are listed the other way round, and turned: %d"


class InvalidMeshError(BadMeshError):
    """The mesh breaks a rule of severity error; `report` says which and where."""

    def __init__(self, message: str, mesh: Mesh, report: validity.Report) -> None:
        super().__init__(message)
        self.mesh = mesh
        self.report = report


def require_range(mesh: Mesh) -> None:
    """Refuse coordinates whose products are no numbers any more.

    Raises
    ------
    UnsupportedMeshError
        With what to do.
    """
    if not len(mesh.points):
        raise UnsupportedMeshError("there are no points in it")
    extent = float(np.max(np.ptp(mesh.points.astype(np.float64), axis=0), initial=0.0))
    low, high = EXTENTS
    if np.isfinite(extent) and extent > 0.0 and not low <= extent <= high:
        raise UnsupportedMeshError(
            f"the mesh is {extent:.3g} across: scale it to between {low:g} and {high:g}"
        )


def require_known_cells(mesh: Mesh) -> None:
    """Refuse a mesh that has other cells than those that can be optimized.

    Raises
    ------
    InvalidMeshError
        It has, and it is not valid either.
    BadMeshError, UnsupportedMeshError
        See `mesh.main_type`.
    """
    if is_of_any_cells(mesh):
        return
    try:
        main_type(by_corners(mesh) if is_second_order(mesh) else mesh)
    except UnsupportedMeshError:
        report = validity.check(mesh, overlaps=False)
        if report.is_valid:
            raise
        raise InvalidMeshError(not_valid(report), mesh, report) from None


def not_valid(report: validity.Report, allowed: tuple[str, ...] = ()) -> str:
    """What is said of a mesh that is refused, and what to do about it."""
    codes = sorted(errors_in(report))
    hint = ""
    flags = dict.fromkeys(
        call.removeprefix(REPAIR) for group in report.errors for call in group.rule.calls
        if call.startswith(REPAIR)
    )  # fmt: skip
    if flags:
        hint += f"; what can be mended: meshopt {REPAIR}{' '.join(flags)}"
    if all(group.rule.can_be_meant for group in report.errors):
        hint += f"; if that is meant: --allow {','.join(sorted({*codes, *allowed}))}"
    return f"the mesh is not valid ({', '.join(codes)}): nothing written{hint}"


def _wrong_cells(mesh: Mesh, report: validity.Report) -> np.ndarray:
    """Which main cells are inverted or flat, (ne,) bool."""
    wrong = [np.zeros(len(block.cells), bool) for block in mesh.blocks]
    for group in report.errors:
        if group.code in WRONG and group.places.cells is not None:
            for block, row in group.places.cells.tolist():
                wrong[block][row] = True
    top = top_blocks(mesh)
    return np.concatenate(
        [w for b, w in zip(mesh.blocks, wrong, strict=True) if any(b is one for one in top)]
    )


def _require_apart(mesh: Mesh, allowed: tuple[str, ...]) -> None:
    """Refuse cells that overlap, which is allowed, and have vertices in common.

    Raises
    ------
    InvalidMeshError
    """
    if OVERLAPPING.isdisjoint(allowed) or hangs_together(mesh):
        return
    report = validity.check(mesh, OVERLAPPING)
    if not report.is_valid:
        raise InvalidMeshError(
            "cells that overlap and are joined by a vertex or an edge cannot be meant: "
            "nothing written", mesh, report,
        )  # fmt: skip


def errors_in(report: validity.Report) -> set[str]:
    """Codes of the rules of severity error that are broken."""
    return {group.code for group in report.errors}


def admit(
    mesh: Mesh, untangles: bool, allowed: tuple[str, ...] = ()
) -> tuple[Mesh, validity.Report | None]:
    """Take a mesh to be optimized, with its cells turned where they run the other way round.

    Parameters
    ----------
    untangles : bool
        Whether inverted and flat cells are let through, to be mended. Cells of second order with
        positive corners are in any case.
    allowed : tuple of str
        Codes of the rules that the mesh may break.

    Returns
    -------
    mesh : Mesh
    tangle : Report or None
        What is wrong with it and to be mended.

    Raises
    ------
    InvalidMeshError
        It breaks a rule of severity error that is not allowed, and that neither turning nor
        untangling mends.
    """
    report = validity.check(mesh, ignore=allowed, overlaps=False)
    if report.is_valid:
        _require_apart(mesh, allowed)
        return mesh, None
    broken = errors_in(report)
    n_turned, now = 0, report
    if broken <= ORIENTATION | TANGLE | CURVED:
        for turn in (with_positive_cells, with_agreeing_cells):
            turned, n_turned = turn(mesh)
            again = validity.check(turned, ignore=allowed, overlaps=False) if n_turned else report
            if again.is_valid:
                _require_apart(turned, allowed)
                log.warning(TURNED, n_turned)
                return turned, None
        mesh, now, broken = turned, again, errors_in(again)
    curved = broken & CURVED if is_second_order(mesh) else set()
    tangled = broken - curved
    if tangled <= TANGLE and (not tangled or (untangles and tangled & WRONG)):
        if tangled and not hangs_together(mesh, _wrong_cells(mesh, now)):
            raise InvalidMeshError(
                "inverted or flat cells that are joined by a vertex or an edge only cannot be "
                "untangled: nothing written", mesh, report,
            )  # fmt: skip
        if n_turned:
            log.warning(TURNED, n_turned)
        if tangled:
            log.warning("the mesh has inverted or flat cells: they are to be untangled")
        if curved:
            log.warning("cells at curved edges are not valid: better cells are to mend that")
        return mesh, report
    raise InvalidMeshError(not_valid(report, allowed), mesh, report)
