"""The numbers that options take, on the command line and in files alike."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from datetime import date, time

# More rounds, processes or lines than anybody means, and less than what no counter holds.
MOST = 2**31 - 1

# Numbers as they are written in other programs: no underscores, no digits of other scripts.
WHOLE = re.compile(r"[+-]?[0-9]+")
DECIMAL = re.compile(
    r"[+-]?(([0-9]+(\.[0-9]*)?|\.[0-9]+)(e[+-]?[0-9]+)?|inf|infinity|nan)", re.IGNORECASE
)
LONGEST = 60  # what is quoted of a value


def quoted(value: object) -> str:
    """A value of a file or a command line, as a line that says what is wrong with it shows it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, date | time):
        return value.isoformat()
    try:
        return cut(repr(value))
    except ValueError:  # more digits than Python writes
        return "a number of thousands of digits"


def cut(text: str) -> str:
    """The beginning of a long text."""
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


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
        if isinstance(value, str):
            return self._within(self._read(value), cut(value.strip()))
        return self.of_file(value)

    def of_file(self, value: object) -> float:
        """The number that a value of a file is, where no text stands for one; else as `number`."""
        kinds = int if self.is_whole else (int, float)
        if isinstance(value, bool) or not isinstance(value, kinds):
            raise ValueError(f"{quoted(value)} is not {self._kind}")
        try:
            number = value if self.is_whole else float(value)
        except OverflowError:
            number = math.inf if value > 0 else -math.inf
        return self._within(number, quoted(value))

    def _read(self, text: str) -> float:
        form = WHOLE if self.is_whole else DECIMAL
        if not form.fullmatch(text.strip()):
            raise ValueError(f"{quoted(text)} is not {self._kind}")
        try:
            return int(text) if self.is_whole else float(text)
        except ValueError:  # more digits than Python reads
            return -math.inf if text.strip().startswith("-") else math.inf

    def _within(self, number: float, said: str) -> float:
        if isinstance(number, float) and math.isnan(number):
            raise ValueError(f"{said} is not a number")
        too_large = number > self.most or (number == math.inf and not self.is_endless)
        if too_large or number < self.least or (self.is_open and number == self.least):
            raise ValueError(f"{said} is out of range, must be {self}")
        return number

    @property
    def _kind(self) -> str:
        return "a whole number" if self.is_whole else "a number"

    def __str__(self) -> str:
        finite = "" if self.is_whole or self.is_endless else "finite and "
        if math.isinf(self.most):
            return f"{finite}{'above' if self.is_open else 'at least'} {self.least:g}"
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
    "threads": Range(1, MOST, is_whole=True),
    "slide-tolerance": Range(0, 1),
    "below": Range(1),
    # of `check` and of [check] in meshopt.toml
    "fail-above": Range(1),
    "min-angle": Range(0, 180),
    "max-angle": Range(0, 180),
    "min-size": Range(0),
    "max-aspect": Range(1),
    "tolerance": Range(0, 0.1, is_open=True),
    "limit": Range(0, MOST, is_whole=True),
    "jobs": Range(1, MOST, is_whole=True),
    "pieces": Range(1, MOST, is_whole=True),
    # of metrics
    "gradation": Range(1.01, 100),
    "size-min": Range(0),
    "size-max": Range(0, is_open=True),
    # of `view`
    "shrink": Range(0, 1, is_open=True),
    "worst": Range(1, 100, is_whole=True),
    "width": Range(100, 10_000, is_whole=True),
}
