"""Histograms of the values of measures."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.jobs.report import Wanted, report_on
from meshopt_cli.quality.measures import DEGREES, NUMBER
from meshopt_cli.quality.statistics import MOST_SPAN, N_BINS, Histogram, histogram_of

values = st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=50)


@given(values | st.lists(st.floats(0, 360), min_size=1), st.sampled_from([NUMBER, DEGREES]))
def test_every_value_is_in_a_bin(found, unit):
    found = np.array(found)
    histogram = histogram_of(found, unit)
    if histogram is None:
        assert float(found.max()) - float(found.min()) > MOST_SPAN
        return
    assert sum(histogram.counts) == len(found)
    assert len(histogram.edges) == len(histogram.counts) + 1
    assert histogram.edges[0] <= found.min()
    assert found.max() <= histogram.edges[-1]
    if len(histogram.counts) > 1:
        assert all(a < b for a, b in pairwise(histogram.edges))
    for (a, b), count in zip(pairwise(histogram.edges), histogram.counts, strict=True):
        assert count <= np.count_nonzero((a <= found) & (found <= b))


def test_bins_are_even_or_by_the_logarithm():
    even = histogram_of(np.array([1.0, 2.0, 4.0]), NUMBER)
    wide = histogram_of(np.array([1.0, 2.0, 1e6]), NUMBER)
    assert (even.is_logarithmic, wide.is_logarithmic) == (False, True)
    assert len(even.counts) == len(wide.counts) == N_BINS
    assert even.counts[0] == even.counts[10] == even.counts[-1] == 1
    assert not histogram_of(np.array([-1.0, 1e6]), NUMBER).is_logarithmic


@pytest.mark.parametrize(("greatest", "end"), [(3.0, 180.0), (180.0, 180.0), (181.0, 360.0)])
def test_angles_of_all_meshes_have_the_same_bins(greatest, end):
    histogram = histogram_of(np.array([1.0, greatest]), DEGREES)
    assert (histogram.edges[0], histogram.edges[-1], len(histogram.counts)) == (0.0, end, 36)


def test_values_that_are_all_one_have_one_bin():
    assert histogram_of(np.full(7, 2.5), NUMBER) == Histogram((2.5, 2.5), (7,))
    assert histogram_of(np.empty(0), NUMBER) is None


def test_histograms_are_made_where_they_are_asked_for(samples):
    path = samples / "tangled.vtk"
    for asked in (False, True):
        (one,) = report_on(path, Wanted(("aspect-ratio",), with_histograms=asked)).statistics
        assert (one.histogram is not None) == asked
    assert one.n_infinite
    assert sum(one.histogram.counts) == one.n_cells - one.n_infinite
