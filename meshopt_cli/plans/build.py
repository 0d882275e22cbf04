"""What is made of the items of a pipeline: the stages that run."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from ..passes.repair import Repair
from ..quality.measures import measure_named
from .angles import WithAngles
from .items import PASS, Item, pass_of, passes_in
from .stages import Chain, Repeat, Sequence, Stage, Trial, Unsettled, UpTo
from .steering import ByMeasure
from .stop import Stop


def stages_of(items: Iterable[Item], stop: Stop) -> tuple[Stage, ...]:
    """The stages of items, one of each.

    Passes that mend the mesh of the file are none of them, see `repairs_of`.

    Parameters
    ----------
    stop : Stop
        When rounds end that say nothing of it.
    """
    return tuple(_stage(item, stop) for item in items if item.get(PASS) != Repair.name)


def repairs_of(items: list[Item]) -> tuple[Repair, ...]:
    """The passes that mend the mesh of the file, wherever they stand."""
    return tuple(s for s in map(pass_of, passes_in(items)) if isinstance(s, Repair))


def _stage(item: Item, stop: Stop) -> Stage:
    if PASS in item:
        return Sequence((pass_of(item),))
    head = next(key for key in item if key in _MAKERS)
    return _MAKERS[head](item, stop)


def _body(items: list[Item], stop: Stop) -> Stage:
    stages = stages_of(items, stop)
    if all(isinstance(stage, Sequence) for stage in stages):
        return Sequence(tuple(step for stage in stages for step in stage.passes()))
    return stages[0] if len(stages) == 1 else Chain(stages)


def _repeat(item: Item, stop: Stop) -> Stage:
    until = stop_of(item.get("until", {}), stop)
    return Repeat(_body(item["repeat"], stop), until, item.get("guarded", True))


def _steps(item: Item, stop: Stop) -> Stage:
    body = _body(item["steps"], stop)
    if "measure" in item:
        body = ByMeasure(measure_named(item["measure"]), body)
    return UpTo(item["max-cells"], body) if "max-cells" in item else body


def _angles(item: Item, stop: Stop) -> Stage:
    return WithAngles(_body(item["angles"], stop), item.get("lenient", False))


def _unsettled(item: Item, stop: Stop) -> Stage:
    return Unsettled(_body(item["unsettled"], stop))


def _try(item: Item, stop: Stop) -> Stage:
    return Trial(_body(item["try"], stop), _body(item.get("then", []), stop))


# By the keys of `items.FORMS`.
_MAKERS: dict[str, Callable[[Item, Stop], Stage]] = {
    "repeat": _repeat,
    "steps": _steps,
    "angles": _angles,
    "unsettled": _unsettled,
    "try": _try,
}


def stop_of(until: dict[str, Any], stop: Stop) -> Stop:
    """When rounds end: as a table says, and where it says nothing as others do."""
    target = until.get("target-quality", stop.target_quality)
    return Stop(
        until.get("rounds", stop.rounds),
        until.get("gain", until.get("gain-factor", 1.0) * stop.gain),
        max(target, until.get("settled", 1.0)),
    )
