"""What a pipeline file says, and what holds of several of them: the later wins."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..errors import ConfigError
from ..passes import PASSES
from ..quality.measures import measure_named
from ..work.kinds import CELLS, FACES, SIMPLICES
from .items import ITEMS, NAMED, PASS, Item, Parts, Reader, pass_item, passes_in
from .keys import Flag, Number, Place, Table, Text, Texts, Value, WrongKeyError, unknown, wrong_kind
from .ranges import RANGES, quoted
from .toml import read_text, tables_of

STOPS = ("rounds", "gain", "target-quality")
NUMBERS = (*STOPS, "time-limit", "threads", "below")
SELECT = ("only", "freeze")  # lists of what is selected
# Tables for kinds of meshes: their keys are those of `STOPS` and the pipeline.
PLANE, SPACE = "plane", "space"
KINDS = {
    PLANE: "triangles",
    SPACE: "tetrahedra",
    CELLS: "solids of any cells",
    FACES: "faces of a plane, quads among them",
}
CHECK = "check"  # the table of another command
_KIND = Table({**{key: Number(RANGES[key]) for key in STOPS}, "pipeline": ITEMS}, ("pipeline",))


@dataclass(frozen=True)
class PartTable:
    """Lists of items by name."""

    def taken(self, value: Any, place: Place) -> Any:
        if not isinstance(value, dict):
            raise wrong_kind(place, value)
        return {key: ITEMS.taken(rows, (*place, key)) for key, rows in value.items()}

    def schema(self) -> dict[str, Any]:
        return {"type": "object", "additionalProperties": ITEMS.schema()}


@dataclass(frozen=True)
class PassList:
    """A list of passes, each with its name and its options."""

    def taken(self, value: Any, place: Place) -> Any:
        rows = ITEMS.taken(value, place)
        for i, row in enumerate(rows):
            if not isinstance(row, dict) or not isinstance(row.get("name"), str):
                wanted = f"each [[{place[0]}]] needs a name, one of {', '.join(PASSES)}"
                raise WrongKeyError((*place, i), wanted)
        return [pass_item(row, "name", (*place, i)) for i, row in enumerate(rows)]

    def schema(self) -> dict[str, Any]:
        passes = [{"$ref": f"#/$defs/{NAMED}{name}"} for name in PASSES]
        return {"type": "array", "items": {"type": "object", "oneOf": passes}}


@dataclass(frozen=True)
class Anything:
    """A table of another command."""

    def taken(self, value: Any, place: Place) -> Any:
        if not isinstance(value, dict):
            raise wrong_kind(place, value)
        return value

    def schema(self) -> dict[str, Any]:
        return {"type": "object"}


# The keys of a pipeline file, and what each takes.
KEYS: dict[str, Value] = {
    "summary": Text(),
    "preset": Text(),
    "measure": Text(),
    "all-measures": Flag(),
    **{key: Number(RANGES[key]) for key in NUMBERS},
    "allow": Texts(),
    **dict.fromkeys(SELECT, Texts()),
    "before": PassList(),
    "pass": PassList(),
    "pipeline": ITEMS,
    **dict.fromkeys(KINDS, _KIND),
    "parts": PartTable(),
    CHECK: Anything(),
}
# What says which pipeline it is: it takes the place of all that was said of that before.
_CHOICE = {"preset", "pipeline", *KINDS}
_OF_CHOICE = _CHOICE | {"all-measures", "summary"}
_EXCLUDE = [("preset", key) for key in ("pass", "before", "pipeline", *KINDS)]
_EXCLUDE += [(old, key) for old in ("pass", "before") for key in ("pipeline", *KINDS)]


@dataclass(frozen=True)
class Settled:
    """What holds, and who said it.

    Attributes
    ----------
    values : dict
        By keys of `KEYS`; pipelines as items, without parts.
    origins : dict of str to str
        A file or an option by the keys of `values`.
    preset : str
        Whose pipeline it is, if it is that of a preset.
    settings : tuple of (str, str)
        What was set in passes, as it was written, and the name of the pass.
    """

    values: dict[str, Any] = field(default_factory=dict)
    origins: dict[str, str] = field(default_factory=dict)
    preset: str = ""
    settings: tuple[tuple[str, str], ...] = ()

    def then(self, later: Settled) -> Settled:
        """What holds when others say something after it, who win."""
        values, origins = dict(self.values), dict(self.origins)
        if not _CHOICE.isdisjoint(later.values):
            for key in _OF_CHOICE:
                values.pop(key, None)
                origins.pop(key, None)
        for kind in KINDS:
            if kind in values:
                table = values[kind]
                values[kind] = {key: table[key] for key in table if key not in later.values}
        return Settled(values | later.values, origins | later.origins)

    def pipelines(self) -> Iterator[list[Item]]:
        """The items of the pipeline for all meshes, and of those for kinds of them."""
        for table in (self.values, *(self.values[kind] for kind in KINDS if kind in self.values)):
            if "pipeline" in table:
                yield table["pipeline"]

    def passes(self) -> set[str]:
        """The names of the passes that some of its pipelines has."""
        return {item[PASS] for items in self.pipelines() for item in passes_in(items)}

    def mapped(self, change: Callable[[list[Item]], list[Item]]) -> Settled:
        """The same with other items in each of its pipelines."""
        values = dict(self.values)
        for kind in KINDS:
            if kind in values:
                values[kind] = values[kind] | {"pipeline": change(values[kind]["pipeline"])}
        if "pipeline" in values:
            values["pipeline"] = change(values["pipeline"])
        return replace(self, values=values)

    @property
    def is_chosen(self) -> bool:
        """Whether it has a pipeline."""
        return "pipeline" in self.values or any(kind in self.values for kind in KINDS)


def settled(values: Mapping[str, Any], origin: str) -> Settled:
    """What one source says; what is None is not said."""
    said = {key: value for key, value in values.items() if value is not None}
    return Settled(said, dict.fromkeys(said, origin))


def kind_named(dimension: int, kind: str) -> str:
    """The key of `KINDS` for meshes of a dimension and a kind of working mesh."""
    return (PLANE if dimension == 2 else SPACE) if kind == SIMPLICES else kind


def read_source(
    path: Path, others: Callable[[str], Parts], keys: tuple[str, ...] = ()
) -> Settled | None:
    """What a file says; None where it has no such table.

    Parameters
    ----------
    others : function of a name
        The parts of a preset.
    keys : tuple of str
        Where the table stands in it.

    Raises
    ------
    ConfigError
        The file cannot be read, is no TOML, or a key is unknown or of a wrong value: file, line.
    """
    text = read_text(path)
    if keys and keys[-1] not in text:  # whatever else may be wrong with it
        return None
    table = tables_of(path, text)
    for key in keys:
        table = table.get(key) if isinstance(table, dict) else None  # type: ignore[assignment]
    if table is None:
        return None
    try:
        if not isinstance(table, dict):
            raise WrongKeyError((), f"[{'.'.join(keys)}] must be a table")
        return settled(taken(table, others), str(path))
    except WrongKeyError as error:
        from .lines import line_of  # seldom needed

        line = line_of(text, (*keys, *error.place))
        raise ConfigError(f"{path}:{line}: {error}") from None
    except RecursionError as error:
        raise ConfigError(f"{path}: lists or tables lie too deep") from error


def taken(table: Mapping[str, Any], others: Callable[[str], Parts]) -> dict[str, Any]:
    """What a table says, its parts in the place of what runs them.

    Raises
    ------
    WrongKeyError
    """
    for key in table:
        if key not in KEYS:
            raise unknown((), key, KEYS)
    for one, other in _EXCLUDE:
        if one in table and other in table:
            said = "a preset and a list of passes exclude each other"
            raise WrongKeyError((other,), said if one == "preset" else f"{one} excludes {other}")
    values = {key: KEYS[key].taken(value, (key,)) for key, value in table.items()}
    values.pop(CHECK, None)
    if "preset" in values:
        try:
            others(values["preset"])
        except ConfigError as error:
            raise WrongKeyError(("preset",), str(error)) from None
    if "measure" in values:
        try:
            measure = measure_named(values["measure"])
        except ConfigError as error:
            raise WrongKeyError(("measure",), str(error)) from None
        if not measure.drives:
            said = f"measure {measure.name} is for reports and gates: it cannot steer"
            raise WrongKeyError(("measure",), said)
    parts = values.pop("parts", {})
    reader = Reader(parts, others)
    for name in parts:  # those that nothing runs, too
        if "/" in name:
            raise WrongKeyError(("parts", name), f"{quoted(name)}: no name of a part has a /")
        reader.part(name)
    if "pass" in values or "before" in values:
        rounds = values.pop("pass", [])
        values["pipeline"] = values.pop("before", []) + ([{"repeat": rounds}] if rounds else [])
    elif "pipeline" in values:
        values["pipeline"] = reader.read(values["pipeline"], ("pipeline",))
    for kind in KINDS:
        if kind in values:
            rows = reader.read(values[kind]["pipeline"], (kind, "pipeline"))
            values[kind] = {**values[kind], "pipeline": rows}
    return values


def changed(items: Iterable[Item], name: str, options: Item) -> list[Item]:
    """Items with options set in every pass of a name."""
    found = []
    for item in items:
        made = {
            key: changed(value, name, options) if isinstance(value, list) else value
            for key, value in item.items()
        }
        found.append(made | options if made.get(PASS) == name else made)
    return found
