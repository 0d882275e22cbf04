"""Options of passes by name: those of `--set PASS.OPTION=VALUE`, and those of a pipeline file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import Field, fields
from typing import Any

from ..errors import ConfigError, chosen, hint
from ..passes import PASSES, Pass
from .keys import Number, Text
from .ranges import Range, cut, quoted

# What options were called before, of whatever pass.
RENAMED = {
    "below": "worse_than",
    "floor": "least_quality",
    "promise": "first_gain",
    "urgent": "urgent_factor",
    "harm": "least_kept",
    "rings": "max_rings",
    "around": "rings_worse_than",
    "crowd": "max_cells",
    "enough": "near_target",
}


def pass_named(name: str) -> type[Pass]:
    """The pass of this name.

    Raises
    ------
    ConfigError
        There is none: the message lists them.
    """
    return chosen(PASSES, name, "pass")


def option_of(kind: type[Pass], key: str, value: Any, is_text: bool = False) -> tuple[str, Any]:
    """The name of an option of a pass, and the value as its type.

    Parameters
    ----------
    is_text : bool
        Whether it comes from the command line, where a number is text too; in a file the kind
        of the value must fit.

    Raises
    ------
    ConfigError
        There is no such option, or the value is of another type.
    """
    known = {f.name: f for f in fields(kind)}
    name = key.replace("-", "_")
    if name not in known:
        raise ConfigError(f"pass {kind.name} has no option {cut(repr(key))}{_meant(name, known)}")
    option, shown_name = known[name], f"{kind.name}.{name.replace('_', '-')}"
    if option.metadata["kind"] is str:
        if not isinstance(value, str):
            raise ConfigError(f"{shown_name}: {quoted(value)} is not a text")
        return name, value
    range_ = _range_of(option)
    try:
        return name, range_.number(value) if is_text else range_.of_file(value)
    except ValueError as error:
        raise ConfigError(f"{shown_name}: {error}") from None


def value_of(option: Field[Any]) -> Number | Text:
    """What an option of a pass takes."""
    if option.metadata["kind"] is str:
        return Text(option.metadata["choices"])
    return Number(_range_of(option))


def _range_of(option: Field[Any]) -> Range:
    limits = option.metadata
    return Range(limits["least"], limits["most"], is_whole=limits["kind"] is int)


def _meant(name: str, known: Iterable[str]) -> str:
    """Which option it is that does not go by this name."""
    new = RENAMED.get(name, name)
    if new in known:
        return f": it is called {new.replace('_', '-')!r} now"
    return hint(name.replace("_", "-"), [k.replace("_", "-") for k in known])
