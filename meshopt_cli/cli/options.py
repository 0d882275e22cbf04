"""Options that several commands share."""

from __future__ import annotations

import functools
import logging
import os
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from ..errors import InterruptError, MeshoptError
from ..files.ending import what_is_written
from ..files.sink import as_pipe
from ..plans.ranges import RANGES
from ..version import __version__
from . import completion
from .terminal import SAID, set_up_log

log = logging.getLogger("meshopt")

LOG_FILE = f"{__name__}.log-file"  # where it stands in the context of click

Function = TypeVar("Function", bound=Callable[..., Any])


class Place(click.Path):
    """A file, or `formats.PIPE` for `-` and for other names of stdin (0) or stdout (1)."""

    def __init__(self, descriptor: int) -> None:
        super().__init__(path_type=Path, allow_dash=True)
        self._descriptor = descriptor

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return as_pipe(Path(os.fsdecode(super().convert(value, param, ctx))), self._descriptor)


INPUT, OUTPUT = Place(0), Place(1)


def measure_option(function: Function) -> Function:
    """`--measure NAME`."""
    return click.option(
        "--measure", metavar="NAME", help="Quality measure; see `meshopt list measures`.",
        shell_complete=completion.of(completion.measures),
    )(function)  # fmt: skip


def region_option(function: Function) -> Function:
    """`--region NAME`, repeatable, handed on as `regions`."""
    return click.option(
        "--region", "regions", multiple=True, metavar="ARRAY",
        help="An array of the cells that makes regions, instead of all tags; repeatable.",
    )(function)  # fmt: skip


def metric_options(what: str) -> Callable[[Function], Function]:
    """A metric and what it is to be like, handed on as `asked`; `what` it is for, in words."""

    def add(function: Function) -> Function:
        @functools.wraps(function)
        def wrapped(*args: Any, metric: str | None, size: tuple[str, ...], **kwargs: Any) -> Any:
            shaping = {key: kwargs.pop(key) for key in ("gradation", "size_min", "size_max")}
            asked = None
            if metric is not None or size or set(shaping.values()) != {None}:
                from ..jobs.metric import asked_for  # seldom needed

                asked = asked_for(metric, size, **shaping)
            return function(*args, asked=asked, **kwargs)

        for option in reversed((
            click.option(
                "--metric", metavar="SOURCE", shell_complete=completion.metrics,
                help=f"{what} a metric: a file of Medit (.sol, .solb), an array of its points, or "
                     "`implied`, its own."),
            click.option(
                "--size", metavar="FORMULA", multiple=True,
                help=f"{what} sizes, a formula in x, y and z, such as 0.01+0.19*x; NAME=FORMULA "
                     "is for a region or a group alone; repeatable."),
            number_option("gradation", metavar="BETA",
                          help="Make sizes of the metric less until they grow by this factor at "
                               "most along an edge of length 1, such as 1.3."),
            number_option("size-min", metavar="LENGTH",
                          help="Least size in the metric, along each axis of a tensor."),
            number_option("size-max", metavar="LENGTH", help="Greatest such size."),
        )):  # fmt: skip
            wrapped = option(wrapped)
        return wrapped  # type: ignore[return-value]

    return add


class Size(click.ParamType):
    """A number of bytes: 2000000, 500M, 1.5G."""

    name = "size"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        found = re.fullmatch(r"(\d{1,15}(?:\.\d{1,9})?)([kKMGT]?)(?:i?B)?", str(value), re.ASCII)
        if found is None:
            self.fail(f"{value!r} is no size, such as 500M or 2G", param, ctx)
        return int(float(found[1]) * 1024 ** " KMGT".index(found[2].upper() or " "))


def reading_options(function: Function) -> Function:
    """`--input-format NAME` and `--max-size SIZE`."""
    function = click.option(
        "--max-size", type=Size(), metavar="SIZE",
        help="The most that may come out of a compressed file, such as 2G; without it a thousand "
             "times the file.",
    )(function)  # fmt: skip
    return click.option(
        "--input-format", metavar="NAME", help="Format of what is read, whatever its name.",
        shell_complete=completion.of(completion.formats),
    )(function)  # fmt: skip


def file_options(function: Function) -> Function:
    """From which file to which, and in what format, for commands that make a mesh of another.

    The place of the result is handed on as `output`, whichever way it is given.
    """

    @functools.wraps(function)
    def wrapped(*args: Any, output: Path | None, to: Path | None, **kwargs: Any) -> Any:
        return function(*args, output=_once(output, to), **kwargs)

    command: Callable[..., Any] = _format_options(wrapped)
    for option in reversed(
        (
            click.argument("input", type=INPUT),
            click.argument("output", type=OUTPUT, required=False),
            click.option("-o", "--output", "to", type=OUTPUT, metavar="FILE", help="OUTPUT."),
        )
    ):
        command = option(command)
    return command  # type: ignore[return-value]


