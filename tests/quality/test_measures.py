"""Every measure of the table: 1 for the regular cell, 0 when flat, blind to all but shape."""

from __future__ import annotations

import math
import warnings
from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli.errors import ConfigError
from meshopt_cli.kernels.judge import measure_cells
from meshopt_cli.kernels.shape.angles import ANGLE_Q, angle_range, angle_sums
from meshopt_cli.kernels.shape.simplex import ASPECT_RATIO
from meshopt_cli.kernels.types import Judge
from meshopt_cli.quality.measures import OF_SIMPLICES, as_degradation, cell_quality, measure_named
from meshopt_cli.work.standing import standing_of
from support.invariants import volumes, workspace
from support.meshes import fan, icosahedron
from support.processes import run_python
from support.settings import examples

REGULAR = {
    2: np.array([[0, 0, 0], [1, 0, 0], [0.5, math.sqrt(3) / 2, 0]]),
    3: np.array([[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]], dtype=float),
}
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)

coordinate = st.integers(-(2**20), 2**20).map(lambda k: k / 2**20)
angle = st.floats(-math.pi, math.pi)
measured = pytest.mark.parametrize("measure", OF_SIMPLICES.values(), ids=list(OF_SIMPLICES))
DRIVING = [measure for measure in OF_SIMPLICES.values() if measure.drives]
driving = pytest.mark.parametrize("measure", DRIVING, ids=lambda measure: measure.name)
in_both = pytest.mark.parametrize("dimension", [2, 3])


def quality(measure, corners):
    """q of one cell."""
    corners = np.ascontiguousarray(corners, dtype=float)
    return float(cell_quality(corners, np.arange(len(corners))[None], measure)[0])


@st.composite
def simplices(draw, dimension, least=0.0):
    """Corners of a positive cell; `least` bounds its volume over that of a cube around it."""
    corners = np.zeros((dimension + 1, 3))
    for corner in corners:
        corner[:dimension] = draw(st.tuples(*[coordinate] * dimension))
    volume = volumes(corners, np.arange(dimension + 1)[None])[0]
    extent = np.ptp(corners, axis=0).max()
    assume(abs(volume) > least * extent**dimension)
    return corners if volume > 0 else corners[[1, 0, *range(2, dimension + 1)]]


@st.composite
def motions(draw, dimension):
    """A rotation, a scale and a translation, as a function of corners."""
    a, b, c = draw(angle), draw(angle), draw(angle)
    turn = rotation(a, 2)
    if dimension == 3:
        turn = turn @ rotation(b, 0) @ rotation(c, 2)
    scale = 2.0 ** draw(st.integers(-20, 20))
    shift = np.array(draw(st.tuples(*[coordinate] * 3))) * scale
    shift[dimension:] = 0
    return lambda corners: scale * corners @ turn.T + shift


def rotation(by, axis):
    """Rotation about a coordinate axis."""
    i, j = (k for k in range(3) if k != axis)
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = math.cos(by)
    matrix[i, j], matrix[j, i] = -math.sin(by), math.sin(by)
    return matrix


def even_permutations(n):
    """Orders of n corners that keep the orientation."""
    for order in permutations(range(n)):
        if sum(a > b for a, b in combinations(order, 2)) % 2 == 0:
            yield list(order)


@measured
@in_both
@examples(20)
@given(data=st.data())
def test_regular(measure, dimension, data):
    """Q is 1 for the regular cell, wherever it is, however it is turned, whatever its size."""
    move = data.draw(motions(dimension))
    assert quality(measure, move(REGULAR[dimension])) == pytest.approx(1, abs=1e-12)


@measured
@in_both
@examples(20)
@given(data=st.data())
def test_only_shape_counts(measure, dimension, data):
    """q does not change with rotation, translation, scale, and the order of the corners."""
    corners = data.draw(simplices(dimension, least=1e-3))
    move = data.draw(motions(dimension))
    q = quality(measure, corners)
    assert quality(measure, move(corners)) == pytest.approx(q, rel=1e-8)
    orders = np.array(list(even_permutations(dimension + 1)))
    np.testing.assert_allclose(cell_quality(corners, orders, measure), q, rtol=1e-8)


@measured
@in_both
@examples(20)
@given(data=st.data())
def test_inverted(measure, dimension, data):
    """Two corners exchanged: q changes its sign, and Q is infinite."""
    corners = data.draw(simplices(dimension, least=1e-3))
    q = quality(measure, corners)
    inverted = quality(measure, corners[[1, 0, *range(2, dimension + 1)]])
    assert 0 < q <= 1 + 1e-12
    assert inverted == pytest.approx(-q, rel=1e-8)
    assert as_degradation(np.array([inverted])) == math.inf


