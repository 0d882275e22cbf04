"""Sizes by a formula: what it may have, and that nothing else is run."""

import time

import numpy as np
import pytest

from meshopt_cli.errors import ConfigError
from meshopt_cli.metric.formula import LONGEST, formula_of

POINTS = np.array([[0.0, 0.5, 1.0], [1.0, 2.0, -1.0], [0.25, 0.1, 3.0]])
X, Y, Z = POINTS.T


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0.01+0.19*x", 0.01 + 0.19 * X),
        ("  2 ", 2.0 + 0 * X),
        ("-x**2/4 - y*z", -(X**2) / 4 - Y * Z),
        ("2**-1", 0.5 + 0 * X),
        ("min(0.1, x + 1, z**2)", np.minimum(np.minimum(0.1, X + 1), Z**2)),
        ("max(x, y)", np.maximum(X, Y)),
        ("sqrt(x*x + y*y) + abs(z)", np.hypot(X, Y) + np.abs(Z)),
        ("exp(-x) * log(1 + y)", np.exp(-X) * np.log(1 + Y)),
        ("sin(pi*x) + cos(pi)", np.sin(np.pi * X) - 1.0),
        ("1e-3 + 1", 1.001 + 0 * X),
        ("(x +\n y)", X + Y),
    ],
)
def test_values(text, value):
    assert formula_of(text).at(POINTS) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("__import__('os')", "letter 1 "),
        ("0.1 + __import__('os').system('true')", "letter 7 "),
        ("x.real", "letter 1 "),
        ("0.1 + x.__class__", "letter 7 "),
        ("().__class__", "letter 1 "),
        ("(lambda: 1)()", "letter 1 "),
        ("[x for x in y]", "letter 1 "),
        ("x[0]", "letter 1 "),
        ("x if y else z", "letter 1 "),
        ("x < y", "letter 1 "),
        ("x and y", "letter 1 "),
        ("x % 2", "letter 1 "),
        ("x // 2", "letter 1 "),
        ("not x", "letter 1 "),
        ("+x", "letter 1 "),
        ("'a' + x", "letter 1 "),
        ("f'{x}'", "letter 1 "),
        ("1j", "letter 1 "),
        ("True", "letter 1 "),
        ("None", "letter 1 "),
        ("w", "letter 1 "),
        ("x + 2*h", "letter 7 "),
        ("open('f')", "letter 1 "),
        ("eval('1')", "letter 1 "),
        ("sin", "letter 1 "),
        ("sin(x, y)", "one value"),
        ("min(x)", "two values"),
        ("max(*x)", "two values"),
        ("max(x, key=y)", "letter 1 "),
        ("(y := 1)", "letter "),
        ("0.1*", "no formula"),
        ("", "no formula"),
        ("x y", "no formula"),
        ("import os", "no formula"),
        ("x = 1", "no formula"),
        ("x\0", "no formula"),
        ("1" * 400, "too large"),
        ("é + x", "letter 1 "),
        ("x + é", "letter 5 "),
    ],
)
def test_anything_else_is_refused_with_its_place(text, place):
    with pytest.raises(ConfigError, match=place) as refused:
        formula_of(text)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "text", ["9**9**9**9**9", "x + 10**10**10**10", "(" * 240 + "x" + ")" * 240, "-" * 480 + "x",
             "**".join(["9"] * 150), "1" * 400 + "**" + "9" * 50, "x" * (LONGEST + 1), "(" * 490]
)  # fmt: skip
def test_nothing_takes_long(text):
    start = time.perf_counter()
    try:
        formula_of(text).at(POINTS)
    except ConfigError as refused:
        assert "\n" not in str(refused)  # noqa: PT017
    assert time.perf_counter() - start < 1.0


def test_what_is_not_defined_is_no_number():
    values = formula_of("1/x + log(z)").at(POINTS)
    assert np.isinf(values[0])
    assert np.isnan(values[1])
    assert np.isfinite(values[2])
