"""From options and pipeline files to a pipeline."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import ConfigError, UnsupportedMeshError
from ..quality.measures import DEFAULT_MEASURE, Measure, measure_named
from ..work.kinds import CELLS, FACES, SIMPLICES
from .build import repairs_of, stages_of, stop_of
from .items import PASS, measures_in, pass_of, passes_in
from .pipeline import Pipeline
from .presets import ADAPT, DEFAULT_PRESET, parts_of, preset_named
from .ranges import RANGES, cut, quoted
from .settings import option_of, pass_named
from .sources import (
    KINDS,
    NUMBERS,
    SELECT,
    STOPS,
    Settled,
    changed,
    kind_named,
    read_source,
    settled,
)
from .stop import Stop

SCALED = "scaled-jacobian"
# By what a mesh is judged where no measure is named.
DEFAULTS = {SIMPLICES: DEFAULT_MEASURE, FACES: SCALED, CELLS: SCALED}


@dataclass(frozen=True)
class Request:
    """What the user asked for; None where nothing was said.

    Attributes
    ----------
    project : Settled
        What the files of a project say, before all else: see `project.found_in`.
    """

    preset: str | None = None
    passes: tuple[str, ...] | None = None
    config: Path | None = None
    settings: tuple[str, ...] = ()
    measure: str | None = None
    rounds: int | None = None
    target_quality: float | None = None
    time_limit: float | None = None
    threads: int | None = None
    allow: tuple[str, ...] | None = None
    only: tuple[str, ...] = ()
    freeze: tuple[str, ...] = ()
    below: float | None = None
    project: Settled = field(default_factory=Settled)


@dataclass(frozen=True)
class Selection:
    """Which cells of a mesh are worked on; all others stay as they are.

    Attributes
    ----------
    only, freeze : tuple of str
        Those in one of these groups or boxes, all without any, but for those in one of the others.
    below : float, optional
        Of them those around cells that have a greater Q.
    """

    only: tuple[str, ...] = ()
    freeze: tuple[str, ...] = ()
    below: float | None = None

    @property
    def is_whole(self) -> bool:
        """Whether these are all."""
        return self == Selection()


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
    selection : Selection
        What is worked on.
    """

    pipeline: Pipeline
    measure: Measure
    all_measures: bool = False
    allow: tuple[str, ...] = ()
    kind: str = SIMPLICES
    selection: Selection = field(default_factory=Selection)

    def idle(self) -> Plan:
        """The same, which changes nothing."""
        return replace(self, pipeline=replace(self.pipeline, stages=()))

    def kernels(self) -> list[str]:
        """Groups of kernels that a run needs."""
        if self.kind != SIMPLICES:
            return ["basic", CELLS, "global"]
        passes = self.pipeline.passes()
        return list(
            dict.fromkeys(("basic", *(group for p in passes for group in p.needed_kernels())))
        )


def plan_for(request: Request, dimension: int | None = None, kind: str = SIMPLICES) -> Plan:
    """The plan of what `settle` finds; parameters and errors as those of both."""
    return plan_of(settle(request), dimension, kind)


def settle(request: Request, in_metric: bool = False) -> Settled:
    """Put options, pipeline files and preset together: the later of these wins.

    Files of the project, `config`, settings of passes, and the other options.

    Parameters
    ----------
    in_metric : bool
        Whether there is a metric, so that another preset is meant where none is named.

    Returns
    -------
    holds : Settled
        With the pipeline of the preset, where no other is given.

    Raises
    ------
    ConfigError
        Names the key or option that is wrong.
    """
    given = [n for n in ("preset", "passes", "config") if getattr(request, n) is not None]
    if len(given) > 1:
        raise ConfigError(f"--{given[0]} and --{given[1]} exclude each other")
    holds = request.project
    if request.config is not None:
        holds = holds.then(load(request.config))
    holds = holds.then(_options(request))
    if not holds.is_chosen:
        name = holds.values.get("preset", ADAPT if in_metric else DEFAULT_PRESET)
        preset = preset_named(name)
        rest = {key: value for key, value in holds.values.items() if key != "preset"}
        holds = replace(preset.said.then(Settled(rest, holds.origins)), preset=name)
    return _with_settings(holds, request.settings)


def load(path: Path) -> Settled:
    """What a pipeline file says; errors as those of `read_source`."""
    return read_source(path, parts_of) or Settled()


