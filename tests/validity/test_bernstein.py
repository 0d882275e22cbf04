"""Bernstein coefficients: bounds that hold, and decisions that they lead to."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli.validity.bernstein import ABOVE, NOT_ABOVE, basis
from support.settings import examples

KINDS = [((1,), (4,)), ((2,), (2,)), ((3,), (3,)), ((1, 1), (3, 3)), ((2, 1), (4, 2)),
         ((1, 1, 1), (2, 2, 2)), ((1, 1, 1), (3, 3, 1)), ((2, 1), (3, 0))]  # fmt: skip
kinds = st.sampled_from(KINDS)
seeds = st.integers(0, 2**32 - 1)


def polynomial(kind, seed):
    """A random polynomial of the degrees of a kind, as a function of (n, d) coordinates."""
    generator = np.random.default_rng(seed)
    factors, degrees = kind
    terms = [(generator.normal(), [generator.normal(size=(p, w + 1)) for w, p in
              zip(factors, degrees, strict=True)]) for _ in range(6)]  # fmt: skip

    def at(points):
        total = np.zeros(len(points))
        for weight, linear in terms:
            value, start = np.full(len(points), weight), 0
            for width, forms in zip(factors, linear, strict=True):
                own = points[:, start : start + width]
                for form in forms:
                    value = value * (own @ form[1:] + form[0])
                start += width
            total += value
        return total

    return at


def samples(factors, n=400):
    generator = np.random.default_rng(1)
    parts = [generator.dirichlet(np.ones(width + 1), n)[:, 1:] for width in factors]
    return np.concatenate(parts, axis=1)


@examples(60)
@given(kinds, seeds)
def test_coefficients_bound_the_polynomial(kind, seed):
    of, own = polynomial(kind, seed), basis(*kind)
    values = of(own.points)
    (coefficients,) = own.coefficients(values[None])
    size = np.abs(coefficients).max()
    seen = of(samples(kind[0]))
    assert coefficients.min() - 1e-9 * size <= seen.min()
    assert seen.max() <= coefficients.max() + 1e-9 * size
    assert coefficients[own.corners] == pytest.approx(values[own.corners], abs=1e-9 * size)
    assert own.weights @ values == pytest.approx(coefficients.mean(), abs=1e-9 * size)


@examples(60)
@given(kinds, seeds)
def test_parts_are_bounded_more_closely(kind, seed):
    of, own = polynomial(kind, seed), basis(*kind)
    coefficients = own.coefficients(of(own.points)[None])
    parts = own.divided(coefficients)[0]
    size = np.abs(coefficients).max()
    assert coefficients.min() <= parts.min() + 1e-9 * size
    assert parts.max() <= coefficients.max() + 1e-9 * size
    assert parts.min() <= of(samples(kind[0])).min() + 1e-9 * size
    # The mean of a polynomial is that of its means on parts of one size.
    assert parts.mean() == pytest.approx(coefficients.mean(), abs=1e-9 * size)
    n_simplices = {1: 2, 2: 4, 3: 8}
    expected = np.prod([n_simplices[w] if p else 1 for w, p in zip(*kind, strict=True)])
    assert len(parts) == expected


@examples(60)
@given(kinds, seeds, st.floats(-1, 1))
def test_what_is_judged_is_true(kind, seed, level):
    of, own = polynomial(kind, seed), basis(*kind)
    coefficients = own.coefficients(of(own.points)[None])
    seen = of(samples(kind[0], 2000)).min()
    size = np.abs(coefficients).max()
    bound = seen + level * size
    verdict, least = own.judge(coefficients, np.array([bound]))
    if level > 0:
        assert verdict[0] == NOT_ABOVE
        assert least[0] <= bound
    assume(abs(level) > 0.2)
    assert verdict[0] == (ABOVE if level < 0 else NOT_ABOVE)


@pytest.mark.parametrize("touch", [0.5, 1 / 3, 0.7123])
@pytest.mark.parametrize(("by", "expected"), [(1e-9, ABOVE), (-1e-9, NOT_ABOVE)])
def test_touching_in_a_point(touch, by, expected):
    own = basis((1,), (2,))
    coefficients = own.coefficients(((own.points[:, 0] - touch) ** 2)[None])
    assert own.judge(coefficients, np.array([-by]))[0] == expected


@pytest.mark.parametrize(("by", "expected"), [(1e-4, ABOVE), (-1e-4, NOT_ABOVE)])
def test_touching_along_a_line(by, expected):
    own = basis((1, 1), (2, 2))
    values = (own.points @ [1.0, -0.7] - 0.123) ** 2
    coefficients = own.coefficients(values[None])
    assert own.judge(coefficients, np.array([-by]))[0] == expected
    assert own.judge(coefficients, np.array([1e-13]))[0] != ABOVE


def test_many_at_once_are_judged_as_each_alone():
    own = basis((1, 1), (3, 3))
    generator = np.random.default_rng(0)
    coefficients = generator.uniform(-0.2, 1, (300, 16))
    bound = generator.uniform(-0.1, 0.1, 300)
    together, least = own.judge(coefficients, bound)
    alone = [own.judge(coefficients[[k]], bound[[k]]) for k in range(300)]
    assert together.tolist() == [verdict[0] for verdict, _ in alone]
    assert set(together) == {ABOVE, NOT_ABOVE}
    assert ((least <= bound) == (together == NOT_ABOVE)).all()
