"""The least and the greatest size that a metric may ask for."""

from __future__ import annotations

import math

import numpy as np

from .field import GREATEST, LEAST, Metric, components

ROUNDING = 1e-12  # of eigenvalues, which are at a limit after all


def bounded(metric: Metric, least: float = 0.0, greatest: float = math.inf) -> Metric:
    """A metric whose sizes are within limits, those of tensors along each of their axes.

    What is within them stays bit for bit.

    Parameters
    ----------
    least, greatest : float
        In the unit of the coordinates; `least` is not above `greatest`. No metric has sizes beyond
        those that `LEAST` and `GREATEST` are the eigenvalues of.
    """
    least, greatest = np.clip([least, greatest], GREATEST**-0.5, LEAST**-0.5).tolist()
    if metric.is_isotropic:
        return Metric(np.clip(metric.values, least, greatest), metric.source)
    eigenvalues, axes = np.linalg.eigh(metric.matrices)
    low, high = greatest**-2, least**-2
    beyond = eigenvalues[:, 0] < low * (1.0 - ROUNDING)
    beyond |= eigenvalues[:, -1] > high * (1.0 + ROUNDING)
    within, axes = np.clip(eigenvalues[beyond], low, high), axes[beyond]
    values = metric.values.copy()
    values[beyond] = components((axes * within[:, None, :]) @ axes.transpose(0, 2, 1))
    return Metric(values, metric.source)
