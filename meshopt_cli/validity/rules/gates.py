"""Limits that the user sets: M4xx."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...cells import SIMPLICES
from ...errors import ConfigError
from ...mesh.groups import cells_in
from ...mesh.model import Array
from ...quality.gates import IN_METRIC, Limit
from ..examination import Examination
from ..model import ERROR, WARNING, Places, at_cells, rule


@rule(
    "M401",
    ERROR,
    "cell worse than --fail-above",
    explanation="The Q of the cell is above the limit that was set.",
    source="18.2.1",
    calls=("optimize",),
    fix="Mesh anew where the boundary forces bad cells.",
)
def find_worse(study: Examination) -> Places:
    return _beyond(study, _limits(study, "M401"), lambda limit: f"Q above {limit.value:g}")


@rule(
    "M402",
    ERROR,
    "angle beyond a limit",
    explanation="An angle of the cell is beyond --min-angle or --max-angle.",
    source="Definition 18.1",
    calls=("optimize",),
    fix="Choose --measure angle-min or angle-max, or mesh anew around the cell.",
)
def find_angles(study: Examination) -> Places:
    return _beyond(study, _limits(study, "M402"))


@rule(
    "M403",
    ERROR,
    "size below a limit",
    explanation="The shortest edge of the cell is below --min-size.",
    source="18.3.1",
    fix="Optimize with the pass collapse, or mesh anew with a larger size.",
)
def find_small(study: Examination) -> Places:
    return _beyond(study, _limits(study, "M403"))


@rule(
    "M404",
    ERROR,
    "cell beyond another gate",
    explanation="The cell is beyond a limit set by --gate or --max-aspect.",
    source="18.2.2",
    calls=("optimize",),
    fix="Choose the measure that the gate is put on, or mesh anew around the cell.",
)
def find_beyond(study: Examination) -> Places:
    return _beyond(study, _limits(study, "M404"))


@rule(
    "M405",
    WARNING,
    "obtuse angle",
    explanation="A triangle has an angle, or a tetrahedron a dihedral angle, above 90 degrees.",
    source="Definition 18.10",
    fix="Relocate or swap around it; finite volumes are exact on meshes without such angles only.",
    on_request=True,
)
def find_obtuse(study: Examination) -> Places:
    from ...kernels.shape.obtuse import RIGHT  # other rules need no kernels

    limits = [Limit("dihedral-max" if study.dimension == 3 else "corner-max", False, RIGHT)]
    return _beyond(study, limits, lambda _: "an angle of the cell is obtuse", SIMPLICES)


@rule(
    IN_METRIC,
    ERROR,
    "mesh beyond a gate in its metric",
    explanation="A figure of the mesh in the metric of --metric or --size is beyond a --gate.",
    source="18.3",
    fix="Optimize with the same --metric or --size; where the boundary does not fit it, mesh anew.",
)
def find_misfit(study: Examination) -> Places:
    figures = study.figures
    messages = tuple(
        f"{limit.name} is {figures[limit.name]:.6g}, and the gate is {limit}"
        for limit in study.gates.of_mesh
        if limit.name in figures and limit.is_broken_by(figures[limit.name])
    )
    n = len(messages)
    return Places(messages, cells=np.full((n, 2), -1), kinds=np.arange(n))


def _limits(study: Examination, code: str) -> list[Limit]:
    return [limit for limit in study.gates.limits if limit.code == code]


def _beyond(
    study: Examination,
    limits: list[Limit],
    message: Callable[[Limit], str] | None = None,
    families: tuple[str, ...] = (),
) -> Places:
    """The cells beyond each of some limits, with one message a limit."""
    points = study.points if study.plane is None or study.in_two else study.flat_points
    numbers, kinds = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for kind, limit in enumerate(limits):
        chosen = None if limit.region is None else _cells_in(study, limit.region)
        measure = limit.measure
        scale = measure.power(study.dimension) * study.exponent
        for group in study.cell_sets:
            if group.family not in measure.ways or group.family not in (families or measure.ways):
                continue
            values = np.ldexp(measure.of(points, group.cells, group.family), scale)
            beyond = values < limit.value if limit.is_least else values > limit.value
            if chosen is not None:
                beyond &= chosen[group.numbers]
            numbers.append(group.numbers[beyond])
            kinds.append(np.full(int(beyond.sum()), kind))
    say = message or (lambda limit: f"the cell breaks {limit}")
    found = np.concatenate(numbers)
    order = np.argsort(found, kind="stable")
    messages = tuple(say(limit) for limit in limits) or ("",)
    return at_cells(study, found[order], *messages, kinds=np.concatenate(kinds)[order])


def _cells_in(study: Examination, region: str) -> Array:
    """Mask of the cells of a region, by its name or by a tag.

    Raises
    ------
    ConfigError
        The mesh has no such region.
    """
    found = cells_in(study.mesh, region, study.dimension)
    if found is None:
        names = [name for (d, _), name in study.mesh.names.items() if d == study.dimension]
        known = ", ".join(names) or "none has a name"
        raise ConfigError(f"no region {region!r} to put a gate on: {known}")
    inside = np.concatenate([np.zeros(0, dtype=bool), *found])
    if not inside.any():
        raise ConfigError(f"no cell is in the region {region!r} that a gate is put on")
    return inside
