"""Limits that the user sets: M4xx."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...cells import SIMPLICES
from ...errors import ConfigError
from ...mesh.model import Array
from ...mesh.tags import PHYSICAL, TAG_NAMES, regions_in
from ...quality.gates import Limit
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
    inside = np.zeros(study.n_cells, dtype=bool)
    names = {tag: name for (d, tag), name in study.mesh.names.items() if d == study.dimension}
    wanted = [tag for tag, name in names.items() if name == region]
    arrays: tuple[str, ...] = (PHYSICAL,)
    if not wanted and region.lstrip("-").isdigit():
        wanted = [int(region)]
        arrays = study.mesh.regions or (*TAG_NAMES, *regions_in(study.mesh).arrays)
    if not wanted:
        known = ", ".join(names.values()) or "none has a name"
        raise ConfigError(f"no region {region!r} to put a gate on: {known}")
    for block, first in zip(study.mesh.blocks, study.offsets, strict=False):
        for name in arrays:
            values = block.data.get(name)
            if values is not None and values.ndim == 1:
                inside[first : first + len(block.cells)] |= np.isin(values, wanted)
                break
    if not inside.any():
        raise ConfigError(f"no cell is in the region {region!r} that a gate is put on")
    return inside
