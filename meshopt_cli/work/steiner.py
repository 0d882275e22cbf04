"""The triangulation in which Steiner points are looked for, and the search for them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..handles import OUTER
from ..kernels.steiner import net as columns
from ..kernels.steiner.anneal import anneal, measure_all
from ..kernels.steiner.net import Goal, Net, Schedule
from ..mesh import adjacency
from .session import Workspace

Array = np.ndarray

LOGGED = 8192  # rows of cells that one change may write
CHUNK = 20_000  # tries between which progress is shown and interrupts act

# Tries for each obtuse triangle, and for all. With half of them a fifth more vertices come.
TRIES = 100_000
MOST_TRIES, MORE_TRIES = 10_000_000, 10_000
# Temperatures from which and to which the search cools down, in what an obtuse triangle costs;
# from 0.3 on a third more vertices come, from 0.1 on some triangles stay obtuse.
HOT, COLD = 0.2, 0.02
WARM = 0.1  # from where vertices are saved again
PRICE = 0.4  # of a vertex; 0.2: a third more of them, 0.7: obtuse triangles stay
FOCUS = 0.85
# What is tried in turn where some stay: prices and temperatures, at these triangles alone.
RESCUES = ((0.2, 0.15), (0.15, 0.25), (0.1, 0.4))
MOST_RESCUES = 9
RESCUE_TRIES = 300_000


@dataclass
class Search:
    """A search for Steiner points on one triangulation.

    Attributes
    ----------
    advanced : callable
        Told of the tries that were made; may raise to end it.
    best : Net
        The best triangulation that was found; none is worse than at the beginning.
    tries, kept : int
        What was tried, and kept.
    """

    net: Net
    goal: Goal
    advanced: Callable[[int], None]
    tries: int = 0
    kept: int = 0

    def __post_init__(self) -> None:
        measure_all(self.net, self.goal)
        self._first = self._standing = self._now()
        self.best = self._copied()

    @property
    def n_bad(self) -> int:
        """How many triangles of the best triangulation are obtuse."""
        return self._standing[0]

    @property
    def is_better(self) -> bool:
        """Whether it is better than the triangulation at the beginning."""
        return self._standing < self._first

    def run(self) -> None:
        """Search until no triangle is obtuse, or in vain."""
        tries = n_tries(self.n_bad)
        self._cool(self.goal.price, HOT, COLD, tries, FOCUS)
        for k in range(MOST_RESCUES):
            if self.n_bad == 0:
                break
            price, heat = RESCUES[k % len(RESCUES)]
            self._go_back()
            self._cool(price, heat, 0.6 * heat, RESCUE_TRIES, 1.0)
            if self.n_bad == 0:
                self._go_back()
                self._cool(self.goal.price, WARM, COLD, tries, FOCUS)

    def _now(self) -> tuple[int, int]:
        state = self.net.state
        return int(state[columns.N_BAD]), int(state[columns.N_VERTICES])

    def _copied(self) -> Net:
        return self.net._replace(**{
            name: value.copy()
            for name, value in self.net._asdict().items() if isinstance(value, np.ndarray)
        })  # fmt: skip

    def _go_back(self) -> None:
        """Go on from the best, with other random numbers."""
        random = self.net.state[columns.RANDOM]
        for mine, best in zip(self.net, self.best, strict=True):
            np.copyto(mine, best)
        self.net.state[columns.RANDOM] = random

    def _cool(self, price: float, hot: float, cold: float, tries: int, focus: float) -> None:
        goal = self.goal._replace(price=price)
        first = 0
        while first < tries:
            until = min(first + CHUNK, tries)
            schedule = Schedule(first, until, tries, hot, cold, focus, *self._standing)
            done, kept, is_better = anneal(self.net, goal, schedule)
            first += done
            self.tries += done
            self.kept += kept
            if is_better:
                self._standing = self._now()
                for mine, best in zip(self.net, self.best, strict=True):
                    np.copyto(best, mine)
            self.advanced(done)


def n_tries(n_bad: int) -> int:
    """Tries for so many obtuse triangles."""
    return min(TRIES * n_bad, MOST_TRIES + MORE_TRIES * n_bad)


def goal_for(work: Workspace, least_angle: float, is_fine: bool, most: int) -> Goal:
    """What is wanted of the triangles of a working mesh.

    Parameters
    ----------
    least_angle : float
        In degrees: none below it comes to be where there is none before.
    is_fine : bool
        Whether smaller ones cost as much as obtuse ones; in a coarse mesh they cost next to
        nothing, for there it would take many vertices to do without.
    """
    least = math.sin(math.radians(least_angle))
    corners = work.mesh.points[work.corners(work.living())]
    edges = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(edges, axis=2)
    twice = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    sines = twice * lengths.min(axis=1) / lengths.prod(axis=1)
    floor = least if float(sines.min()) >= least else columns.FLATTEST
    rounding = 1.0 - 1e-9
    return Goal(
        judge=work.mesh.judge,
        least_q=work.worst_of_all * rounding,
        floor=floor * rounding,
        least=least,
        sharp=2.0 if is_fine else 0.05,
        price=PRICE,
        most=most,
        single=work.mesh.single,
    )


def net_for(work: Workspace, n_new: int) -> Net:
    """The triangulation of a working mesh, whose edges may be split where it says so."""
    assert work.splittable is not None
    rows, n = work.living(), work.n_points
    keys = adjacency.distinct(adjacency.row_keys(work.splittable, n))
    net = net_of(
        work.mesh.points[:n], work.corners(rows), work.mesh.region[rows],
        work.mesh.neighbours[rows] < 0, work.mesh.fixed[:n], keys, n_new, work.clock,
    )  # fmt: skip
    net.vertices[work.n_input_points :, columns.OWN] = 0
    net.state[columns.N_INPUT] = work.n_input_points
    return net


def put_back(work: Workspace, net: Net) -> None:
    """Let a working mesh be what became of its triangulation."""
    assert work.splittable is not None
    table = net.cells[net.cells[:, columns.ALIVE] == 1]
    n_input = work.n_input_points
    is_new = (net.vertices[:, columns.VERTEX_ALIVE] == 1) & (net.vertices[:, columns.OWN] == 0)
    new = np.flatnonzero(is_new)
    number = np.arange(len(net.points))
    number[new] = n_input + np.arange(len(new))
    points = np.concatenate([work.mesh.points[:n_input], net.points[new]])
    points[:n_input] = net.points[:n_input]
    cells = np.ascontiguousarray(number[table[:, :3]])
    borders = table[:, columns.BORDER : columns.REGION]
    parts = number[adjacency.facets_at(table[:, :3], borders >= 0)]
    whole = borders[borders >= 0]
    _, first = np.unique(adjacency.row_keys(parts, len(points)), return_index=True)
    parts, whole = parts[first], whole[first]
    order = np.argsort(whole, kind="stable")
    parts, whole = parts[order], whole[order]
    ends = np.searchsorted(whole, np.arange(len(net.borders) + 1))

    def split(edges: Array) -> Array:
        """What became of some edges; those that are no borders stay."""
        place = adjacency.places_in(net.borders[:, :2], edges, len(net.points))
        pieces = [parts[ends[k] : ends[k + 1]] for k in place[place >= 0].tolist()]
        return np.concatenate([number[edges[place < 0]], *pieces]).astype(np.int64)

    facets, splittable = split(work.facets), split(work.splittable)
    work.put(points, cells, table[:, columns.REGION].copy(), facets, splittable)


def net_of(
    points: Array, cells: Array, region: Array, bordered: Array, fixed: Array, may_split: Array,
    n_new: int, seed: int,
) -> Net:  # fmt: skip
    """The triangulation of some cells.

    Parameters
    ----------
    points : (np, 3) float64
        With z = 0.
    cells : (ne, 3) int64
    bordered : (ne, 3) bool
        Which edges are borders, that stay.
    fixed : (np,) bool
        Vertices that stay, those of borders apart.
    may_split : (k,) int64
        Keys (`adjacency.row_keys`) of the edges that may be split, sorted.
    n_new : int
        Vertices that there is to be room for.
    """
    n_points, n_cells = len(points), len(cells)
    rows, capacity = n_points + n_new + 64, n_cells + 2 * n_new + 256
    edges = adjacency.facets(cells)[bordered.ravel()]
    keys = adjacency.row_keys(edges, n_points)
    distinct = adjacency.distinct(keys)
    borders = np.stack(
        [distinct // n_points, distinct % n_points, np.isin(distinct, may_split)], axis=1
    )
    number = np.full(bordered.size, columns.NO_BORDER)
    number[bordered.ravel()] = np.searchsorted(distinct, keys)
    beyond = adjacency.neighbours(cells, np.zeros(n_cells, np.int64), n_points)
    table = np.zeros((capacity, columns.WIDTH), np.int64)
    table[:, columns.ALIVE] = table[:, columns.PLACE] = -1
    table[:n_cells, :3] = cells
    table[:n_cells, columns.BEYOND : columns.BORDER] = np.where(beyond < 0, OUTER, beyond)
    table[:n_cells, columns.BORDER : columns.REGION] = number.reshape(-1, 3)
    table[:n_cells, columns.REGION] = region
    table[:n_cells, columns.ALIVE] = 1
    vertices = np.full((rows, 4), -1)
    used = adjacency.distinct(cells)
    vertices[cells.ravel(), columns.CELL] = np.repeat(np.arange(n_cells), 3)
    vertices[used, columns.VERTEX_ALIVE] = 1
    vertices[:n_points, columns.OWN] = 1
    vertices[:n_points, columns.LINE] = np.where(fixed, columns.FIXED_VERTEX, columns.FREE_VERTEX)
    vertices[borders[:, :2], columns.LINE] = columns.FIXED_VERTEX
    places = np.zeros((rows, 3))
    places[:n_points] = points
    state = np.zeros(columns.N_STATE, np.int64)
    state[columns.N_ROWS] = n_cells
    state[columns.N_POINTS] = state[columns.N_INPUT] = n_points
    state[columns.N_VERTICES] = len(used)
    state[columns.RANDOM] = 1 + seed % 2147483646
    return Net(
        points=places,
        vertices=vertices,
        cells=table,
        cost=np.zeros(capacity),
        bad=np.zeros(capacity, np.int64),
        spare=np.zeros(capacity, np.int64),
        spare_points=np.zeros(rows, np.int64),
        borders=np.ascontiguousarray(borders.astype(np.int64)),
        log=np.zeros((LOGGED, columns.WIDTH + 1), np.int64),
        log_cost=np.zeros(LOGGED),
        point_log=np.zeros((LOGGED, 5), np.int64),
        log_points=np.zeros((LOGGED, 3)),
        state=state,
        total=np.zeros(2),
    )