def many_file_options(function: Function) -> Function:
    """The same for a command that takes many meshes at once, too.

    What is given is handed on as `inputs`, and as `output`: the place of the only result, or the
    pattern for the names of many; and `output_dir`.
    """

    @functools.wraps(function)
    def wrapped(*args: Any, meshes: tuple[Path, ...], to: Path | None, **kwargs: Any) -> Any:
        from ..jobs.destinations import is_pattern

        inputs, output = [as_pipe(path, 0) for path in meshes], to
        if kwargs["output_dir"] is None and not is_pattern(to):
            if len(inputs) == 2:
                output = _once(as_pipe(meshes[1], 1), to)
            if not inputs and not kwargs["show_config"]:
                raise click.UsageError("Missing argument 'INPUT'.")
            if len(inputs) > 2:
                raise click.UsageError(
                    f"{meshes[2]}: several inputs need --output-dir, or a pattern, such as -o "
                    "'{stem}.opt{suffix}'"
                )
            inputs = inputs[:1]
        return function(*args, inputs=inputs, output=output, **kwargs)

    command: Callable[..., Any] = _format_options(wrapped)
    for option in reversed((
        click.argument("meshes", nargs=-1, metavar="INPUT [OUTPUT] | INPUT...",
                       type=click.Path(path_type=Path, allow_dash=True)),
        click.option("-o", "--output", "to", type=OUTPUT, metavar="FILE",
                     help="OUTPUT, or a pattern for the names of many, such as "
                          "'{stem}.opt{suffix}'."),
        click.option("--output-dir", type=click.Path(path_type=Path), metavar="FOLDER",
                     help="Where the results of many inputs go: files, folders and patterns."),
        number_option("jobs", metavar="N",
                      help="Processes for many inputs; as many as there are cores where it is "
                           "worth it."),
    )):  # fmt: skip
        command = option(command)
    return command  # type: ignore[return-value]


def _once(output: Path | None, to: Path | None) -> Path | None:
    """OUTPUT, given as an argument or as an option."""
    if output is not None and to is not None:
        raise click.UsageError(f"OUTPUT is given twice: {output} and, by -o, {to}")
    return output if to is None else to


def _format_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """In what format a mesh is written, and read."""
    for option in reversed((
        click.option("--in-place", is_flag=True,
                     help="OUTPUT may be INPUT, and is when it is left out."),
        click.option("--file-format", metavar="NAME",
                     help="Format of OUTPUT; see `meshopt list formats`.",
                     shell_complete=completion.of(completion.formats)),
        click.option("--binary/--ascii", default=None,
                     help="Write binary or text, where the format has both; as INPUT was without."),
        reading_options,
    )):  # fmt: skip
        function = option(function)
    return function


def _verbosity(ctx: click.Context, quiet: bool, verbose: bool) -> int:
    if quiet and verbose:
        raise click.UsageError("-q and -v exclude each other", ctx)
    return 1 if verbose else -1 if quiet else 0


def verbosity_options(
    quiet: str = "Say nothing but errors.", verbose: str = "Say more."
) -> Callable[[Function], Function]:
    """`-q` and `-v`, handed on as `verbosity`: -1, 0 or 1; with what they do, in words."""

    def add(function: Function) -> Function:
        @click.option("-q", "--quiet", is_flag=True, help=quiet)
        @click.option("-v", "--verbose", is_flag=True, help=verbose)
        @click.option(
            "--log-file", type=click.Path(path_type=Path, dir_okay=False), metavar="FILE",
            help="Add what is said to a file, with the time, and what each pass does.",
        )  # fmt: skip
        @click.pass_context
        @functools.wraps(function)
        def wrapped(
            ctx: click.Context,
            *args: Any,
            quiet: bool,
            verbose: bool,
            log_file: Path | None,
            **kwargs: Any,
        ) -> Any:
            verbosity = _verbosity(ctx, quiet, verbose)
            set_up_log(verbosity, log_file)
            ctx.meta[LOG_FILE] = log_file
            log.debug("meshopt %s: %s", __version__, shlex.join(ctx.find_object(tuple) or ()))
            try:
                return function(*args, verbosity=verbosity, **kwargs)
            except MeshoptError as error:
                log.error("%s", error, extra={SAID: True})
                raise
            except KeyboardInterrupt:
                # Before click sees it, which would print an empty line.
                raise InterruptError(f"interrupted: {what_is_written()}") from None

        return wrapped  # type: ignore[return-value]

    return add


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


def engine_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Who works on a mesh in pieces."""
    for option in reversed((
        click.option("--engine", type=click.Choice(["local", "dask"]),
                     help="Who works on a mesh in pieces, .pvtu: processes of this machine, which "
                          "is the default, or Dask's workers; --jobs says how many."),
        click.option("--scheduler", metavar="ADDRESS",
                     help="Dask's scheduler, such as tcp://host:8786; without it workers are "
                          "started here."),
    )):  # fmt: skip
        function = option(function)
    return function


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
