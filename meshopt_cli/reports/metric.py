"""What is told of a mesh in a metric, for every output."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

from ..errors import shown
from ..metric.lengths import RANKS as LENGTH_RANKS
from ..metric.lengths import Lengths
from ..metric.summary import MetricSummary, Nearness
from ..quality.summary import RANKS
from .model import Report
from .rows import HEADINGS, figure, value

LENGTH_RANK_HEADINGS = tuple(
    f"> {low:g}" if math.isinf(high) else f"{low:.3g} - {high:.3g}"
    for low, high in pairwise(LENGTH_RANKS)
)
LENGTH_HEADINGS = ("in the metric", "edges", "tau", "0.71 - 1.41", "least", "mean", "greatest")
CSV_HEADINGS = ("tau", "tau inner", "unit edges", "unit edges inner", "length least",
                "length mean", "length greatest", *(f"metric {rank}" for rank in HEADINGS[:4]),
                "metric Q_T", "metric mean", "metric content", "unit cells")  # fmt: skip


def metrics(report: Report) -> list[tuple[str, MetricSummary]]:
    """What is told of the mesh in a metric, or of two, before and after, with their names."""
    found = [("before", report.metric), ("after", report.metric_after)]
    told = [(name, metric) for name, metric in found if metric is not None]
    return told if len(told) > 1 else [("", metric) for _, metric in told]


def length_rows(metric: MetricSummary) -> list[list[str]]:
    """Of all edges and of those inside: how many, tau, percent within a factor of sqrt(2) of 1,
    and lengths."""
    return [
        [name, f"{e.n_edges:,}", _part(e.tau, 4), _part(100.0 * e.share, 1),
         *map(value, (e.least, e.mean, e.greatest))]
        for name, e in (("all edges", metric.edges), ("inner edges", metric.inner))
    ]  # fmt: skip


def _part(number: float, digits: int) -> str:
    return "-" if math.isnan(number) else f"{number:.{digits}f}"


def metric_lines(metric: MetricSummary) -> list[str]:
    """Q in a metric, how many cells there should be, and how far cells are from unit ones."""
    total = max(sum(metric.counts), 1)
    ranks = ", ".join(
        f"{heading}: {100.0 * count / total:.1f} %"
        for heading, count in zip(HEADINGS[:4], metric.counts, strict=True)
    )
    return [
        f"metric of {metric.kind}: {shown(metric.source)}",
        f"Q in the metric, {metric.measure.replace('-', ' ')}: worst {figure(metric.worst)}, "
        f"mean {figure(metric.mean)}; {ranks}",
        f"content in the metric {value(metric.content)}: that of {metric.n_unit:,.0f} unit cells, "
        f"and there are {metric.n_cells:,}",
        f"unit cells, to a factor of sqrt(2): {_near(metric.unit)}",
        f"optimal cells, to a factor of sqrt(2): {_near(metric.optimal)}",
    ]


def _near(near: Nearness) -> str:
    return (
        f"{100.0 * near.share:.1f} %; off by {near.mean:.3f} on average, {near.worst:.3f} at most"
    )


def csv_values(metric: MetricSummary | None) -> list[Any]:
    """The columns of `CSV_HEADINGS`."""
    if metric is None:
        return [""] * len(CSV_HEADINGS)
    e, inner = metric.edges, metric.inner
    return [e.tau, inner.tau, e.share, inner.share, e.least, e.mean, e.greatest, *metric.counts,
            metric.worst, metric.mean, metric.content, metric.n_unit]  # fmt: skip


def metric_dict(metric: MetricSummary) -> dict[str, Any]:
    """The figures as plain values for JSON, null where one is not defined."""
    total = max(sum(metric.counts), 1)
    return {
        "kind": metric.kind,
        "source": metric.source,
        "edges": _lengths(metric.edges),
        "inner_edges": _lengths(metric.inner),
        "measure": metric.measure,
        "worst": _number(metric.worst),
        "mean": _number(metric.mean),
        "best": _number(metric.best),
        "invalid": metric.n_invalid,
        "histogram": _histogram(RANKS, metric.counts, total),
        "content": metric.content,
        "unit_cells": metric.n_unit,
        "ne": metric.n_cells,
        "unit": _nearness(metric.unit),
        "optimal": _nearness(metric.optimal),
    }


def _lengths(lengths: Lengths) -> dict[str, Any]:
    return {
        "count": lengths.n_edges,
        "tau": _number(lengths.tau),
        "share": _number(lengths.share),
        "least": _number(lengths.least),
        "mean": _number(lengths.mean),
        "greatest": _number(lengths.greatest),
        "histogram": _histogram(LENGTH_RANKS, lengths.counts, max(lengths.n_edges, 1)),
    }


def _histogram(
    ranks: tuple[float, ...], counts: tuple[int, ...], total: int
) -> dict[str, list[Any]]:
    percent = [100.0 * count / total for count in counts]
    return {"edges": [_number(r) for r in ranks], "counts": list(counts), "percent": percent}


def _nearness(near: Nearness) -> dict[str, float]:
    return {"worst": near.worst, "mean": near.mean, "share": near.share}


def _number(number: float) -> float | None:
    return number if math.isfinite(number) else None
