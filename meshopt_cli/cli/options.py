"""Options that several commands share."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

from ..errors import InterruptError
from ..plans.ranges import RANGES
from .terminal import set_up_log


def measure_option(function: Callable[..., Any]) -> Callable[..., Any]:
    """`--measure NAME`."""
    return click.option(
        "--measure", metavar="NAME", help="Quality measure; see `meshopt list measures`."
    )(function)


def region_option(function: Callable[..., Any]) -> Callable[..., Any]:
    """`--region NAME`, repeatable, handed on as `regions`."""
    return click.option(
        "--region", "regions", multiple=True, metavar="NAME",
        help="An array of the cells that makes regions, instead of all tags; repeatable.",
    )(function)  # fmt: skip


def _verbosity(ctx: click.Context, quiet: bool, verbose: bool) -> int:
    if quiet and verbose:
        raise click.UsageError("-q and -v exclude each other", ctx)
    verbosity = 1 if verbose else -1 if quiet else 0
    set_up_log(verbosity)
    return verbosity


def verbosity_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """`-q` and `-v`, handed on as `verbosity`: -1, 0 or 1."""

    @click.option("-q", "--quiet", is_flag=True, help="Say nothing but errors.")
    @click.option("-v", "--verbose", is_flag=True, help="Say more.")
    @click.pass_context
    @functools.wraps(function)
    def wrapped(ctx: click.Context, *args: Any, quiet: bool, verbose: bool, **kwargs: Any) -> Any:
        verbosity = _verbosity(ctx, quiet, verbose)
        try:
            return function(*args, verbosity=verbosity, **kwargs)
        except KeyboardInterrupt:
            # Before click sees it, which would print an empty line.
            raise InterruptError("interrupted: nothing is written") from None

    return wrapped


class Number(click.ParamType):
    """A number in the range that `RANGES` has for an option."""

    name = "number"

    def __init__(self, key: str) -> None:
        self.key = key

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        try:
            return RANGES[self.key].number(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


def number_option(key: str, **attributes: Any) -> Callable[[Callable[..., Any]], Any]:
    """An option `--KEY` that takes the numbers `RANGES` has for it."""
    return click.option(f"--{key}", type=Number(key), **attributes)


def names_in(
    ctx: click.Context, parameter: click.Parameter, value: str | None
) -> tuple[str, ...] | None:
    """The names of a list with commas; None where there is no list."""
    return None if value is None else tuple(n.strip() for n in value.split(",") if n.strip())


def all_names_in(
    ctx: click.Context, parameter: click.Parameter, value: tuple[str, ...]
) -> tuple[str, ...] | None:
    """The names of all lists with commas; None where there is none."""
    names = [name for one in value for name in names_in(ctx, parameter, one) or ()]
    return tuple(names) if value else None
