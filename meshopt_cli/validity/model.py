"""What a rule is and what it finds: the rows of the table of rules and the values they give."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..mesh.model import Array, Mesh
from .examination import Examination
from .study import Study, n_corners

ERROR = "error"
WARNING = "warning"

ARRAYS = "arrays"
SEARCH = "search"


@dataclass(frozen=True)
class Finding:
    """One place where a rule is broken.

    Attributes
    ----------
    code : str
    message : str
        One line without numbers of cells and points: those are up to the file.
    block, cell : int or None
        The cell is row `cell` of `mesh.blocks[block]`.
    point : int or None
        Row of `mesh.points`.
    other_cells : tuple of (block, cell)
        Cells that have a part in it.
    other_points : tuple of int
        Points that have a part in it.
    where : tuple of float or None
        Coordinates of the point, or of the centre of the cell.
    """

    code: str
    message: str
    block: int | None = None
    cell: int | None = None
    point: int | None = None
    other_cells: tuple[tuple[int, int], ...] = ()
    other_points: tuple[int, ...] = ()
    where: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Places:
    """Where a rule is broken.

    Attributes
    ----------
    messages : tuple of str
    cells : (n, 2) int64, optional
        Block and row; -1 where it is the whole mesh.
    points : (n,) int64, optional
        -1 where there is none.
    kinds : (n,) int64, optional
        Which of the messages; the first where it is left out.
    other_cells : (n, k, 2) int64, optional
        -1 where there are fewer.
    other_points : (n, k) int64, optional
    """

    messages: tuple[str, ...]
    cells: Array | None = None
    points: Array | None = None
    kinds: Array | None = None
    other_cells: Array | None = None
    other_points: Array | None = None

    def __len__(self) -> int:
        for rows in (self.cells, self.points):
            if rows is not None:
                return len(rows)
        return 0


@dataclass(frozen=True)
class Rule:
    """A row of `rules.RULES`.

    Attributes
    ----------
    code : str
    severity : str
        `ERROR` or `WARNING`.
    title : str
    explanation : str
        One line.
    source : str
        Section of the book, or nothing.
    fix : str
        What to do about it, or what there is to know about `calls`, one line.
    find : function of an Examination
    cost : str
        `ARRAYS`: a few passes over arrays; `SEARCH`: a search in space besides.
    on_request : bool
        Whether it is looked for only where `select` names it or its group.
    can_be_meant : bool
        Whether a sound mesh may break it on purpose, so that it can be allowed.
    calls : tuple of str
        Commands, with their options, that mend it, or most of its cases: "repair --merge".
    """

    code: str
    severity: str
    title: str
    explanation: str
    source: str
    fix: str
    find: Callable[[Examination], Places]
    cost: str = ARRAYS
    on_request: bool = False
    can_be_meant: bool = False
    calls: tuple[str, ...] = ()

    @property
    def advice(self) -> str:
        """What mends it, what else to do, and how to say that it is meant, where it can be."""
        parts = [self.fix]
        if self.calls:
            parts.insert(0, f"{', or '.join(f'meshopt {call} IN OUT' for call in self.calls)}.")
        if self.can_be_meant:
            parts.append(
                f"If it is meant: check --ignore {self.code}, optimize --allow {self.code}."
            )
        return " ".join(parts)


@dataclass(frozen=True)
class Group:
    """All places where one rule is broken; at least one.

    Attributes
    ----------
    rule : Rule
    places : Places
    """

    rule: Rule
    places: Places

    @property
    def code(self) -> str:
        return self.rule.code

    def __len__(self) -> int:
        return len(self.places)

    def findings(self, mesh: Mesh, first: int | None = None) -> list[Finding]:
        """The first so many places, or all of them, one by one."""
        n = len(self) if first is None else min(first, len(self))
        return [self._finding(mesh, k) for k in range(n)]

    def _finding(self, mesh: Mesh, k: int) -> Finding:
        places = self.places
        block = cell = point = None
        if places.cells is not None and places.cells[k, 0] >= 0:
            block, cell = places.cells[k].tolist()
        if places.points is not None and places.points[k] >= 0:
            point = int(places.points[k])
        cells = [] if places.other_cells is None else places.other_cells[k].tolist()
        points = [] if places.other_points is None else places.other_points[k].tolist()
        return Finding(
            code=self.code,
            message=places.messages[0 if places.kinds is None else int(places.kinds[k])],
            block=block,
            cell=cell,
            point=point,
            other_cells=tuple((b, row) for b, row in cells if b >= 0),
            other_points=tuple(points),
            where=_where(mesh, block, cell, point),
        )


@dataclass(frozen=True)
class Report:
    """What `check` found.

    Attributes
    ----------
    groups : tuple of Group
        One for each rule that is broken, in the order of the codes.
    """

    groups: tuple[Group, ...] = ()

    @property
    def errors(self) -> tuple[Group, ...]:
        return tuple(group for group in self.groups if group.rule.severity == ERROR)

    @property
    def warnings(self) -> tuple[Group, ...]:
        return tuple(group for group in self.groups if group.rule.severity == WARNING)

    @property
    def is_valid(self) -> bool:
        return not self.errors

    @property
    def codes(self) -> tuple[str, ...]:
        return tuple(group.code for group in self.groups)


def rule(
    code: str,
    severity: str,
    title: str,
    *,
    explanation: str,
    fix: str,
    source: str = "",
    cost: str = ARRAYS,
    on_request: bool = False,
    can_be_meant: bool = False,
    calls: tuple[str, ...] = (),
) -> Callable[[Callable[[Examination], Places]], Rule]:
    """Make a rule of a function, a row of `rules.RULES`."""

    def made(find: Callable[[Examination], Places]) -> Rule:
        return Rule(
            code, severity, title, explanation, source, fix, find, cost, on_request,
            can_be_meant, calls,
        )  # fmt: skip

    return made


def _where(
    mesh: Mesh, block: int | None, cell: int | None, point: int | None
) -> tuple[float, ...] | None:
    """The point, or the centre of those vertices of the cell that exist."""
    if point is not None:
        rows = np.array([point])
    elif block is not None and cell is not None:
        rows = np.asarray(mesh.blocks[block].cells[cell])
        rows = rows[(rows >= 0) & (rows < len(mesh.points))][: n_corners(mesh.blocks[block])]
    else:
        return None
    if not len(rows):
        return None
    with np.errstate(all="ignore"):
        centre = np.asarray(mesh.points[rows], dtype=np.float64).mean(axis=0)
    return tuple(centre.tolist())


def at_cells(
    study: Study,
    cells: Array,
    *messages: str,
    kinds: Array | None = None,
    others: Array | None = None,
) -> Places:
    """Places from a mask over all cells, or from their numbers."""
    numbers = np.flatnonzero(cells) if cells.dtype == bool else cells
    return Places(
        messages,
        cells=study.cells_by(numbers),
        kinds=kinds,
        other_cells=None if others is None else study.cells_by(others),
    )