def _options(request: Request) -> Settled:
    """What the options of the command line say."""
    found = Settled()
    for key in ("preset", "measure", *NUMBERS, "allow", *SELECT):
        value: Any = getattr(request, key.replace("-", "_"), None)
        if key in SELECT:  # none is said where there are none
            value = list(value) or None
        if value is not None and key in NUMBERS:
            value = _number(key, value)
        found = found.then(settled({key: value}, f"--{key}"))
    if request.passes is None:
        return found
    if not request.passes:
        raise ConfigError("--passes: no pass is named")
    steps = [{PASS: pass_named(name).name} for name in request.passes]
    return found.then(settled({"pipeline": [{"repeat": steps}]}, "--passes"))


def _number(key: str, value: Any) -> float:
    """The number of an option, within its range."""
    try:
        return RANGES[key].number(value)
    except ValueError as error:
        raise ConfigError(f"{key}: {error}") from None


def plan_of(holds: Settled, dimension: int | None = None, kind: str = SIMPLICES) -> Plan:
    """The plan for a mesh.

    Parameters
    ----------
    dimension : int, optional
        Of the mesh; pipelines may be others in the plane than in space. Without it, it is the plan
        for any mesh that there is one for.
    kind : str
        Of the working mesh; pipelines may be others for cells that are no simplices, and they are
        judged by another measure where none is named.

    Raises
    ------
    ConfigError
        The measure cannot steer, or a setting is for a pass that the pipeline does not have.
    UnsupportedMeshError
        There is no pipeline for such a mesh.
    """
    values = holds.values
    measure = measure_named(values.get("measure", DEFAULTS[kind]))
    if not measure.drives:
        raise ConfigError(f"measure {measure.name} is for reports and gates: it cannot steer")
    name = _kind_for(holds, dimension, kind)
    table = {key: values[key] for key in (*STOPS, "pipeline") if key in values}
    table |= values.get(name, {})
    steps = {item[PASS] for item in passes_in(table["pipeline"])} if dimension else holds.passes()
    for setting, step in holds.settings:
        if step not in steps:
            raise ConfigError(f"--set {cut(setting)}: the pipeline has no pass {step}")
    usual = preset_named(DEFAULT_PRESET).said.values[name] if holds.preset == "" else {}
    stop = stop_of(table, stop_of(usual, Stop()))
    items = table["pipeline"]
    pipeline = Pipeline(
        holds.preset or "custom", stages_of(items, stop), values.get("time-limit", math.inf),
        repairs_of(items), tuple(measures_in(items)), values.get("threads"),
    )  # fmt: skip
    all_measures = values.get("all-measures", False)
    allow = tuple(values.get("allow", ()))
    only, freeze = (tuple(values.get(key, ())) for key in SELECT)
    selection = Selection(only, freeze, values.get("below"))
    return Plan(pipeline, measure, all_measures, allow, kind, selection)


def _kind_for(holds: Settled, dimension: int | None, kind: str) -> str:
    """Which table of a pipeline is for a mesh."""
    wanted = [kind_named(d, kind) for d in ((3, 2) if dimension is None else (dimension,))]
    if dimension is None:
        wanted += KINDS
    for name in wanted:
        if name in holds.values or "pipeline" in holds.values:
            return name
    known = " or of ".join(said for name, said in KINDS.items() if name in holds.values)
    if holds.preset:
        raise UnsupportedMeshError(f"the preset {holds.preset} is for meshes of {known} alone")
    lacking = f"a table [{wanted[0]}] would be for {KINDS[wanted[0]]}"
    raise UnsupportedMeshError(f"the pipeline is for meshes of {known} alone: {lacking}")


def _with_settings(holds: Settled, settings: Iterable[str]) -> Settled:
    """What holds with `PASS.OPTION=VALUE` set in every pass of that name.

    Raises
    ------
    ConfigError
        The text has another form, or there is no such pass, option or value.
    """
    for setting in settings:
        target, equals, value = setting.partition("=")
        name, dot, key = target.strip().partition(".")
        if not equals or not dot:
            raise ConfigError(f"--set {quoted(setting)}: must be PASS.OPTION=VALUE")
        option, taken = option_of(pass_named(name), key, value.strip(), is_text=True)
        made = {option.replace("_", "-"): taken}
        pass_of({PASS: name, **made})  # within its limits
        holds = holds.mapped(partial(changed, name=name, options=made))
        holds = replace(holds, settings=(*holds.settings, (setting, name)))
    return holds
