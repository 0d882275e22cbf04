"""Options as keywords: they have the names, the ranges and the meaning that flags have."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from ..errors import ConfigError
from ..plans.ranges import RANGES

if TYPE_CHECKING:
    import numpy as np

    from ..jobs.metric import Asked

# Names in a row, with commas or one by one.
Names: TypeAlias = "str | Iterable[str]"


def names_of(given: Names | None) -> tuple[str, ...] | None:
    """The names of a list with commas, or of several."""
    if given is None:
        return None
    parts = [given] if isinstance(given, str) else given
    return tuple(name.strip() for part in parts for name in part.split(",") if name.strip())


def words_of(given: Names) -> tuple[str, ...]:
    """One word or several, in which commas mean nothing."""
    return (given,) if isinstance(given, str) else tuple(given)


def settings_of(given: Mapping[str, object] | Names) -> tuple[str, ...]:
    """Options of passes, as `--set` takes them."""
    if isinstance(given, Mapping):
        return tuple(f"{key}={value}" for key, value in given.items())
    return words_of(given)


def numbers_in(options: Mapping[str, Any]) -> None:
    """Refuse numbers out of their range.

    Raises
    ------
    ConfigError
        It names the option.
    """
    for name, value in options.items():
        key = name.replace("_", "-")
        if value is None or key not in RANGES:
            continue
        try:
            RANGES[key].number(value)
        except ValueError as error:
            raise ConfigError(f"{name}: {error}") from None


def metric_of(
    metric: str | np.ndarray | None, size: Names | None, **shaping: float | None
) -> Asked | None:
    """The metric that is asked for: see `jobs.metric.asked_for`.

    Raises
    ------
    ConfigError
    """
    from ..jobs.metric import Asked, asked_for

    numbers_in(shaping)
    sizes = None if size is None else words_of(size)
    if metric is None or isinstance(metric, str):
        return asked_for(metric, sizes, **shaping)
    if sizes:
        raise ConfigError("metric and size exclude each other")
    import numpy as np

    from ..metric.shaping import Shaping

    return Asked("the array given", shaping=Shaping(**shaping), values=np.asarray(metric))
