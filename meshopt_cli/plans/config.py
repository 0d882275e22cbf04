"""From options and pipeline files to a pipeline."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import ConfigError, hint
from ..passes import PASSES, Pass
from ..passes.repair import Repair
from ..quality.measures import DEFAULT_MEASURE, Measure, measure_named
from ..work.kinds import CELLS, FACES, SIMPLICES
from .pipeline import Pipeline
from .presets import DEFAULT_PRESET, preset_named
from .ranges import RANGES, quoted
from .settings import option_of, pass_named, with_settings
from .stages import Repeat, Sequence, Stage
from .toml import read_toml

# Keys of a pipeline file and what each must be; numbers have their ranges besides.
KEYS: dict[str, type | tuple[type, ...]] = {
    "preset": str,
    "measure": str,
    "before": list,
    "pass": list,
    "allow": list,
}
STOPS = ("rounds", "gain", "target-quality")
NUMBERS = (*STOPS, "time-limit")
KEYS |= {key: int if RANGES[key].is_whole else (int, float) for key in NUMBERS}


SCALED = "scaled-jacobian"
# By what a mesh is judged where no measure is named.
DEFAULTS = {SIMPLICES: DEFAULT_MEASURE, FACES: SCALED, CELLS: SCALED}


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
    allow: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Plan:
    """A pipeline with the measure it works by.

    Attributes
    ----------
    all_measures : bool
        Whether it is for more than that measure tells, so that a report tells the others too.
    allow : tuple of str
        Codes, or prefixes of codes, of the rules that the mesh may break.
    kind : str
        Of the working mesh.
    """

    pipeline: Pipeline
    measure: Measure
    all_measures: bool = False
    allow: tuple[str, ...] = ()
    kind: str = SIMPLICES

    def kernels(self) -> list[str]:
        """Groups of kernels that a run needs."""
        if self.kind != SIMPLICES:
            return ["basic", CELLS, "global"]
        passes = self.pipeline.passes()
        return list(
            dict.fromkeys(("basic", *(group for p in passes for group in p.needed_kernels())))
        )


def plan_for(request: Request, dimension: int = 3, kind: str = SIMPLICES) -> Plan:
    """Put options, pipeline file and preset together; options win over the file.

    Parameters
    ----------
    dimension : int
        Of the mesh; presets have other thresholds in the plane.
    kind : str
        Of the working mesh; presets have other passes for cells that are no simplices, and they
        are judged by another measure where none is named.

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
        plan = _plan({}, request, dimension, kind)
    else:
        values = load(request.config)
        try:
            plan = _plan(values, request, dimension, kind)
        except ConfigError as error:
            raise ConfigError(f"{request.config}: {error}") from error
    return replace(plan, pipeline=with_settings(plan.pipeline, request.settings))


def _plan(values: dict[str, Any], request: Request, dimension: int, kind: str) -> Plan:
    """The plan of a file's values, over which the options win."""
    for key in ("measure", "rounds", "target-quality", "time-limit", "allow"):
        if (value := getattr(request, key.replace("-", "_"))) is not None:
            values[key] = value
    measure = measure_named(values.get("measure", DEFAULTS[kind]))
    if not measure.drives:
        raise ConfigError(f"measure {measure.name} is for reports and gates: it cannot steer")
    preset = preset_named(request.preset or values.get("preset", DEFAULT_PRESET))
    for key in NUMBERS:
        if key in values:
            values[key] = _number(key, values[key])
    wanted = {key.replace("-", "_"): values[key] for key in STOPS if key in values}
    stop = replace(preset.stops[dimension], **wanted)
    all_measures = False
    repairs: list[Repair] = []
    stages: tuple[Stage, ...]
    if request.passes is not None:
        name, steps = "custom", [pass_named(n)() for n in request.passes]
        stages = (Repeat(_sequence(steps, repairs), stop),)
    elif "pass" in values or "before" in values:
        name = "custom"
        before = _sequence([_pass(t, "before") for t in values.get("before", [])], repairs)
        steps = [_pass(table, "pass") for table in values.get("pass", [])]
        stages = (before, Repeat(_sequence(steps, repairs), stop)) if steps else (before,)
    else:
        name, stages = preset.name, preset.stages(stop, dimension, kind)
        all_measures = preset.all_measures
    limit = values.get("time-limit", math.inf)
    allow = tuple(values.get("allow", ()))
    if not all(isinstance(code, str) for code in allow):
        raise ConfigError("allow has a value of a wrong kind: it must be a list of codes")
    return Plan(Pipeline(name, stages, limit, tuple(repairs)), measure, all_measures, allow, kind)


def _sequence(steps: list[Pass], repairs: list[Repair]) -> Sequence:
    """Passes in order; those that mend the mesh of the file are put aside, in `repairs`."""
    repairs += [step for step in steps if isinstance(step, Repair)]
    return Sequence(tuple(step for step in steps if not isinstance(step, Repair)))


def load(path: Path) -> dict[str, Any]:
    """Read a pipeline file.

    Raises
    ------
    ConfigError
        The file cannot be read, is no TOML, or has a key that is unknown or of a wrong kind.
    """
    values = read_toml(path)
    for key, value in values.items():
        if key not in KEYS:
            raise ConfigError(f"{path}: unknown key {quoted(key)}{hint(key, KEYS)}")
        if not isinstance(value, KEYS[key]) or isinstance(value, bool):
            raise ConfigError(f"{path}: {key} has a value of a wrong kind: {quoted(value)}")
    if "preset" in values and ("pass" in values or "before" in values):
        raise ConfigError(f"{path}: a preset and a list of passes exclude each other")
    return values


def _number(key: str, value: Any) -> float:
    """The number of a key, within its range."""
    try:
        return RANGES[key].number(value)
    except ValueError as error:
        raise ConfigError(f"{key}: {error}") from None


def _pass(table: Any, where: str) -> Pass:
    """A pass from its table in a pipeline file."""
    if not isinstance(table, dict) or not isinstance(table.get("name"), str):
        raise ConfigError(f"each [[{where}]] needs a name, one of {', '.join(PASSES)}")
    kind = pass_named(table["name"])
    options = {key: value for key, value in table.items() if key != "name"}
    return kind(**dict(option_of(kind, key, value) for key, value in options.items()))
