"""Sizes by a formula in the coordinates: "0.01 + 0.19*x".

A formula is taken apart into the few things that are known here, and nothing else of the language
is ever run. All numbers are of double precision, so that no power takes long.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from typing import TypeGuard

import numpy as np

from ..errors import ConfigError, shown
from ..mesh.model import Array

LONGEST = 500  # letters of a formula
SHOWN = 40  # letters of it that a message shows
COORDINATES = ("x", "y", "z")
CONSTANTS = {"pi": math.pi}
OPERATORS: dict[type[ast.operator], Callable[[Number, Number], Number]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: np.true_divide,
    ast.Pow: np.power,
}
OF_ONE: dict[str, Callable[[Number], Number]] = {
    "sqrt": np.sqrt, "abs": np.abs, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos,
}  # fmt: skip
OF_SEVERAL = {"min": np.minimum, "max": np.maximum}
KNOWN = "numbers, x y z, + - * / **, " + ", ".join([*OF_SEVERAL, *OF_ONE, *CONSTANTS])

Number = Array | np.float64
Value = Callable[[Array], Number]  # of points, (np, 3)


@dataclass(frozen=True)
class Formula:
    """A size in the coordinates of a point.

    Attributes
    ----------
    text : str
    value : function of points, (np, 3)
    """

    text: str
    value: Value

    def at(self, points: Array) -> Array:
        """Sizes in points, (np,): not a number or infinite where it is not defined.

        Parameters
        ----------
        points : (np, 3) float64
        """
        with np.errstate(all="ignore"):
            return np.broadcast_to(self.value(points), len(points)).astype(np.float64)

    def __reduce__(self) -> tuple[Callable[[str], Formula], tuple[str]]:
        return formula_of, (self.text,)  # another process takes it apart anew


def formula_of(text: str) -> Formula:
    """Take a formula apart.

    Raises
    ------
    ConfigError
        There is something else in it than it may have: the message says what, and where.
    """
    if len(text) > LONGEST:
        raise ConfigError(f"the formula has {len(text):,} letters: at most {LONGEST}")
    try:
        tree = ast.parse(text.strip(), mode="eval")
        return Formula(text.strip(), _value(tree.body, text.strip()))
    except SyntaxError as error:
        at = f" at letter {error.offset}" if error.offset else ""
        raise ConfigError(f"{_quoted(text)} is no formula{at}: known are {KNOWN}") from None
    except (ValueError, RecursionError, MemoryError):
        raise ConfigError(f"{_quoted(text)} is no formula: known are {KNOWN}") from None


def _value(node: ast.expr, text: str) -> Value:
    """What a part of a formula stands for."""
    if isinstance(node, ast.Constant) and _is_number(node.value):
        try:
            number = np.float64(node.value)
        except OverflowError:
            raise _refused(node, text, "a number too large") from None
        return lambda points: number
    if isinstance(node, ast.Name):
        if node.id in COORDINATES:
            column = COORDINATES.index(node.id)
            return lambda points: points[:, column]
        if node.id in CONSTANTS:
            constant = np.float64(CONSTANTS[node.id])
            return lambda points: constant
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        inner = _value(node.operand, text)
        return lambda points: -inner(points)
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        function = OPERATORS[type(node.op)]
        one, other = _value(node.left, text), _value(node.right, text)
        return lambda points: function(one(points), other(points))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        name, parts = node.func.id, node.args
        if name in OF_ONE and len(parts) == 1:
            alone, inside = OF_ONE[name], _value(parts[0], text)
            return lambda points: alone(inside(points))
        if name in OF_SEVERAL and len(parts) > 1:
            least, among = OF_SEVERAL[name], [_value(part, text) for part in parts]
            return lambda points: reduce(least, [part(points) for part in among])
        if name in OF_ONE or name in OF_SEVERAL:
            wanted = "one value" if name in OF_ONE else "two values or more"
            raise _refused(node, text, f"{name} takes {wanted}")
    raise _refused(node, text, f"known are {KNOWN}")


def _is_number(value: object) -> TypeGuard[float]:
    return type(value) in (int, float)  # a bool is an int, too


def _refused(node: ast.expr, text: str, why: str) -> ConfigError:
    """What is said of a part that may not be in a formula."""
    line = text.splitlines()[node.lineno - 1]
    at = len(line.encode()[: node.col_offset].decode()) + 1
    part = ast.get_source_segment(text, node) or ""
    return ConfigError(f"{_quoted(part)} at letter {at} of the formula: {why}")


def _quoted(text: str) -> str:
    return shown(repr(text if len(text) <= SHOWN else f"{text[:SHOWN]}..."))
