"""The JSON report. Its keys are stable and documented in the README."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import Any

from ..quality.census import Census
from ..quality.room import Room
from ..quality.statistics import Statistic
from ..quality.summary import RANKS, Summary
from ..quality.worst import WorstCell
from .metric import metric_dict
from .model import FileFacts, Report


def _number(value: float) -> float | None:
    """A JSON number; null where the figure is infinite."""
    return value if math.isfinite(value) else None


def _file(facts: FileFacts | None) -> dict[str, str] | None:
    return None if facts is None else asdict(facts)


def _room(room: Room | None) -> dict[str, Any] | None:
    if room is None:
        return None
    most = [
        {"where": list(p.where), "Q": _number(p.worst), "allowed": _number(p.allowed)}
        for p in room.places
    ]
    return {"held": room.held, "near": room.near, "most": most}


def _worst(one: WorstCell) -> dict[str, Any]:
    return {
        "cell": one.cell or None,
        "family": one.family,
        "type": one.type or None,
        "where": list(one.where),
        "Q": _number(one.quality),
    }


def _census(census: Census | None) -> dict[str, Any] | None:
    if census is None:
        return None
    degrees = {
        "inner_vertices": census.inner_vertices,
        "boundary_vertices": census.boundary_vertices,
        "inner_edges": census.inner_edges,
    }
    return {
        "constrained": {
            "cells": census.constrained_cells,
            "edges": census.constrained_edges,
            "faces": census.constrained_faces,
        },
        "degrees": {name: asdict(found) for name, found in degrees.items()},
        "simplices": census.n_simplices,
        "obtuse": census.obtuse,
        "self_centered": census.self_centered,
        "quads": census.quads,
    }


def summary_dict(summary: Summary | None) -> dict[str, Any] | None:
    """The figures of one mesh under the keys of the report."""
    if summary is None:
        return None
    return {
        "ne": summary.n_cells,
        "np": summary.n_points,
        "worst": _number(summary.worst),
        "mean": _number(summary.mean),
        "best": _number(summary.best),
        "target": _number(summary.target),
        "invalid": summary.n_invalid,
        "histogram": {
            "edges": [_number(edge) for edge in RANKS],
            "counts": list(summary.counts),
            "percent": list(summary.percent),
        },
        "angle_min": _number(summary.angle_min),
        "angle_max": _number(summary.angle_max),
        "angles_forced": None if summary.forced is None else list(summary.forced),
        "types": summary.types,
        "room": _room(summary.room),
        "census": _census(summary.census),
        "measures": {n: _number(v) for n, v in summary.worst_by_measure.items()},
        "worst_cells": [_worst(one) for one in summary.worst_cells],
        "families": {part.family: summary_dict(part) for part in summary.parts},
    }


def _statistic(statistic: Statistic) -> dict[str, Any]:
    return {
        "measure": statistic.measure,
        "family": statistic.family,
        "unit": statistic.unit,
        "ideal": statistic.ideal,
        "cells": statistic.n_cells,
        "infinite": statistic.n_infinite,
        "least": _number(statistic.least),
        "mean": _number(statistic.mean),
        "greatest": _number(statistic.greatest),
    }


def report_dict(report: Report) -> dict[str, Any]:
    """The report as plain values."""
    result: dict[str, Any] = {
        "meshopt": report.version,
        "input": _file(report.input),
        "output": _file(report.output),
        "measure": report.before.measure,
        "dimension": report.before.dimension,
        "before": summary_dict(report.before),
        "after": summary_dict(report.after),
        "passes": [
            {**asdict(p), "worst": _number(p.worst), "mean": _number(p.mean)} for p in report.passes
        ],
        "statistics": [_statistic(s) for s in report.statistics],
        "statistics_after": [_statistic(s) for s in report.statistics_after],
        "metric": None if report.metric is None else metric_dict(report.metric),
        "metric_after": None if report.metric_after is None else metric_dict(report.metric_after),
        "regions": {"count": report.regions.count, "arrays": list(report.regions.arrays)},
        "stopped": report.stopped or None,
        "seconds": report.seconds,
        "lost": list(report.lost),
        "left_out": list(report.left_out),
    }
    return result


def to_json(reports: list[Report]) -> str:
    """One object for one report, a list for several."""
    values = [report_dict(r) for r in reports]
    return json.dumps(values[0] if len(values) == 1 else values, indent=1) + "\n"
