"""What `check` looks for: the table of rules, and the search for what breaks them.

Every rule is a function of a `Study`, under a decorator that puts its row into `RULES`.
It returns the `Places` where the rule is broken, as arrays, since there may be many.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from ..errors import ConfigError
from ..mesh import Array, Mesh
from . import contact
from .study import NO_GATES, Gates, Study, n_corners

ERROR = "error"
WARNING = "warning"

MOST_OTHERS = 3  # related cells that a finding names at most


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
    """A row of `RULES`.

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
        What to do about it, one line.
    find : function of a Study
    """

    code: str
    severity: str
    title: str
    explanation: str
    source: str
    fix: str
    find: Callable[[Study], Places]


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


RULES: dict[str, Rule] = {}


def rule(
    code: str, severity: str, title: str, *, explanation: str, fix: str, source: str = ""
) -> Callable[[Callable[[Study], Places]], Callable[[Study], Places]]:
    """Put a function into the table of rules."""

    def enter(find: Callable[[Study], Places]) -> Callable[[Study], Places]:
        RULES[code] = Rule(code, severity, title, explanation, source, fix, find)
        return find

    return enter


def check(
    mesh: Mesh,
    select: Iterable[str] = (),
    ignore: Iterable[str] = (),
    gates: Gates = NO_GATES,
) -> Report:
    """Look for everything that makes a mesh invalid.

    Parameters
    ----------
    mesh : Mesh
        May hold anything; rules that need sound cells look at the sound ones only.
    select : iterable of str
        Codes, or prefixes of codes, of the rules to check; none means all.
    ignore : iterable of str
        Codes or prefixes to leave out of those.
    gates : Gates
        Limits that the user sets.

    Raises
    ------
    ConfigError
        A code or prefix that no rule has.
    """
    wanted = choose(select, ignore)
    with np.errstate(all="ignore"):
        study = Study(mesh, gates)
        found = [Group(row, row.find(study)) for row in wanted]
    return Report(tuple(group for group in found if len(group)))


def choose(select: Iterable[str] = (), ignore: Iterable[str] = ()) -> list[Rule]:
    """The rules that codes and prefixes stand for, in the order of their codes.

    Raises
    ------
    ConfigError
        A code or prefix that no rule has.
    """
    kept, dropped = _matching(select), _matching(ignore)
    return [RULES[code] for code in RULES if (code in kept or not kept) and code not in dropped]


def _matching(prefixes: Iterable[str]) -> set[str]:
    matching: set[str] = set()
    for prefix in prefixes:
        codes = {code for code in RULES if prefix and code.startswith(prefix.upper())}
        if not codes:
            raise ConfigError(f"no rule has the code {prefix!r}; there are {', '.join(RULES)}")
        matching |= codes
    return matching


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


def _at_cells(
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


@rule(
    "M001",
    ERROR,
    "coordinate not finite",
    explanation="A coordinate of a point is infinite or not a number.",
    fix="Find out what wrote the point: most often a division by zero or a failed export.",
)
def find_not_finite(study: Study) -> Places:
    return Places(("a coordinate is not finite",), points=np.flatnonzero(~study.finite))


@rule(
    "M002",
    ERROR,
    "vertex number out of range",
    explanation="A cell names a point that the file does not hold.",
    fix="Write the file again; check whether its vertices are counted from 0 or from 1.",
)
def find_out_of_range(study: Study) -> Places:
    return _at_cells(study, study.out_of_range, "a vertex number is out of range")


@rule(
    "M003",
    ERROR,
    "vertex repeated in a cell",
    explanation="A cell has the same vertex at two of its corners.",
    fix="Remove the cell, or write it as the simpler type that it really is.",
)
def find_repeated(study: Study) -> Places:
    repeated = study.repeated & ~study.out_of_range
    return _at_cells(study, repeated, "a vertex is repeated in the cell")


@rule(
    "M101",
    ERROR,
    "inverted cell",
    explanation="A cell, or a corner of it, has a negative volume, or area in the plane.",
    source="18.1.1, 18.1.2",
    fix="Untangle: optimize moves and swaps inverted cells if their neighbours allow it.",
)
def find_inverted(study: Study) -> Places:
    numbers = np.flatnonzero(study.shape.inverted)
    return _at_cells(
        study,
        numbers,
        "the cell is inverted",
        "the cell is inverted at a corner",
        kinds=study.shape.partly[numbers].astype(np.int64),
    )


@rule(
    "M102",
    ERROR,
    "flat cell",
    explanation="A cell, or a corner of a 3-D cell, has no volume, or area, for its size.",
    source="Remark 18.3",
    fix="Optimize: swaps and collapses remove flat cells; or remove them where they were added.",
)
def find_flat(study: Study) -> Places:
    return _at_cells(study, study.shape.flat, "the cell is flat")


@rule(
    "M103",
    ERROR,
    "the whole mesh has the other orientation",
    explanation="Every cell has a negative volume: the vertices are listed the other way round.",
    source="18.1.2",
    fix="Let optimize turn all cells, or change the order of vertices where the file is written.",
)
def find_turned(study: Study) -> Places:
    n = 1 if study.shape.turned else 0
    return Places(("every cell has the other orientation",), cells=np.full((n, 2), -1))


@rule(
    "M104",
    ERROR,
    "quad not convex",
    explanation="A quad in the plane is not convex, intersects itself, or is degenerate.",
    source="18.1.3, Figure 18.5",
    fix="Smooth the mesh, or split the quad in two triangles.",
)
def find_bad_quads(study: Study) -> Places:
    numbers = np.flatnonzero(study.shape.quads)
    return _at_cells(
        study,
        numbers,
        "the quad is not convex",
        "the quad intersects itself",
        "the quad is degenerate: two consecutive sides are aligned",
        kinds=study.shape.quads[numbers] - 1,
    )


@rule(
    "M201",
    ERROR,
    "duplicate cell",
    explanation="Two cells of the same type have the same vertices.",
    fix="Remove the later one; often a file was joined with itself.",
)
def find_duplicates(study: Study) -> Places:
    later, earlier = study.duplicates
    return _at_cells(study, later, "the cell has the vertices of another", others=earlier[:, None])


@rule(
    "M202",
    ERROR,
    "coincident points",
    explanation="Two points, at least one of them in use, are in the same place.",
    fix="Merge them in the program that made the mesh.",
)
def find_coincident(study: Study) -> Places:
    later = np.flatnonzero(study.first_points != np.arange(study.n_points))
    return Places(
        ("the point is in the place of another",),
        points=later,
        other_points=study.first_points[later][:, None],
    )


@rule(
    "M203",
    WARNING,
    "unused point",
    explanation="A point is no vertex of any cell, or only of one of type vertex.",
    fix="Nothing needs to be done; some solvers refuse such points.",
)
def find_unused(study: Study) -> Places:
    return Places(("the point is not used by any cell",), points=np.flatnonzero(~study.used))


@rule(
    "M204",
    ERROR,
    "facet shared by more than two cells",
    explanation="Three or more cells have a facet in common, so that two of them overlap.",
    source="18.7.1",
    fix="Remove the cell that does not belong there.",
)
def find_crowded(study: Study) -> Places:
    found = [np.empty((0, MOST_OTHERS + 1), dtype=np.int64)]
    for facets in study.facet_sets:
        crowded = facets.count > 2
        start, count = facets.start[crowded, None], facets.count[crowded, None]
        step = np.arange(MOST_OTHERS + 1)[None]
        row = facets.order[np.minimum(start + step, start + count - 1)]
        found.append(np.where(step < count, facets.owners[row], -1))
    # The last of the cells came last; the ones before are named with it.
    cells = -np.sort(-np.concatenate(found), axis=1)
    cells = cells[np.argsort(cells[:, 0], kind="stable")]
    message = "a facet of the cell is shared by more than two cells"
    return _at_cells(study, cells[:, 0], message, others=cells[:, 1:])


@rule(
    "M205",
    ERROR,
    "hanging node or crack",
    explanation="A vertex lies on a facet that does not have it, or two facets coincide.",
    source="18.7.1",
    fix="Merge the points of a crack; split the cell at a hanging node.",
)
def find_hanging(study: Study) -> Places:
    vertices, owners = contact.hanging_nodes(study)
    later, earlier = contact.cracks(study)
    return Places(
        ("a vertex lies on a facet of the cell", "a facet of the cell coincides with another"),
        cells=study.cells_by(np.concatenate([owners, later])),
        points=np.concatenate([vertices, np.full(len(later), -1)]),
        kinds=np.repeat([0, 1], [len(owners), len(later)]),
        other_cells=study.cells_by(np.concatenate([np.full(len(owners), -1), earlier]))[:, None],
    )


@rule(
    "M207",
    ERROR,
    "neighbours disagree in orientation",
    explanation="Two cells run round their common facet in the same direction.",
    source="18.7.1",
    fix="Turn one of them; in the plane or in space they lie on the same side of the facet.",
)
def find_disagreeing(study: Study) -> Places:
    one, other = study.disagreeing
    doubtful = study.explained.copy()
    doubtful[study.duplicates[0]] = True
    keep = ~(doubtful[one] | doubtful[other]) & (not study.shape.turned)
    one, other = one[keep], other[keep]
    # Of the two, the one that disagrees with more of its neighbours is more likely wrong.
    times = np.bincount(np.concatenate([one, other]), minlength=study.n_cells)
    swap = (times[one] > times[other]) | ((times[one] == times[other]) & (one > other))
    cells, first = np.unique(np.where(swap, one, other), return_index=True)
    others = np.where(swap, other, one)[first]
    message = "the cell and a neighbour disagree in orientation"
    return _at_cells(study, cells, message, others=others[:, None])


@rule(
    "M209",
    ERROR,
    "cells overlap",
    explanation="In a planar mesh, boundary edges cross or a boundary vertex is inside a cell.",
    source="18.7.1",
    fix="Remove one of the overlapping cells, or mend the geometry that was meshed.",
)
def find_overlapping(study: Study) -> Places:
    vertices, around = contact.intrusions(study)
    later, earlier = contact.crossings(study)
    later, earlier = np.unique(np.stack([later, earlier]), axis=1)
    return Places(
        ("a boundary vertex lies inside the cell", "a boundary edge of the cell crosses another"),
        cells=study.cells_by(np.concatenate([around, later])),
        points=np.concatenate([vertices, np.full(len(later), -1)]),
        kinds=np.repeat([0, 1], [len(around), len(later)]),
        other_cells=study.cells_by(np.concatenate([np.full(len(around), -1), earlier]))[:, None],
    )


@rule(
    "M401",
    ERROR,
    "cell worse than --fail-above",
    explanation="The Q of the cell is above the limit that was set.",
    source="18.2.1",
    fix="Optimize the mesh, or mesh anew where the boundary forces bad cells.",
)
def find_worse(study: Study) -> Places:
    if study.gates.fail_above is None:
        return Places(("",), cells=np.empty((0, 2), np.int64))
    # The measures are kernels: imported when a limit asks for them.
    from ..quality import DEFAULT_MEASURE, as_degradation, cell_quality, measure_named

    measure = measure_named(study.gates.measure or DEFAULT_MEASURE)
    worse = []
    for one in study.simplices:
        q = cell_quality(study.flat_points, one.cells, measure)
        worse.append(one.numbers[as_degradation(np.abs(q)) > study.gates.fail_above])
    numbers = np.concatenate(worse) if worse else np.empty(0, np.int64)
    return Places((f"Q above {study.gates.fail_above:g}",), cells=study.cells_by(numbers))
