"""Metrics to judge meshes by."""

from __future__ import annotations

import numpy as np

from meshopt_cli.metric.domain import domain_of
from meshopt_cli.metric.field import Metric, components
from meshopt_cli.metric.summary import judge
from meshopt_cli.quality.measurable import measurable
from meshopt_cli.quality.measures import MEASURES


def of_matrices(matrices):
    """A metric of some tensors, (np, d, d)."""
    return Metric(components(np.asarray(matrices)), "a test")


def tensors_of(matrix, n):
    """A metric that is the same at n vertices."""
    return of_matrices(np.tile(matrix, (n, 1, 1)))


def random_tensors(d, n, spread, seed=0):
    """Tensors (n, d, d) whose logarithms differ by about so much."""
    generator = np.random.default_rng(seed)
    logarithms = spread * generator.normal(size=(n, d, d))
    values, axes = np.linalg.eigh(logarithms + logarithms.transpose(0, 2, 1))
    return np.einsum("nij,nj,nkj->nik", axes, np.exp(values), axes)


def judged(one, metric, measure="aspect-ratio"):
    """A mesh judged by a metric."""
    domain, part = domain_of(one), measurable(one)
    turned = {family: part.is_turned(family) for family in domain.cells}
    return judge(domain, turned, metric, MEASURES[measure])
