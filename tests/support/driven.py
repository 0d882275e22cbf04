"""Working meshes with a metric."""

from __future__ import annotations

import numpy as np

from meshopt_cli.jobs.optimize import optimize
from meshopt_cli.kernels.types import MAPPED
from meshopt_cli.mesh.cast import cast
from meshopt_cli.metric.field import Metric, components
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.transfer.background import MetricOfInput
from meshopt_cli.work.session import Workspace


def workspace_in(patch, matrices, measure="aspect-ratio", in_order=True, patches=None):
    """A mesh as the kernels see it, in a metric of tensors at its points, (np, d, d)."""
    part = cast(patch)
    background = MetricOfInput(part, Metric(components(np.asarray(matrices)), "a test"))
    judge = QUALITIES[measure].judge._replace(form=MAPPED)
    return Workspace(part, judge, in_order=in_order, background=background, patches=patches)


def layered(points, least=0.03):
    """Tensors of the d columns of points: 0.3 wide along x, and up to ten times less across."""
    n, d = points.shape
    sizes = np.full((n, d), 0.3)
    sizes[:, 1] = least + 0.27 * np.abs(points[:, 1])
    turn = np.eye(d)
    turn[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    return np.einsum("ij,nj,kj->nik", turn, sizes**-2.0, turn)


def adapted(of, metric, policy, preset="adapt", **changes):
    """A mesh driven by a metric, of its points: a function to tensors, (n, d, d).

    Parameters
    ----------
    changes : optional
        Of `jobs.optimize`.
    """
    plan = plan_for(Request(preset=preset), of.dimension())

    def background_of(part, known, numbers):
        values = components(np.asarray(metric(known.points[numbers])))
        return MetricOfInput(part, Metric(values, "a test"))

    return optimize(
        of, plan.pipeline, plan.measure, policy=policy, background_of=background_of, **changes
    )


def in_range(points, edges, metric):
    """The share of some edges whose length, by the metric half way, is in [1/sqrt2, sqrt2]."""
    ends = points[edges]
    e = ends[:, 1] - ends[:, 0]
    size = np.sqrt(np.einsum("ni,nij,nj->n", e, metric(ends.mean(axis=1)), e))
    return float(np.mean((size >= 2**-0.5) & (size <= 2**0.5)))


def same_everywhere(size):
    """The metric of one size."""

    def tensors(points):
        d = points.shape[1]
        return np.tile(np.eye(d) / size**2, (len(points), 1, 1))

    return tensors
