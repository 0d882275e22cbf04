"""Options that several commands share."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

from ..errors import InterruptError
from .terminal import set_up_log


def measure_option(function: Callable[..., Any]) -> Callable[..., Any]:
    """`--measure NAME`."""
    return click.option(
        "--measure", metavar="NAME", help="Quality measure; see `meshopt list measures`."
    )(function)


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
    """A number from 1 on, or from another limit; nan is none."""

    name = "number"

    def __init__(self, least: float = 1.0) -> None:
        self.least = least

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        try:
            number = float(value)
        except ValueError:
            self.fail(f"{value!r} is not a number", param, ctx)
        if not number >= self.least:
            self.fail(f"{value} is out of range, must be at least {self.least:g}", param, ctx)
        return number
