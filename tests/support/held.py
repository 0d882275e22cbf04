"""What a run must leave of a mesh of several kinds, told by coordinates."""

from __future__ import annotations

import numpy as np

from meshopt_cli.boundary.policy import Fixed
from meshopt_cli.jobs import optimize as job
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Mesh
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.validity import check


def optimized_as(of, policy=Fixed(), allowed=(), **request):  # noqa: B008 (a frozen value)
    """The result of a whole run."""
    plan = plan_for(Request(**request), of.dimension())
    return job.optimize(of, plan.pipeline, plan.measure, policy=policy, allowed=allowed)


def shaken_where_free(of, amount, seed=0):
    """A mesh whose vertices are moved at random, but for those that a run may not move either."""
    source = cast(of)
    free = np.zeros(len(of.points), dtype=bool)
    free[source.cells] = True
    free[source.skin] = free[source.edges] = free[source.fixed] = False
    points = of.points.copy()
    step = np.random.default_rng(seed).uniform(-amount, amount, (int(free.sum()), points.shape[1]))
    if source.frame is not None:
        step[:, 2:] = 0.0
    points[free] += step
    return Mesh(points, of.blocks, of.point_data)


def places_of(of, kind):
    """The cells of a type by the places of their vertices, in the order of the file."""
    return [
        [tuple(of.points[v].tolist()) for v in cell]
        for block in of.blocks
        if block.type == kind
        for cell in block.cells
    ]


def counts(of):
    """How often each rule of check is broken."""
    return {group.code: len(group) for group in check(of).groups}


def doubled_places(of):
    """The places where more than one point lies, and how many do."""
    places, count = np.unique(of.points, axis=0, return_counts=True)
    return [(tuple(place), n) for place, n in zip(places.tolist(), count.tolist(), strict=True)
            if n > 1]  # fmt: skip
