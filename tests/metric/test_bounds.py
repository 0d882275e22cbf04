"""Limits of sizes."""

import numpy as np
import pytest

from meshopt_cli.metric.bounds import bounded
from meshopt_cli.metric.field import Metric
from support.metrics import of_matrices, random_tensors


def sizes_of(metric):
    return np.linalg.eigvalsh(metric.matrices) ** -0.5


@pytest.mark.parametrize(("least", "greatest"), [(0.8, 1.2), (0.0, 1.0), (1.0, np.inf), (1.0, 1.0)])
def test_sizes_come_within_the_limits_and_others_stay(least, greatest):
    sizes = np.linspace(0.5, 1.5, 21)[:, None]
    found = bounded(Metric(sizes, "h"), least, greatest).values
    assert ((found >= least) & (found <= greatest)).all()
    within = (sizes >= least) & (sizes <= greatest)
    assert np.array_equal(found[within], sizes[within])


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize(("least", "greatest"), [(0.8, 1.2), (0.0, 1.0), (1.0, np.inf), (1.0, 1.0)])
def test_tensors_keep_their_axes(d, least, greatest):
    metric = of_matrices(random_tensors(d, 200, 0.4))
    found = bounded(metric, least, greatest)
    expected = np.clip(sizes_of(metric), least, greatest)
    assert sizes_of(found) == pytest.approx(expected, rel=1e-12)
    one, other = metric.matrices, found.matrices
    assert one @ other == pytest.approx(other @ one, abs=1e-9)  # which have all axes in common
    stays = (expected == sizes_of(metric)).all(axis=1)
    assert np.array_equal(found.values[stays], metric.values[stays])
    again = bounded(found, least, greatest)
    assert again.values == pytest.approx(found.values, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("least", "greatest"), [(0.0, 1e-300), (0.0, 1e300), (1e-300, np.inf), (1e300, np.inf)]
)
def test_the_farthest_limits_leave_a_metric(least, greatest):
    for metric in (of_matrices(random_tensors(3, 5, 0.4)), Metric(np.ones((5, 1)), "h")):
        found = sizes_of(bounded(metric, least, greatest))
        assert ((found > 1e-46) & (found < 1e46)).all()
