"""From values to colours."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.pictures.scale import (
    BACK,
    EDGE_ON,
    FRONT,
    SIDES,
    STOPS,
    UNKNOWN,
    orientation,
    rgb,
    scale_of,
)
from meshopt_cli.quality.measures import LESS, MEASURES, QUALITIES

some_measures = st.sampled_from(sorted(MEASURES))
numbers = st.floats(allow_nan=True, allow_infinity=True)
several = st.lists(numbers, min_size=1, max_size=8).map(np.array)


@pytest.mark.parametrize("measure", QUALITIES.values(), ids=list(QUALITIES))
def test_the_scale_of_a_quality_is_the_same_for_all_meshes(measure):
    one = scale_of(measure, np.array([1.5, math.inf]))
    assert one == scale_of(measure, np.array([7.0]))
    assert one.places(np.array([1.0, 2.0, math.inf])).tolist() == [1.0, 0.5, 0.0]
    assert one.colours(np.array([1.0, math.inf])) == pytest.approx(
        np.array([rgb(STOPS[-1]), rgb(STOPS[0])])
    )


@given(some_measures, several)
def test_places_are_between_the_worst_and_the_best(name, values):
    measure = MEASURES[name]
    scale = scale_of(measure, values)
    places = scale.places(values)
    known = ~np.isnan(values)
    assert (np.isnan(places) == ~known).all()
    assert ((places[known] >= 0.0) & (places[known] <= 1.0)).all()
    colours = scale.colours(values)
    assert colours.shape == (len(values), 3)
    assert ((colours >= 0.0) & (colours <= 1.0)).all()
    assert (colours[~known] == rgb(UNKNOWN)).all()
    for place, label in scale.ticks:
        assert 0.0 <= place <= 1.0
        assert label


@given(some_measures, st.lists(st.floats(1.0, 1e12), min_size=2, max_size=8).map(np.array))
def test_what_is_better_has_a_better_place(name, values):
    measure = MEASURES[name]
    places = scale_of(measure, values).places(values)
    order = np.argsort(-values if measure.better == LESS else values, kind="stable")
    assert (np.diff(places[order]) >= -1e-12).all()
    if not measure.is_quality and values.max() > values.min():
        assert places.min() == pytest.approx(0.0, abs=1e-12)
        assert places.max() == pytest.approx(1.0, abs=1e-12)


def test_sides_have_colours_of_their_own():
    for is_surface in (False, True):
        scale = orientation(is_surface)
        colours = scale.at(np.array([BACK, EDGE_ON, FRONT, 0.1, 0.9]))
        assert colours[:3] == pytest.approx(np.array([rgb(side) for side in SIDES]))
        assert (colours[3:] == colours[[0, 2]]).all()
        assert [place for place, _ in scale.ticks] == [BACK, EDGE_ON, FRONT]
