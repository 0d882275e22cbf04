"""Help, version, and the lists of names."""

import re
from dataclasses import fields

import click
import pytest

from meshopt_cli import __version__
from meshopt_cli.cli.main import COMMANDS, STATUSES, main
from meshopt_cli.formats import FORMATS
from meshopt_cli.passes import PASSES
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.validity import RULES
from support.processes import ESCAPE, outside


def test_help_of_the_module_shows_the_exit_statuses():
    ran = outside("--help")
    assert (ran.status, ran.err) == (0, "")
    text = " ".join(ran.out.split())
    for status, meaning in STATUSES.items():
        assert f"{status} {meaning}" in text
    for command in COMMANDS:
        assert re.search(rf"^  {command} ", ran.out, re.M)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_shows_all_its_options(meshopt, command):
    ran = meshopt(command, "--help")
    assert (ran.status, ran.err) == (0, "")
    parameters = main.get_command(click.Context(main), command).params
    options = [name for p in parameters if isinstance(p, click.Option) for name in p.opts]
    assert options or command in ("list", "schema")
    assert all(option in ran.out for option in options)


def test_version(meshopt):
    assert meshopt("--version").out.split()[-1] == __version__


@pytest.mark.parametrize(
    ("name", "table"),
    [
        ("passes", PASSES),
        ("measures", QUALITIES),
        ("formats", FORMATS),
        ("rules", RULES),
        ("presets", PRESETS),
    ],
)
def test_list_shows_every_name_of_a_table(meshopt, name, table):
    ran = meshopt("list", name)
    assert (ran.status, ran.err) == (0, "")
    first = [line.split()[0] for line in ran.out.splitlines() if line.strip() and line[0] != " "]
    assert first[: len(table)] == list(table) or [w for w in first if w in table] == list(table)
    assert ESCAPE not in ran.out


def test_list_shows_the_options_of_the_passes(meshopt):
    out = meshopt("list", "passes").out
    for kind in PASSES.values():
        names = [f.name.replace("_", "-") for f in fields(kind)]
        if names:
            part = out.split(f"options of {kind.name} ")[1].split("options of ")[0]
            assert all(re.search(rf"^ +{name} ", part, re.M) for name in names)
