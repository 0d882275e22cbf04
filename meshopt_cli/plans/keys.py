"""What keys of a pipeline file take, and what is said of a value that is none of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from ..errors import ConfigError, hint
from .ranges import Range, cut, quoted

# Keys and rows that lead to a value.
Place = tuple[str | int, ...]


class WrongKeyError(ConfigError):
    """A key or a value of a file that is wrong, and where it stands there."""

    def __init__(self, place: Place, message: str) -> None:
        super().__init__(message)
        self.place = place


class Value(Protocol):
    """What a key takes."""

    def taken(self, value: Any, place: Place) -> Any:
        """The value as it is used.

        Raises
        ------
        WrongKeyError
        """

    def schema(self) -> dict[str, Any]:
        """The same as a JSON schema."""


def wrong_kind(place: Place, value: Any) -> WrongKeyError:
    """What is said of a value of a wrong kind."""
    return WrongKeyError(place, f"{label(place)} has a value of a wrong kind: {quoted(value)}")


def label(place: Place) -> str:
    """The last key that leads to a value."""
    return next((cut(key) for key in reversed(place) if isinstance(key, str)), "it")


def unknown(place: Place, key: str, known: Iterable[str]) -> WrongKeyError:
    """What is said of a key that is none of those known."""
    return WrongKeyError((*place, key), f"unknown key {quoted(key)}{hint(key, known)}")


@dataclass(frozen=True)
class Number:
    """A number within a range."""

    range: Range

    def taken(self, value: Any, place: Place) -> Any:
        try:
            return self.range.of_file(value)
        except ValueError as error:
            raise WrongKeyError(place, f"{label(place)}: {error}") from None

    def schema(self) -> dict[str, Any]:
        limits: dict[str, Any] = {"type": "integer" if self.range.is_whole else "number"}
        limits["exclusiveMinimum" if self.range.is_open else "minimum"] = self.range.least
        return limits if math.isinf(self.range.most) else limits | {"maximum": self.range.most}


@dataclass(frozen=True)
class Text:
    """Any text, or one of some words."""

    words: tuple[str, ...] = ()

    def taken(self, value: Any, place: Place) -> Any:
        if not isinstance(value, str):
            raise wrong_kind(place, value)
        if self.words and value not in self.words:
            raise WrongKeyError(
                place, f"no {label(place)} {quoted(value)}{hint(value, self.words)}"
            )
        return value

    def schema(self) -> dict[str, Any]:
        return {"enum": list(self.words)} if self.words else {"type": "string"}


@dataclass(frozen=True)
class Texts:
    """A list of texts."""

    def taken(self, value: Any, place: Place) -> Any:
        if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
            raise wrong_kind(place, value)
        return value

    def schema(self) -> dict[str, Any]:
        return {"type": "array", "items": {"type": "string"}}


@dataclass(frozen=True)
class Flag:
    """Yes or no."""

    def taken(self, value: Any, place: Place) -> Any:
        if not isinstance(value, bool):
            raise wrong_kind(place, value)
        return value

    def schema(self) -> dict[str, Any]:
        return {"type": "boolean"}


@dataclass(frozen=True)
class Table:
    """A table of keys, some of which it must have."""

    keys: Mapping[str, Value]
    required: tuple[str, ...] = ()

    def taken(self, value: Any, place: Place) -> Any:
        if not isinstance(value, dict):
            raise wrong_kind(place, value)
        found = {}
        for key, one in value.items():
            if key not in self.keys:
                raise unknown(place, key, self.keys)
            found[key] = self.keys[key].taken(one, (*place, key))
        for key in self.required:
            if key not in found:
                raise WrongKeyError(place, f"[{label(place)}] has no {key}")
        return found

    def schema(self) -> dict[str, Any]:
        return closed({k: value.schema() for k, value in self.keys.items()}, self.required)


def closed(keys: dict[str, Any], required: Iterable[str] = ()) -> dict[str, Any]:
    """The JSON schema of a table that has no other keys."""
    made = {"type": "object", "properties": keys, "additionalProperties": False}
    return made | {"required": list(required)} if required else made
