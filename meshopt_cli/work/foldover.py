"""Global smoothing (18.4.1): all free vertices at once go where no simplex is folded over.

Where some simplex is folded over, vertices go first where |J|² is least, which does not depend on
where they were. From there on eps falls by the rule of Garanzha et al. (2021), by what is least and
by how far the energy fell, until every simplex is positive. Then eps is 0, and the energy a barrier
that nothing passes: vertices go where the sum is least, and then where it is least under limits
closer and closer to the greatest energy of a simplex, which becomes less so (Garanzha et al. 2022,
"Practical lowest distortion mapping").
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..cells import FAMILIES, SIMPLICES
from ..kernels.operators.foldover import (
    corner_qualities,
    find_bad,
    sizes_of_fixed,
    spread_sizes,
    survey,
)
from ..kernels.operators.lbfgs import Memory, minimize
from ..kernels.shape.distortion import Body, Energy

Array = np.ndarray

# With 1/2 hexahedra that were good get worse by the sizes asked for; 1/8 is about as good.
THETA = 1.0 / 128.0
# How much angles alone are looked at: not while simplices are folded over, where 0.5 would take
# several times the steps; no more than so much before there are limits; and at the end. With 0.97
# least angles gain up to 0.1 more, and the longest edges of a cell double.
ANGULAR_WITHOUT_LIMIT = 0.7
ANGULAR = 0.9
LIMITS = (1.5, 1.25, 1.12, 1.06, 1.03, 1.015)  # times the greatest energy of a simplex
TOLERANCE = 1e-6  # least decrease of the energy in a step, as a part of it
MAX_STEPS = 300  # of smoothing
MAX_STEPS_A_LIMIT = 100
MAX_STEPS_AN_EPS = 100
MAX_ROUNDS = 60  # each with another eps
LEAST_EPS = 1e-9
# Of the energy, that a round is taken to have brought. The 0.1 of the authors takes three times the
# rounds, and untangles no more.
LEAST_FALL = 0.3
HARMONIC = 1e6  # eps, as a part of the least det, with which the energy is |J|²
HARMONIC_TOLERANCE = 1e-3
N_REMEMBERED = 9  # steps, the next one included
N_SMOOTHINGS = 50  # of the sizes
MOST_REFIT = 2.0  # of the sizes, to fill the domain
NOISE = 1e-9  # qualities that are as good
LIKE = 1e-4  # part of the least quality that is given up for a better mean: others lift the worst
PLAIN = Energy(1.0, THETA, 0.0, math.inf)


class Corners(NamedTuple):
    """How good simplices are: by the scaled Jacobian where the reference has a right corner.

    By d |det|^(2/d) / |J|² with the sign of det, elsewhere. Both are 1 for the reference.
    """

    least: float
    mean: float  # of the least of each cell


class Record(NamedTuple):
    """What became of the simplices that have a free vertex; others can only stay."""

    n_steps: int  # of all minimizations
    least_before: float  # least det J: measure as a part of that of the reference; inf of none
    least_after: float
    n_bad_before: int  # simplices that were not positive
    n_bad_after: int


def is_better(before: Corners, after: Corners) -> bool:
    """Whether the least quality rose, or it is the same and the mean rose; noise left aside."""
    if abs(after.least - before.least) > NOISE:
        return after.least > before.least
    return after.mean > before.mean + NOISE


def is_liked(before: Corners, after: Corners) -> bool:
    """The same, with a little of the least quality given up."""
    if abs(after.least - before.least) > LIKE * abs(before.least):
        return after.least > before.least
    return after.mean > before.mean + NOISE


def corners_of(
    points: Array, simplices: Array, shapes: Array, shape: Array, cell: Array | None = None
) -> Corners:
    """How good simplices are; the parameters are those of `relocate_all`."""
    return _appraised(body_of(points, simplices, shapes, shape), points, cell)


def relocate_all(
    points: Array,
    simplices: Array,
    shapes: Array,
    shape: Array,
    fixed: Array,
    cell: Array | None = None,
    angular: float = ANGULAR,
    is_over: Callable[[], bool] = lambda: False,
) -> tuple[Array, Record]:
    """Move all free vertices so that no simplex is folded over, then so that the worst gets better.

    Nothing is drawn at random: the same arguments give the same bytes. Points of which all
    simplices are positive come back as they are where nothing better is found. Others may come back
    with fewer that are not, and worse ones among them: the caller is to ask `is_better` of
    `corners_of` both. Where some cannot be made positive, the rest gets better around them.

    What is positive at its corners need not be so inside: parts of a cell (`Family.partitions`) may
    be among the simplices as well.

    Parameters
    ----------
    points : (np, 3) float64
        Finite; z is 0, or the same everywhere, where simplices are triangles.
    simplices : (ns, d + 1) int64
        Triangles or tets, apex first, as the corners of a cell in `cells.FAMILIES`: several a cell,
        or the cell itself. Those of the reference are positive.
    shapes : (k, d, d) float64
        W^-1 of each reference: the columns of W are the edges from the apex. Those of a mesh are
        references of one size, such as cells whose edges are 1: sizes are found here.
    shape : (ns,) int64
        Which of these is the reference of each simplex.
    fixed : (np,) bool
        Vertices that stay, byte by byte. So do those of no simplex. Sizes are taken from the edges
        between fixed vertices.
    cell : (ns,) int64, optional
        Which cell each simplex is of, counted from 0: the mean is of the worst of each. None where
        each is a cell.
    angular : float
        In [0, 1]: how much of the energy of a simplex whose reference has a right corner is of its
        angles alone, the rest being of its proportions too. With 1 cells may become very long.
    is_over : function
        Asked between minimizations: whether to end with what there is.

    Returns
    -------
    points : (np, 3) float64
        New ones; the argument is left alone.
    record : Record

    Raises
    ------
    ValueError
        Some point of a simplex is not finite, or `angular` is out of its range.
    """
    if not 0.0 <= angular <= 1.0:
        raise ValueError("angular is not between 0 and 1")
    used = np.zeros(len(points), dtype=bool)
    used[simplices] = True
    if not np.isfinite(points[used]).all():
        raise ValueError("some point is not finite")
    counts = ~fixed[simplices].all(axis=1)
    free = np.flatnonzero(used & ~fixed)
    # By a power of two: a mesh and its double go the same way.
    _, exponent = np.frexp(np.abs(points[used]).max(initial=0.0))
    work = np.ldexp(points, -exponent)
    whole = body_of(work, simplices, shapes, shape)
    body = whole._replace(
        simplices=whole.simplices[counts],
        shape=whole.shape[counts],
        scale=1.0 / _sizes(whole, work, fixed)[counts],
        free=free,
    )
    work, record = _relocated(body, work, angular, lambda p: _appraised(whole, p, cell), is_over)
    result = points.copy()
    result[free] = np.ldexp(work[free], exponent)
    return result, record


def relocate_simplices(
    points: Array, cells: Array, fixed: Array, is_over: Callable[[], bool]
) -> Array:
    """Where `relocate_all` moves the vertices of simplices, of which regular ones are ideal."""
    dimension = cells.shape[1] - 1
    regular = FAMILIES[SIMPLICES[dimension]].reference
    shapes = np.linalg.inv((regular[1:] - regular[0])[:, :dimension].T)[None]
    kinds = np.zeros(len(cells), np.int64)
    return relocate_all(points, cells, shapes, kinds, fixed, is_over=is_over)[0]


def body_of(points: Array, simplices: Array, shapes: Array, shape: Array) -> Body:
    """Simplices as the kernels see them, their references of size 1 and all vertices free."""
    shapes = np.ascontiguousarray(shapes, dtype=np.float64)
    reference = np.linalg.inv(shapes)
    gram = np.swapaxes(reference, 1, 2) @ reference
    across = gram * (1.0 - np.eye(gram.shape[1]))
    right = np.abs(across).max(axis=(1, 2)) <= 1e-9 * np.abs(gram).max(axis=(1, 2))
    return Body(
        np.ascontiguousarray(simplices, dtype=np.int64),
        shapes,
        np.ascontiguousarray(shape, dtype=np.int64),
        right.astype(np.float64),
        np.ones(len(simplices)),
        np.arange(len(points)),
    )


def memory_for(body: Body, n_points: int) -> Memory:
    """Working space to minimize an energy."""
    n = len(body.free)
    return Memory(
        steps=np.zeros((N_REMEMBERED, n, 3)),
        changes=np.zeros((N_REMEMBERED, n, 3)),
        products=np.zeros(N_REMEMBERED),
        weights=np.zeros(N_REMEMBERED),
        direction=np.zeros((n, 3)),
        trial=np.zeros((n_points, 3)),
        gradient=np.zeros((n_points, 3)),
        other=np.zeros((n_points, 3)),
        stiffness=np.zeros(n_points),
    )


def _appraised(body: Body, points: Array, cell: Array | None) -> Corners:
    """How good simplices are."""
    cell = np.arange(len(body.simplices)) if cell is None else np.ascontiguousarray(cell, np.int64)
    return Corners(*corner_qualities(body, points, cell, np.empty(cell.max(initial=-1) + 1)))


def _relocated(
    body: Body,
    points: Array,
    angular: float,
    judge: Callable[[Array], Corners],
    is_over: Callable[[], bool],
) -> tuple[Array, Record]:
    """The points where they go, and the record."""
    memory = memory_for(body, len(points))
    before = survey(body, points, PLAIN)
    points, n_unfolding = _unfolded(body, points, memory, judge, is_over)
    good = _without_bad(body, points)
    if len(good.free) < len(body.free):
        memory = memory_for(good, len(points))
    points, n_smoothing = _smoothed(good, points, memory, angular, judge, is_over)
    after = survey(body, points, PLAIN)
    n_steps = n_unfolding + n_smoothing
    return points, Record(n_steps, before.least_det, after.least_det, before.n_bad, after.n_bad)


def _without_bad(body: Body, points: Array) -> Body:
    """The body without the simplices that are not positive, whose vertices are to stay."""
    bad = np.zeros(len(body.simplices), dtype=bool)
    if find_bad(body, points, bad) == 0:
        return body
    stays = np.ones(len(points), dtype=bool)
    stays[body.free] = False
    stays[body.simplices[bad]] = True
    counts = ~stays[body.simplices].all(axis=1)  # those that are bad are none of these
    return body._replace(
        simplices=body.simplices[counts],
        shape=body.shape[counts],
        scale=body.scale[counts],
        free=body.free[~stays[body.free]],
    )


def _smoothed(
    body: Body,
    points: Array,
    memory: Memory,
    angular: float,
    judge: Callable[[Array], Corners],
    is_over: Callable[[], bool],
) -> tuple[Array, int]:
    """The best points on the way to where the sum is least and then the worst simplex; the steps.

    All simplices are positive, and stay so.
    """
    best, quality = points, judge(points)
    total = 0
    for part in (math.inf, *LIMITS):
        if is_over():
            break
        points = points.copy()
        first = part == math.inf
        weight = min(angular, ANGULAR_WITHOUT_LIMIT) if first else angular
        free = Energy(0.0, THETA, weight, math.inf)
        how = free._replace(limit=part * survey(body, points, free).greatest)
        most = MAX_STEPS if first else MAX_STEPS_A_LIMIT
        _, n_steps = minimize(body, points, how, TOLERANCE, most, memory)
        total += n_steps
        now = judge(points)
        if is_liked(quality, now):
            best, quality = points, now
    return best, total


def _unfolded(
    body: Body,
    points: Array,
    memory: Memory,
    judge: Callable[[Array], Corners],
    is_over: Callable[[], bool],
) -> tuple[Array, int]:
    """The points where no simplex is folded over, or as few as could be; and the steps."""
    before = survey(body, points, PLAIN)
    if before.n_bad == 0:
        return points, 0
    harmonic = points.copy()
    eps = HARMONIC * max(1.0, abs(before.least_det))
    how = Energy(eps, 0.0, 0.0, math.inf)
    _, n_steps = minimize(body, harmonic, how, HARMONIC_TOLERANCE, MAX_STEPS, memory)
    found, fewest = points, before.n_bad
    for start in (harmonic, points.copy()):
        n_steps += _unfold(body, start, memory, is_over)
        n_bad = survey(body, start, PLAIN).n_bad
        if n_bad < fewest or (n_bad == fewest and is_better(judge(found), judge(start))):
            found, fewest = start, n_bad
        if n_bad == 0:
            break
    return found, n_steps


def _unfold(body: Body, points: Array, memory: Memory, is_over: Callable[[], bool]) -> int:
    """Move the points until no simplex is folded over; the number of steps."""
    eps = 1.0
    n_steps = 0
    for _ in range(MAX_ROUNDS):
        how = PLAIN._replace(eps=eps)
        before = survey(body, points, how)
        if before.n_bad == 0 or eps < LEAST_EPS or is_over():
            break
        _, n = minimize(body, points, how, TOLERANCE, MAX_STEPS_AN_EPS, memory)
        n_steps += n
        after = survey(body, points, how)
        eps = _next_eps(eps, after.least_det, 1.0 - after.energy / before.energy)
    return n_steps


def _next_eps(eps: float, least: float, fall: float) -> float:
    """With which the chi of the least det falls by as much as the energy did."""
    root = math.hypot(eps, least)
    chi = 0.5 * (least + root) if least >= 0.0 else 0.5 * eps * eps / (root - least)
    goal = (1.0 - max(fall, LEAST_FALL)) * chi
    return 2.0 * math.sqrt(goal * (goal - least)) if least < goal else 0.0


def _sizes(body: Body, points: Array, fixed: Array) -> Array:
    """The size of the reference of each simplex, (ns,) float64.

    It is that of the edges between fixed vertices; vertices that have none take the mean of their
    neighbours. All of them together fill the domain. Where no edge is fixed they are equal.
    """
    reference = np.linalg.inv(body.shapes)
    d = reference.shape[1]
    ends = np.concatenate([np.zeros((len(reference), 1, d)), np.swapaxes(reference, 1, 2)], axis=1)
    lengths = np.linalg.norm(ends[:, :, None] - ends[:, None], axis=-1)
    totals, weights = np.zeros((2, len(points)))
    sizes_of_fixed(body, points, fixed, lengths, totals, weights)
    kept = weights > 0.0
    edges = (points[body.simplices[:, 1:]] - points[body.simplices[:, :1]])[..., :d]
    content = np.linalg.det(edges) * np.linalg.det(body.shapes)[body.shape]
    if not kept.any():
        square = np.mean(edges**2) * d / np.mean(lengths[:, 0, 1:] ** 2) if len(edges) else 0.0
        size = content.mean() ** (1.0 / d) if content.sum() > 0.0 else math.sqrt(square)
        return np.full(len(edges), size or 1.0)
    values = np.where(kept, totals / np.maximum(weights, 1.0), 0.0)
    known = kept.copy()
    totals[:] = weights[:] = 0.0
    while spread_sizes(body, kept, values, known, totals, weights):
        pass
    for _ in range(N_SMOOTHINGS):
        spread_sizes(body, kept, values, known, totals, weights)
    values[~known] = values[kept].mean()
    sizes = np.exp(values[body.simplices].mean(axis=1))
    refit = (max(content.sum(), 0.0) / (sizes**d).sum()) ** (1.0 / d)
    return sizes * min(max(refit, 1.0 / MOST_REFIT), MOST_REFIT)
