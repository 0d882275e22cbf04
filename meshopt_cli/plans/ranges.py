"""The numbers that options take, on the command line and in files alike."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

# More rounds, processes or lines than anybody means, and less than what no counter holds.
MOST = 2**31 - 1


@dataclass(frozen=True)
class Range:
    """The numbers that an option takes: finite, and within limits.

    Attributes
    ----------
    least, most : float
    is_open : bool
        Whether `least` itself is left out.
    is_whole : bool
        Whether they are whole numbers.
    is_endless : bool
        Whether infinity is one of them: it says that there is no limit.
    """

    least: float
    most: float = math.inf
    is_open: bool = False
    is_whole: bool = False
    is_endless: bool = False

    def number(self, value: object) -> float:
        """The number that a value, or the text of one, stands for.

        Raises
        ------
        ValueError
            It stands for none, or for one out of range: the message says which are in it.
        """
        kind: Callable[[Any], float] = int if self.is_whole else float
        what = "a whole number" if self.is_whole else "a number"
        try:
            if isinstance(value, bool) or (self.is_whole and isinstance(value, float)):
                raise ValueError
            number = kind(value)
        except (TypeError, ValueError):
            raise ValueError(f"{value!r} is not {what}") from None
        except OverflowError:
            number = math.inf if isinstance(value, int) and value > 0 else -math.inf
        if isinstance(number, float) and math.isnan(number):
            raise ValueError(f"{value} is not a number")
        too_large = number > self.most or (number == math.inf and not self.is_endless)
        if too_large or number < self.least or (self.is_open and number == self.least):
            raise ValueError(f"{value} is out of range, must be {self}")
        return number

    def __str__(self) -> str:
        finite = "" if self.is_whole or self.is_endless else "finite and "
        if math.isinf(self.most):
            return f"{finite}at least {self.least:g}"
        if self.is_open:
            return f"above {self.least:g} and at most {self.most:g}"
        return f"from {self.least:g} to {self.most:.10g}"


# By the name of the option: `--rounds` on the command line, `rounds` in a file.
RANGES: dict[str, Range] = {
    # of `optimize` and of pipeline files
    "rounds": Range(1, MOST, is_whole=True),
    "gain": Range(0, 1),
    "target-quality": Range(1),
    "time-limit": Range(0, is_endless=True),
    "slide-tolerance": Range(0, 1),
    # of `check` and of [check] in meshopt.toml
    "fail-above": Range(1),
    "min-angle": Range(0, 180),
    "max-angle": Range(0, 180),
    "min-size": Range(0),
    "max-aspect": Range(1),
    "tolerance": Range(0, 0.1, is_open=True),
    "limit": Range(0, MOST, is_whole=True),
    "jobs": Range(1, MOST, is_whole=True),
}
