"""Pipelines as they are written: lists of tables, each a pass or a part that holds others.

What is read here is a list of plain tables, checked and without references; `build.py` makes stages
of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cache
from typing import Any

from ..errors import ConfigError, hint
from ..passes import PASSES, Pass
from ..quality.measures import QUALITIES, Measure, measure_named
from .keys import (
    Flag,
    Number,
    Place,
    Table,
    Text,
    Value,
    WrongKeyError,
    closed,
    unknown,
    wrong_kind,
)
from .ranges import MOST, RANGES, Range, quoted
from .settings import option_of, pass_named, value_of

Item = dict[str, Any]
Parts = Mapping[str, Any]

MOST_ITEMS = 10_000  # of a pipeline, those of parts each time that they are run
PASS, RUN = "pass", "run"
NAMED = "named-"  # begins the schemas of passes that are named by `name`

DRIVING = tuple(name for name, row in QUALITIES.items() if row.drives)  # measures

# When rounds end; what is left out is as the pipeline says.
UNTIL = Table({
    "rounds": Number(RANGES["rounds"]),
    "gain": Number(RANGES["gain"]),
    "gain-factor": Number(Range(0, 1e6)),
    "target-quality": Number(RANGES["target-quality"]),
    "settled": Number(Range(1)),
})  # fmt: skip


@dataclass(frozen=True)
class ItemList:
    """A list of items; each reader of them knows what an item is."""

    def taken(self, value: Any, place: Place) -> Any:
        if not isinstance(value, list):
            raise wrong_kind(place, value)
        return value

    def schema(self) -> dict[str, Any]:
        return {"type": "array", "items": {"$ref": "#/$defs/item"}}


ITEMS = ItemList()


@dataclass(frozen=True)
class Form:
    """An item that holds others.

    Attributes
    ----------
    head : str
        The key that tells it, whose value is a list of items.
    keys : dict of str to Value
        What else it may say.
    """

    head: str
    summary: str
    keys: Mapping[str, Value]


FORMS = {
    form.head: form
    for form in (
        Form(
            "repeat",
            "rounds of items, until nothing changes or `until` is met (`rounds`, `gain`, "
            "`gain-factor` times the gain of the pipeline, `target-quality`, or no cell worse than "
            "`settled`; as the pipeline says where they are left out); they end on the best mesh, "
            "or with `guarded = false` on the last",
            {"until": UNTIL, "guarded": Flag()},
        ),
        Form(
            "steps",
            "items, one after the other; of a mesh of `max-cells` at most, or steered by another "
            "`measure` than the run, where that is said",
            {"max-cells": Number(Range(0, MOST, is_whole=True)), "measure": Text(DRIVING)},
        ),
        Form(
            "angles",
            "items for which dihedral angles of tetrahedra count beside Q, or before it where that "
            "is good enough (`lenient`)",
            {"lenient": Flag()},
        ),
        Form("unsettled", "items, unless all vertices moved at once just before", {}),
        Form(
            "try",
            "items that make other cells, and where they do `then` what is made of them; kept "
            "where the worst and the mean Q gain",
            {"then": ITEMS},
        ),
    )
}
HEADS = (PASS, *FORMS, RUN)


class Reader:
    """Reads items, and puts the parts that they run in their place.

    Parameters
    ----------
    parts : mapping
        Lists of items by name, as they were read.
    others : function of a name
        The parts of a preset.
    """

    def __init__(self, parts: Parts, others: Callable[[str], Parts]) -> None:
        self._parts = parts
        self._others = others
        self._read_parts: dict[str, tuple[list[Item], int]] = {}  # with how many items they are
        self._presets: dict[str, Reader] = {}
        self._n_items = 0

    def part(self, name: str, running: tuple[str, ...] = ()) -> list[Item]:
        """The items of a part; errors as those of `read`."""
        if name not in self._read_parts:
            before = self._n_items
            found = self.read(self._parts[name], ("parts", name), (*running, name))
            self._read_parts[name] = found, self._n_items - before
            self._n_items = before
        found, n = self._read_parts[name]
        self._n_items += n
        return found

    def read(self, rows: Any, place: Place, running: tuple[str, ...] = ()) -> list[Item]:
        """The items of a list.

        Raises
        ------
        WrongKeyError
            One of them is none: the message says why, and it knows where.
        """
        found = []
        for i, row in enumerate(ITEMS.taken(rows, place)):
            found += self._read(row, (*place, i), running)
            if self._n_items > MOST_ITEMS:
                raise WrongKeyError(
                    (*place, i), f"a pipeline has {MOST_ITEMS:,} items at most, those of parts too"
                )
        return found

    def _read(self, row: Any, place: Place, running: tuple[str, ...]) -> list[Item]:
        head = _head_of(row, place)
        self._n_items += 1
        if head == PASS:
            return [pass_item(row, PASS, place)]
        if head == RUN:
            return self._run(row, place, running)
        form, item = FORMS[head], {}
        for key, value in row.items():
            here = (*place, key)
            if key != head and key not in form.keys:
                raise unknown(place, key, (head, *form.keys))
            if key == head or form.keys[key] is ITEMS:
                item[key] = self.read(value, here, running)
            else:
                item[key] = form.keys[key].taken(value, here)
        return [item]

    def _run(self, row: Item, place: Place, running: tuple[str, ...]) -> list[Item]:
        """The items of a part, of this file or of a preset as in "standard/begin"."""
        name = Text().taken(row[RUN], (*place, RUN))
        for key in row:
            if key != RUN:
                raise unknown(place, key, [RUN])
        if name in running:
            raise WrongKeyError((*place, RUN), f"the part {quoted(name)} runs itself")
        preset, slash, part = name.partition("/")
        if not slash:
            if name not in self._parts:
                there = hint(name, self._parts) if self._parts else ": the file has no [parts]"
                raise WrongKeyError((*place, RUN), f"no part {quoted(name)}{there}")
            return self.part(name, running)
        try:
            others = self._others(preset)
        except ConfigError as error:
            raise WrongKeyError((*place, RUN), str(error)) from None
        if part not in others:
            said = f"no part {quoted(part)} of {preset}{hint(part, others)}"
            raise WrongKeyError((*place, RUN), said)
        reader = self._presets.setdefault(preset, Reader(others, self._others))
        before = reader._n_items
        found = reader.part(part)
        self._n_items += reader._n_items - before
        return found


def _head_of(row: Any, place: Place) -> str:
    """The key that tells what an item is."""
    if not isinstance(row, dict):
        raise WrongKeyError(place, f"an item of a pipeline is a table, not {quoted(row)}")
    if PASS in row:  # whose options may have the names of others
        return PASS
    heads = [key for key in row if key in HEADS]
    if len(heads) > 1:
        raise WrongKeyError((*place, heads[1]), f"{heads[0]} and {heads[1]} exclude each other")
    if not heads:
        wanted = ", ".join(HEADS)
        for key in row:
            if not any(key in form.keys for form in FORMS.values()):
                raise WrongKeyError((*place, key), f"unknown key {quoted(key)}{hint(key, HEADS)}")
        raise WrongKeyError(place, f"an item of a pipeline has one of the keys {wanted}")
    return heads[0]


def pass_item(row: Item, head: str, place: Place) -> Item:
    """A pass and its options, checked.

    Parameters
    ----------
    head : str
        The key that names the pass.
    """
    name = row[head]
    if not isinstance(name, str):
        raise wrong_kind((*place, head), name)
    try:
        kind = pass_named(name)
    except ConfigError as error:
        raise WrongKeyError((*place, head), str(error)) from None
    item = {PASS: name}
    for key, value in row.items():
        if key != head:
            try:
                option, taken = option_of(kind, key, value)
            except ConfigError as error:
                raise WrongKeyError((*place, key), str(error)) from None
            item[option.replace("_", "-")] = taken
    try:
        pass_of(item)
    except ConfigError as error:  # it names the option
        wrong = [key for key in row if f".{key.replace('_', '-')}:" in str(error)]
        raise WrongKeyError((*place, *wrong[:1]), str(error)) from None
    return item


def pass_of(item: Item) -> Pass:
    """The pass of an item.

    Raises
    ------
    ConfigError
        An option is out of range.
    """
    return _pass(item[PASS], tuple((key, value) for key, value in item.items() if key != PASS))


@cache
def _pass(name: str, options: tuple[tuple[str, Any], ...]) -> Pass:
    """A pass, which is a value: of those that are alike there is one."""
    return PASSES[name](**{key.replace("-", "_"): value for key, value in options})


def passes_in(items: list[Item]) -> Iterator[Item]:
    """The items that are passes, wherever in others."""
    for item in items:
        if PASS in item:
            yield item
        for value in item.values():
            if isinstance(value, list):
                yield from passes_in(value)


def measures_in(items: list[Item]) -> Iterator[Measure]:
    """The measures that steer some items."""
    for item in items:
        if "measure" in item:
            yield measure_named(item["measure"])
        for value in item.values():
            if isinstance(value, list):
                yield from measures_in(value)


def schemas() -> dict[str, Any]:
    """JSON schemas of an item: `item`, and one for each pass, by either key, and each form."""
    found = {f"pass-{name}": _schema_of(kind, PASS) for name, kind in PASSES.items()}
    for head, form in FORMS.items():
        keys = {head: ITEMS.schema(), **{key: value.schema() for key, value in form.keys.items()}}
        found[head] = closed(keys, [head]) | {"description": form.summary}
    found[RUN] = closed({RUN: Text().schema()}, [RUN])
    item = {"type": "object", "oneOf": [{"$ref": f"#/$defs/{name}"} for name in found]}
    named = {f"{NAMED}{name}": _schema_of(kind, "name") for name, kind in PASSES.items()}
    return {"item": item, **found, **named}


def _schema_of(kind: type[Pass], head: str) -> dict[str, Any]:
    """The JSON schema of a pass and its options."""
    keys: dict[str, Any] = {head: {"const": kind.name}}
    for f in fields(kind):
        said = {"default": f.default, "description": f.metadata["help"]}
        keys[f.name.replace("_", "-")] = value_of(f).schema() | said
    return closed(keys, [head]) | {"description": kind.summary}
