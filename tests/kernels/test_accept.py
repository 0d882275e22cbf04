"""What rules let a change cost."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.kernels import accept

Q = st.floats(1e-6, 1.0)
least = accept.threshold


@given(before=Q, floor=Q)
def test_a_better_mean_makes_nothing_bad(before, floor):
    """What is good stays so, what is not keeps its share, and nothing falls below the floor."""
    allowed = least(accept.MEAN, floor, before)
    assert allowed <= before
    assert allowed >= min(before, floor)
    good = max(accept.GOOD, floor)
    assert allowed == good if before > good else allowed >= accept.KEPT * before


@given(before=Q, floor=Q)
def test_a_floor_is_a_floor(before, floor):
    assert least(accept.FLOOR, floor, before) == pytest.approx(min(before, floor))


@given(before=Q, floor=Q)
def test_rules_in_the_order_of_what_they_allow(before, floor):
    strict, ratio, floor_, valid = (
        least(rule, floor, before)
        for rule in (accept.STRICT, accept.RATIO, accept.FLOOR, accept.VALID)
    )
    assert strict > before >= ratio >= valid
    assert floor_ >= valid
