"""From options and pipeline files to a pipeline."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from ..errors import ConfigError
from ..passes import PASSES, Pass
from ..quality.summary import DEFAULT_MEASURE, Measure, measure_named
from .pipeline import Pipeline, Repeat, Sequence, Stage, Stop
from .presets import DEFAULT_PRESET, pass_named, preset_named

# Keys of a pipeline file and what each must be.
NUMBER = (int, float)
KEYS: dict[str, type | tuple[type, ...]] = {
    "preset": str,
    "measure": str,
    "rounds": int,
    "gain": NUMBER,
    "target-quality": NUMBER,
    "time-limit": NUMBER,
    "before": list,
    "pass": list,
}


@dataclass(frozen=True)
class Request:
    """What the user asked for; None where nothing was said."""

    preset: str | None = None
    passes: tuple[str, ...] | None = None
    config: Path | None = None
    settings: tuple[str, ...] = ()
    measure: str | None = None
    rounds: int | None = None
    target_quality: float | None = None
    time_limit: float | None = None


@dataclass
class Plan:
    """A pipeline with the measure it works by."""

    pipeline: Pipeline
    measure: Measure

    def kernels(self) -> list[str]:
        """Groups of kernels that a run needs."""
        passes = self.pipeline.passes()
        return list(dict.fromkeys(("basic", *(group for p in passes for group in p.kernels))))


def plan_for(request: Request, dimension: int = 3) -> Plan:
    """Put options, pipeline file and preset together; options win over the file.

    Parameters
    ----------
    dimension : int
        Of the mesh; presets have other thresholds in the plane.

    Raises
    ------
    ConfigError
        Names the key or option that is wrong.
    """
    given = [n for n in ("preset", "passes", "config") if getattr(request, n) is not None]
    if len(given) > 1:
        raise ConfigError(f"--{given[0]} and --{given[1]} exclude each other")
    if request.passes == ():
        raise ConfigError("--passes: no pass is named")
    if request.config is None:
        plan = _plan({}, request, dimension)
    else:
        values = load(request.config)
        try:
            plan = _plan(values, request, dimension)
        except ConfigError as error:
            raise ConfigError(f"{request.config}: {error}") from error
    apply_settings(plan.pipeline.passes(), request.settings)
    return plan


def _plan(values: dict[str, Any], request: Request, dimension: int) -> Plan:
    """The plan of a file's values, over which the options win."""
    for key in ("measure", "rounds", "target-quality", "time-limit"):
        if (value := getattr(request, key.replace("-", "_"))) is not None:
            values[key] = value
    measure = measure_named(values.get("measure", DEFAULT_MEASURE))
    if not measure.drives:
        raise ConfigError(f"measure {measure.name} cannot steer: it calls some flat cells good")
    preset = preset_named(request.preset or values.get("preset", DEFAULT_PRESET))
    stop = _stop(preset.stop, values)
    stages: tuple[Stage, ...]
    if request.passes is not None:
        name, steps = "custom", tuple(pass_named(n)() for n in request.passes)
        stages = (Repeat(Sequence(steps), stop),)
    elif "pass" in values or "before" in values:
        name = "custom"
        before = tuple(_pass(table, "before") for table in values.get("before", []))
        steps = tuple(_pass(table, "pass") for table in values.get("pass", []))
        stages = (Sequence(before), Repeat(Sequence(steps), stop)) if steps else (Sequence(before),)
    else:
        name, stages = preset.name, preset.build(stop, dimension)
    limit = float(values.get("time-limit", "inf"))
    if not limit >= 0.0:
        raise ConfigError(f"time-limit: {limit} is out of range, must be at least 0")
    return Plan(Pipeline(name, stages, limit), measure)


def load(path: Path) -> dict[str, Any]:
    """Read a pipeline file.

    Raises
    ------
    ConfigError
        The file cannot be read, is no TOML, or has a key that is unknown or of a wrong kind.
    """
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "is not UTF-8 text"
        raise ConfigError(f"{path}: {reason}") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: not valid TOML: {error}") from error
    for key, value in values.items():
        if key not in KEYS:
            raise ConfigError(f"{path}: unknown key {key!r}{_hint(key, KEYS)}")
        if not isinstance(value, KEYS[key]) or isinstance(value, bool):
            raise ConfigError(f"{path}: {key} has a value of a wrong kind: {value!r}")
    if "preset" in values and ("pass" in values or "before" in values):
        raise ConfigError(f"{path}: a preset and a list of passes exclude each other")
    return values


def _stop(stop: Stop, values: dict[str, Any]) -> Stop:
    wanted: dict[str, Any] = {}
    limits = {"rounds": 1, "gain": 0.0, "target-quality": 1.0}
    for key, least in limits.items():
        if key in values:
            if not values[key] >= least:
                raise ConfigError(f"{key}: {values[key]} is out of range, must be at least {least}")
            wanted[key.replace("-", "_")] = values[key]
    return replace(stop, **wanted)


def _pass(table: Any, where: str) -> Pass:
    """A pass from its table in a pipeline file."""
    if not isinstance(table, dict) or not isinstance(table.get("name"), str):
        raise ConfigError(f"each [[{where}]] needs a name, one of {', '.join(PASSES)}")
    kind = pass_named(table["name"])
    options = {}
    for key, value in table.items():
        if key != "name":
            name = _option_of(kind, key)
            options[name] = _converted(kind, name, value, is_text=False)
    return kind(**options)


def apply_settings(passes: Iterable[Pass], settings: Iterable[str]) -> None:
    """Apply `PASS.OPTION=VALUE` settings to every pass of that name.

    Raises
    ------
    ConfigError
        The text has another form, or there is no such pass, option or value.
    """
    steps = list(passes)
    for setting in settings:
        target, equals, value = setting.partition("=")
        name, dot, key = target.strip().partition(".")
        if not equals or not dot:
            raise ConfigError(f"--set {setting}: must be PASS.OPTION=VALUE")
        kind = pass_named(name)
        option = _option_of(kind, key)
        for step in steps:
            if step.name == name:
                setattr(step, option, _converted(kind, option, value.strip(), is_text=True))
                step.validate()
        if not any(step.name == name for step in steps):
            raise ConfigError(f"--set {setting}: the pipeline has no pass {name}")


def _option_of(kind: type[Pass], key: str) -> str:
    names = [f.name for f in fields(kind)]
    name = key.replace("-", "_")
    if name not in names:
        shown = [n.replace("_", "-") for n in names]
        raise ConfigError(f"pass {kind.name} has no option {key!r}{_hint(key, shown)}")
    return name


def _converted(kind: type[Pass], name: str, value: Any, is_text: bool) -> Any:
    """The value as the type of the option.

    Parameters
    ----------
    is_text : bool
        Whether it comes from the command line, where a number is text too; in a file the kind
        of the value must fit.
    """
    wanted = next(str(f.type) for f in fields(kind) if f.name == name)
    allowed = {"int": (int,), "float": (int, float), "str": (str,)}[wanted]
    makers = {"int": int, "float": float, "str": str}
    try:
        if not is_text and (isinstance(value, bool) or not isinstance(value, allowed)):
            raise ValueError
        return makers[wanted](value)
    except (ValueError, OverflowError):
        shown = f"{kind.name}.{name.replace('_', '-')}"
        raise ConfigError(f"{shown}: {value!r} is not of type {wanted}") from None


def _hint(key: str, known: Iterable[str]) -> str:
    choices = list(known)
    close = difflib.get_close_matches(key, choices, 1)
    return f": did you mean {close[0]!r}?" if close else f"; known are {', '.join(choices)}"
