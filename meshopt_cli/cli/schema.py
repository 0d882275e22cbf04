"""`meshopt schema`."""

from __future__ import annotations

import json

import click


@click.command("schema")
def command() -> None:
    """Print the JSON schema of pipeline files, for editors that know TOML."""
    from ..plans.schema import schema

    click.echo(json.dumps(schema(), indent=2, allow_nan=False))
