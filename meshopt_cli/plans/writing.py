"""What holds, as a file that says the same."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from .items import Item
from .sources import KEYS, KINDS, Settled

WIDTH = 100
TITLE = "What holds here. Saved as meshopt.toml or given to --config it says the same again."


def text_of(holds: Settled) -> str:
    """A pipeline file that says what holds, with who said it as comments."""
    lines = [f"# {TITLE}"]
    for key in KEYS:
        if key in holds.values and key not in KINDS and key != "pipeline":
            value = _value(holds.values[key])
            lines.append(f"{key} = {value}  # {_comment(holds.origins[key])}")
    lines += [f"# --set {_comment(setting)}" for setting, _ in holds.settings]
    if "pipeline" in holds.values:
        lines += ["", f"# {_comment(holds.origins['pipeline'])}"]
        lines += _pipeline(holds.values["pipeline"])
    for kind in KINDS:
        if kind in holds.values:
            table = holds.values[kind]
            lines += ["", f"[{kind}]  # {KINDS[kind]}: {_comment(holds.origins[kind])}"]
            lines += [f"{key} = {_value(table[key])}" for key in table if key != "pipeline"]
            lines += _pipeline(table["pipeline"])
    return "\n".join(lines) + "\n"


def _comment(text: str) -> str:
    """A text in a comment, which ends with the line."""
    return text if text.isprintable() else repr(text)


def _pipeline(items: list[Item]) -> Iterator[str]:
    yield "pipeline = ["
    for item in items:
        yield from _lines(item, 1)
    yield "]"


def _lines(item: Item, depth: int) -> Iterator[str]:
    """An item in a list, in one line where there is room."""
    margin = "  " * depth
    whole = f"{margin}{_value(item)},"
    inner = [key for key, value in item.items() if isinstance(value, list)]
    if not inner or len(whole) <= WIDTH:
        yield whole
        return
    begin = "{ "
    for key in inner:
        yield f"{margin}{begin}{key} = ["
        for one in item[key]:
            yield from _lines(one, depth + 1)
        begin = "], "
    rest = [f"{key} = {_value(value)}" for key, value in item.items() if key not in inner]
    yield f"{margin}{', '.join([']', *rest])} }},"


def _value(value: Any) -> str:
    """A value of TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # What JSON has in a text TOML has too, but for this character.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, dict):
        inside = ", ".join(f"{key} = {_value(one)}" for key, one in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    return "inf" if value == math.inf else repr(value)
