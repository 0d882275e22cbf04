"""What is made of a metric before a mesh is judged by it: limits of sizes, and gradation."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from ..errors import ConfigError
from .bounds import bounded
from .domain import Domain
from .field import Metric
from .gradation import graded


@dataclass(frozen=True)
class Shaping:
    """What a metric is to be like.

    Attributes
    ----------
    gradation : float, optional
        See `gradation.graded`.
    size_min, size_max : float, optional
        See `bounds.bounded`.

    Raises
    ------
    ConfigError
        The least size is above the greatest.
    """

    gradation: float | None = None
    size_min: float | None = None
    size_max: float | None = None

    def __post_init__(self) -> None:
        if self._least > self._greatest:
            raise ConfigError(f"--size-min {self._least:g} is above --size-max {self._greatest:g}")

    @property
    def is_idle(self) -> bool:
        """Whether a metric stays as it is."""
        return self == AS_IT_IS

    @property
    def first(self) -> str:
        """The first option that is given."""
        given = [f.name for f in fields(self) if getattr(self, f.name) is not None]
        return f"--{given[0].replace('_', '-')}"

    @property
    def _least(self) -> float:
        return 0.0 if self.size_min is None else self.size_min

    @property
    def _greatest(self) -> float:
        return math.inf if self.size_max is None else self.size_max

    def of(self, metric: Metric, domain: Domain) -> Metric:
        """The metric as it is to be, and in its `source` how many vertices that changed.

        Sizes are graded when they are within the limits, which hold in the end, too: where tensors
        meet, gradation may ask for sizes below those of each.

        Parameters
        ----------
        metric : Metric
            Positive definite wherever cells have a vertex.
        """
        source, used = metric.source, domain.used
        if self.size_min is not None or self.size_max is not None:
            before, metric = metric, bounded(metric, self._least, self._greatest)
            limits = [f"at least {self._least:g}"] * (self.size_min is not None)
            limits += [f"at most {self._greatest:g}"] * (self.size_max is not None)
            source += f"; sizes {' and '.join(limits)} (other {_counted(before, metric, used)})"
        if self.gradation is not None:
            before, metric = metric, graded(metric, domain.points, domain.edges, self.gradation)
            metric = bounded(metric, self._least)
            source += f"; gradation {self.gradation:g} (finer {_counted(before, metric, used)})"
        return Metric(metric.values, source)


AS_IT_IS = Shaping()


def _counted(before: Metric, after: Metric, used: np.ndarray) -> str:
    """At how many vertices of cells a metric changed."""
    changed = (before.values != after.values).any(axis=1) & used
    return f"at {np.count_nonzero(changed):,} of {np.count_nonzero(used):,} vertices"