@pytest.mark.parametrize("q", [0.0, 5e-324, -1.0])
def test_cells_that_are_all_but_flat_are_infinitely_bad(q):
    """Numbers whose reciprocal is too large are no reason for a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert as_degradation(np.array([q, 0.5])).tolist() == [math.inf, 2.0]
        assert standing_of(np.array([q, 0.5])).mean == math.inf


@measured
@in_both
@examples(20)
@given(data=st.data())
def test_flat(measure, dimension, data):
    """Corners in a plane, on a line or in one point: 0, and never nan."""
    number = st.integers(-8, 8)
    corners = np.array(data.draw(st.lists(st.tuples(number, number), min_size=4, max_size=4)))
    corners = np.column_stack([corners, np.zeros(4)])[: dimension + 1]
    if dimension == 2:
        corners[:, 1] = 2 * corners[:, 0]
    assert quality(measure, corners) == 0


@measured
@in_both
@examples(60)
@given(data=st.data())
def test_none_is_better_than_regular(measure, dimension, data):
    """q <= 1 for every cell, however thin; and no cell is worse than inverted regular ones."""
    corners = data.draw(simplices(dimension))
    squeeze = 10.0 ** data.draw(st.floats(-16, 0))
    corners[:, data.draw(st.integers(0, dimension - 1))] *= squeeze
    assert abs(quality(measure, corners)) <= 1 + 1e-12


@measured
@examples(60)
@given(shake=st.lists(st.tuples(*[coordinate] * 3), min_size=4, max_size=4), data=st.data())
def test_slivers_are_bad_whatever_measures_them(measure, shake, data):
    """Four corners near a square: q stays within bounds, down to rounding."""
    flat, thin = (10.0 ** data.draw(st.floats(-17, -1)) for _ in range(2))
    corners = SQUARE + np.array(shake) * [flat, flat, thin]
    q = quality(measure, corners)
    assert abs(q) <= 1 + 1e-12
    if measure.drives:
        assert abs(q) < 0.75


@driving
@in_both
def test_degrades(measure, dimension):
    """A measure that drives an optimization falls all the way to a needle and to a plate."""
    for stretch in (1.5, 1 / 1.5):
        cells = [REGULAR[dimension] * [1, stretch**k, 1] for k in range(12)]
        assert np.all(np.diff([quality(measure, c) for c in cells]) < 0)


def test_names():
    """Every measure has its own name, code and equation; unknown ones are refused."""
    assert len({m.judge.code for m in OF_SIMPLICES.values()}) == len(OF_SIMPLICES)
    for name, measure in OF_SIMPLICES.items():
        assert measure_named(name) is measure
        assert measure.name == name
        assert all(way.source for way in measure.ways.values())
    with pytest.raises(ConfigError, match="aspect-ratio"):
        measure_named("beauty")


@in_both
@examples(20)
@given(data=st.data())
def test_angles(dimension, data):
    """The least angle is at most that of the regular cell, the greatest at least."""
    corners = data.draw(simplices(dimension, least=1e-3))
    least, greatest = angle_range(corners, np.arange(dimension + 1)[None])
    regular = math.pi / 3 if dimension == 2 else math.acos(1 / 3)
    assert 0 < least <= regular * (1 + 1e-12)
    assert regular * (1 - 1e-12) <= greatest < math.pi


@pytest.mark.parametrize("times", [1.25, 1.6, 2.0])
@examples(50)
@given(corners=simplices(3, least=1e-6))
def test_a_lenient_measure(times, corners):
    """A Q that is good enough leaves the angles to decide; a worse one is worse than they are."""

    def by(lenience):
        q = np.empty(1)
        measure_cells(Judge(ASPECT_RATIO, lenience), corners, np.arange(4)[None], q)
        return float(q[0])

    q, strict, lenient = by(0.0), by(1.0), by(times)
    enough = 1.0 / (times * ANGLE_Q)
    assert 0.0 < strict <= q
    if q >= enough:
        # Where the angles decided before, they still do.
        assert lenient == strict if strict < q else lenient >= q
    else:
        assert 0.0 <= lenient <= (q / enough) ** 8 / ANGLE_Q


@pytest.mark.parametrize(("ball", "full"), [(fan(7), 2 * math.pi), (icosahedron(), 4 * math.pi)])
def test_angle_sums(ball, full):
    """The cells around an inner vertex fill all that is around it."""
    source = workspace(ball).result()[0]
    sums = np.zeros(len(source.points))
    angle_sums(source.points, source.cells, sums)
    assert sums[0] == pytest.approx(full)
    assert np.all(sums[1:] < full)


BITS = """
import numpy as np
from meshopt_cli.quality.measures import OF_SIMPLICES, cell_quality
points = np.random.default_rng(18).uniform(-1, 1, (400, 3))
flat = points * [1, 1, 0]
points[::7, 2] *= 1e-14
tets, triangles = np.arange(400).reshape(-1, 4), np.arange(399).reshape(-1, 3)
for measure in OF_SIMPLICES.values():
    print(measure.name, cell_quality(points, tets, measure).tobytes().hex())
    print(measure.name, cell_quality(flat, triangles, measure).tobytes().hex())
"""


def test_compiled_as_interpreted():
    """The machine code gives the bits that Python gives."""
    compiled = run_python(BITS).splitlines()
    interpreted = run_python(BITS, NUMBA_DISABLE_JIT="1").splitlines()
    assert len(compiled) == 2 * len(OF_SIMPLICES)
    for one, other in zip(compiled, interpreted, strict=True):
        assert one == other
