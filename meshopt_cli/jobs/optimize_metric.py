"""One optimization that a metric drives (18.3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..formats import Source
from ..mesh.cast import Simplices
from ..mesh.model import Array, Mesh
from ..mesh.plane import with_depth
from ..mesh.tags import METRIC
from ..metric.domain import Domain, domain_of
from ..metric.field import Metric, exponential
from ..metric.summary import MetricSummary, judge
from ..plans.pipeline import Pipeline
from ..plans.stop import NOTHING_TO_GAIN
from ..quality.measurable import measurable
from ..quality.measures import Measure
from ..transfer.background import MetricOfInput
from .metric import Asked, metric_on
from .optimize import BackgroundOf, Result

# Figures of a metric may get worse by rounding only.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Driven:
    """A mesh that was driven by a metric.

    Attributes
    ----------
    result : Result
    metric : Metric
        At the points of its mesh: that of the input there.
    """

    result: Result
    metric: Metric


def optimize_in_metric(
    mesh: Mesh,
    source: Source,
    asked: Asked,
    pipeline: Pipeline,
    measure: Measure,
    run: Callable[[Mesh, Pipeline, BackgroundOf], Result],
    max_size: int | None = None,
) -> Driven:
    """Optimize a mesh by a metric.

    The result is not worse than the input: by the efficiency index (18.12), or by the worst Q in
    the metric where no pass fits edges to it. Else it is the input.

    Parameters
    ----------
    source : Source
        The file that the mesh was read from.
    run : function
        Calls `optimize` with a mesh, a pipeline and its `background_of`.
    max_size : int, optional
        See `formats.read`: for the file of the metric.

    Raises
    ------
    ConfigError, ReadError
        See `jobs.metric.judge_by`.
    """
    domain = domain_of(mesh)
    metric = metric_on(asked, mesh, source, domain, max_size)
    # It goes along with the points as their other arrays do, and tensors by their logarithms.
    values = metric.values if metric.is_isotropic else metric.logarithms
    carrying = replace(mesh, point_data={**mesh.point_data, METRIC: values})

    def background_of(part: Simplices, known: Mesh, numbers: Array) -> MetricOfInput:
        return MetricOfInput(part, _taken(known.point_data[METRIC][numbers], metric), asked.size)

    before = _summary(mesh, domain, metric, measure)
    result = run(carrying, pipeline, background_of)
    driven = _driven(result, asked, metric)
    after = _summary_after(driven, measure)
    if _is_worse(before, after, pipeline.needs_metric):
        result = run(carrying, replace(pipeline, stages=()), background_of)
        driven = _driven(replace(result, stopped=NOTHING_TO_GAIN), asked, metric)
        after = _summary_after(driven, measure)
    return replace(driven, result=replace(driven.result, in_metric=(before, after)))


def _taken(values: Array, metric: Metric) -> Metric:
    """A metric from what is carried of it."""
    return Metric(values if metric.is_isotropic else exponential(values), metric.source)


def _driven(result: Result, asked: Asked, metric: Metric) -> Driven:
    """A result without the array that carried the metric, and that."""
    mesh = result.mesh
    data = dict(mesh.point_data)
    carried = _taken(data.pop(METRIC), metric)
    mesh = replace(mesh, point_data=data)
    if asked.size is not None:
        carried = replace(carried, values=asked.size.at(with_depth(mesh.points))[:, None])
    return Driven(replace(result, mesh=mesh), carried)


def _summary_after(driven: Driven, measure: Measure) -> MetricSummary:
    mesh = driven.result.mesh
    return _summary(mesh, domain_of(mesh), driven.metric, measure)


def _summary(mesh: Mesh, domain: Domain, metric: Metric, measure: Measure) -> MetricSummary:
    part = measurable(mesh)
    turned = {family: part.is_turned(family) for family in domain.cells}
    return judge(domain, turned, metric, measure).summary


def _is_worse(before: MetricSummary, after: MetricSummary, fits: bool) -> bool:
    """Whether a mesh is worse than another, in a metric."""
    if before.n_invalid:
        return False
    if fits and not np.isclose(before.edges.tau, after.edges.tau, rtol=0.0, atol=ROUNDING):
        return after.edges.tau < before.edges.tau
    return after.worst > before.worst * (1.0 + ROUNDING)
