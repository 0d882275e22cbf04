"""Options that several commands share."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

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
        return function(*args, verbosity=_verbosity(ctx, quiet, verbose), **kwargs)

    return wrapped
