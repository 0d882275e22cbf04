"""The JSON schema of pipeline files, for editors."""

from __future__ import annotations

from typing import Any

from .items import DRIVING, schemas
from .presets import PRESETS
from .sources import KEYS

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema() -> dict[str, Any]:
    """The schema of a pipeline file, made of the tables that it is read by."""
    keys = {key: value.schema() for key, value in KEYS.items()}
    keys["preset"] = {"enum": list(PRESETS)}
    keys["measure"] = {"enum": list(DRIVING)}
    return {
        "$schema": DIALECT,
        "title": "Pipelines of meshopt optimize",
        "type": "object",
        "properties": keys,
        "additionalProperties": False,
        "$defs": schemas(),
    }
