"""What lines and planes have in common, and half-spaces in another order of the vertices."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli.constraints.model import Constraints, meet, slacks
from meshopt_cli.kernels.guide import LINE, PLANE, SPACE, STAYS

X, Y, DIAGONAL, NOTHING = [1, 0, 0], [0, 1, 0], [0.6, 0.8, 0], [0, 0, 0]


@pytest.mark.parametrize(
    ("one", "other", "kind", "direction"),
    [
        ([LINE, *X], [LINE, *X], LINE, X),
        ([LINE, *X], [LINE, *Y], STAYS, None),
        ([LINE, *X], [LINE, *NOTHING], STAYS, None),
        ([LINE, *X], [PLANE, *Y], LINE, X),
        ([PLANE, *Y], [LINE, *X], LINE, X),
        ([LINE, *X], [PLANE, *DIAGONAL], STAYS, None),
        ([PLANE, *X], [PLANE, *X], PLANE, X),
        ([PLANE, *X], [PLANE, *Y], LINE, [0, 0, 1]),
        ([SPACE, *NOTHING], [LINE, *X], LINE, X),
        ([PLANE, *X], [SPACE, *NOTHING], PLANE, X),
        ([STAYS, *NOTHING], [LINE, *X], STAYS, None),
    ],
)
def test_what_is_in_common(one, other, kind, direction):
    found = meet(np.array([one], float), np.array([other], float))[0]
    assert found[0] == kind
    if direction is not None:
        assert np.allclose(np.abs(found[1:]), np.abs(direction))


def test_half_spaces_follow_their_vertices():
    generator = np.random.default_rng(0)
    count = generator.integers(0, 4, 30)
    start = np.concatenate([[0], np.cumsum(count)])
    guide = np.zeros((30, 4))
    guide[count > 0, 0] = SPACE
    told = Constraints(guide, start, generator.normal(size=(start[-1], 4)))
    points, origin = generator.normal(size=(30, 3)), generator.permutation(30)

    def by_vertex(constraints, points, names):
        free = np.zeros(30, dtype=bool)
        rows, slack = slacks(points, constraints.guides(free, None), constraints.limits)
        return sorted(zip(names[rows].tolist(), slack.tolist(), strict=True))

    turned = told.of_rows(origin)
    assert by_vertex(turned, points[origin], origin) == by_vertex(told, points, np.arange(30))
