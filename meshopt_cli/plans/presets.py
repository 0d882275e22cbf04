"""Named pipelines: the files in `pipelines/`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ..errors import chosen
from ..work.kinds import SIMPLICES
from .build import stages_of, stop_of
from .items import Parts
from .sources import Settled, kind_named, settled, taken
from .stages import Stage
from .stop import Stop
from .toml import read_toml

DEFAULT_PRESET = "standard"
ADAPT = "adapt"  # the default where there is a metric
FOLDER = Path(__file__).parent / "pipelines"


@dataclass(frozen=True)
class Preset:
    """A pipeline by name, which is that of a file; it is read when something of it is asked."""

    name: str

    @cached_property
    def table(self) -> dict[str, Any]:
        """The file as it stands."""
        return read_toml(FOLDER / f"{self.name}.toml")

    @cached_property
    def said(self) -> Settled:
        """What the file says."""
        return settled(taken(self.table, parts_of), f"preset {self.name}")

    @property
    def summary(self) -> str:
        return str(self.table["summary"])

    @property
    def all_measures(self) -> bool:
        """Whether it is for more than one measure, so that a report tells the others too."""
        return bool(self.table.get("all-measures", False))

    @property
    def stops(self) -> dict[int, Stop]:
        """When its rounds end by the dimension of the mesh, where the user says nothing."""
        tables = {d: self.said.values[kind_named(d, SIMPLICES)] for d in (2, 3)}
        return {d: stop_of(table, Stop()) for d, table in tables.items()}

    def build(self, stop: Stop, dimension: int) -> tuple[Stage, ...]:
        """Its stages for simplices."""
        return self.stages(stop, dimension, SIMPLICES)

    def stages(self, stop: Stop, dimension: int, kind: str) -> tuple[Stage, ...]:
        """Its stages for a kind of working mesh that it has any for."""
        items = self.said.values[kind_named(dimension, kind)]["pipeline"]
        return stages_of(items, stop)


PRESETS: dict[str, Preset] = {name: Preset(name) for name in ("fast", "standard", "best", ADAPT)}


def preset_named(name: str) -> Preset:
    """The preset of this name.

    Raises
    ------
    ConfigError
        There is none: the message lists them.
    """
    return chosen(PRESETS, name, "preset")


def parts_of(name: str) -> Parts:
    """The parts of a preset; errors as those of `preset_named`."""
    parts: Parts = preset_named(name).table.get("parts", {})
    return parts
