"""Options of `check` from a file: `[check]` in meshopt.toml, `[tool.meshopt.check]` in
pyproject.toml, whichever is nearest to the working directory."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import click

from ..errors import ConfigError, hint
from ..plans.ranges import quoted
from ..plans.toml import nearest_table
from .options import Number

# Where the table stands in each file.
FILES = {"meshopt.toml": ("check",), "pyproject.toml": ("tool", "meshopt", "check")}
# Options of the command line that say what to do, not what is allowed.
NOT_KEYS = {"explain", "quiet", "verbose", "log_file", "mark", "help", "no_config", "meshes"}


def defaults(command: click.Command, ctx: click.Context, folder: Path) -> dict[str, Any]:
    """What the nearest file says, as defaults of the options of a command.

    Raises
    ------
    ConfigError
        A key that is no option, or a value that the option does not take: names file and key.
    """
    found = nearest_table(folder, FILES)
    if found is None:
        return {}
    path, table = found
    options = {
        option.opts[-1].removeprefix("--"): option
        for option in command.params
        if isinstance(option, click.Option) and option.name not in NOT_KEYS
    }
    values = {}
    for key, value in table.items():
        if key not in options:
            raise ConfigError(f"{path}: check has no key {quoted(key)}{hint(key, options)}")
        name, converted = _converted(ctx, path, key, options[key], value)
        values[name] = converted
    return values


def _converted(
    ctx: click.Context, path: Path, key: str, option: click.Option, value: Any
) -> tuple[str, Any]:
    wrong = ConfigError(f"{path}: {key} has a value of a wrong kind: {quoted(value)}")
    if isinstance(value, dict) or (option.is_flag != isinstance(value, bool)):
        raise wrong
    takes_text = not option.is_flag and not isinstance(option.type, Number)
    if takes_text and not isinstance(value, str | list):
        raise wrong
    if isinstance(value, list):
        if not all(isinstance(one, str) for one in value):
            raise wrong
        # Lists of codes are written with commas on the command line.
        value = value if option.multiple else ",".join(value)
    elif option.multiple:
        value = [value]
    try:
        option.type_cast_value(ctx, value)
    except click.BadParameter as error:
        raise ConfigError(f"{path}: {key}: {error.message}") from None
    return str(option.name), value


class Configured(click.Command):
    """A command whose options have their defaults in a file."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Look for the file before the options are parsed, which win over it."""
        if not {"--no-config", "-h", "--help"} & set(args):
            with contextlib.suppress(FileNotFoundError):  # the working folder is gone
                ctx.default_map = defaults(self, ctx, Path.cwd())
        return super().parse_args(ctx, args)
