"""What the README and the pre-commit hook say is what the code does."""

import os
import re
import shlex
import shutil
import subprocess
import sys

import click
import pytest

from meshopt_cli.cli.check import command
from meshopt_cli.cli.entry import status_of
from meshopt_cli.cli.main import main
from meshopt_cli.formats import FORMATS
from meshopt_cli.plans.items import FORMS
from meshopt_cli.quality.gates import FIGURES
from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.repairs import MENDS
from meshopt_cli.validity import RULES
from support.samples import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
CHECK = README[README.index("### Check") : README.index("### Repair")]


def rows_of(text):
    """The cells of the rows of all tables in a text."""
    return [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text.splitlines()
        if line.startswith("|") and not line.startswith("|---")
    ]


def test_the_table_of_rules():
    rows = [row for row in rows_of(CHECK) if re.fullmatch(r"M\d{3}", row[0])]
    assert rows == [
        [
            rule.code,
            rule.severity + (", on request" if rule.on_request else ""),
            rule.title,
            rule.explanation,
            ", ".join(f"`{call}`" for call in rule.calls),
        ]
        for rule in RULES.values()
    ]


def test_the_table_of_options():
    named = set(re.findall(r"`(--?[a-z-]+)", " ".join(row[0] for row in rows_of(CHECK))))
    options = {opt for p in command.params if isinstance(p, click.Option) for opt in p.opts}
    short = {opt for opt in options if not opt.startswith("--")}
    assert named - short == options - short - {"--quiet", "--verbose"}
    assert short == {"-q", "-v"}


def test_all_quantities_are_named():
    assert all(f"`{name}`" in CHECK for name, row in MEASURES.items() if not row.is_quality)


def test_the_table_of_figures_in_a_metric():
    rows = [row for row in rows_of(CHECK) if row[0].strip("`") in FIGURES]
    assert rows == [[f"`{figure.name}`", figure.summary] for figure in FIGURES.values()]


def test_the_configuration_works(tmp_path, monkeypatch, samples):
    (example,) = re.findall(r"```toml\n(\[check\].*?)```", CHECK, re.DOTALL)
    (tmp_path / "meshopt.toml").write_text(example)
    monkeypatch.chdir(tmp_path)
    # The region is one of the reader's; all the rest is taken as it stands.
    assert status_of(["check", str(samples / "grid.vtk")]) == 2
    lines = [line for line in example.splitlines() if "gate" not in line]
    (tmp_path / "meshopt.toml").write_text("\n".join(lines))
    assert status_of(["check", str(samples / "two_regions.msh")]) in (0, 1)


def test_the_loop_that_adapts_runs(tmp_path, samples):
    """The sample of solve, estimate, adapt: each turn has less error than the one before."""
    script = samples / "adapt" / "adapt.py"
    ran = subprocess.run(
        [sys.executable, script, tmp_path / "out", "2"], capture_output=True, text=True, check=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    errors = [float(line.split()[-1]) for line in ran.stdout.splitlines()[1:]]
    assert len(errors) == 3
    assert errors[0] > 1.5 * errors[1] > 2.0 * errors[2]


@pytest.mark.skipif(shutil.which("make") is None, reason="there is no make")
def test_the_makefile_rule_works(tmp_path, samples):
    (rule,) = re.findall(r"```make\n(checked.*?)```", CHECK, re.DOTALL)
    (tmp_path / "Makefile").write_text(rule)
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "a.msh").write_bytes((samples / "two_regions.msh").read_bytes())
    (tmp_path / "meshes" / "b.msh").write_bytes(b"")
    (tmp_path / "meshopt").write_text(f'#!/bin/sh\nexec {sys.executable} -m meshopt_cli "$@"\n')
    (tmp_path / "meshopt").chmod(0o755)

    def make(name):
        path = {"PATH": f"{tmp_path}:/usr/bin:/bin", "PYTHONPATH": str(ROOT)}
        ran = subprocess.run(["make", "-s", name], cwd=tmp_path, env=path, capture_output=True,
                             check=False)  # fmt: skip
        return ran.returncode, (tmp_path / name).exists()

    assert make("checked/a.ok") == (0, True)
    assert make("checked/b.ok") == (2, False)


def test_the_hook():
    hook = (ROOT / ".pre-commit-hooks.yaml").read_text()
    assert re.search(r"id: (\S+)", hook)[1] in CHECK
    files = re.search(r"files: (\S+)", hook)[1]
    extensions = {extension for row in FORMATS.values() for extension in row.extensions}
    assert all(re.search(files, f"mesh{extension}") for extension in extensions)
    assert not re.search(files, "mesh.txt")


@pytest.mark.parametrize("name", ["two_regions.msh", "broken.vtk"])
def test_the_hook_runs(samples, name):
    hook = (ROOT / ".pre-commit-hooks.yaml").read_text()
    program, *arguments = shlex.split(re.search(r"entry: (.+)", hook)[1])
    assert program == "meshopt"
    assert status_of([*arguments, str(samples / name)]) == (1 if name == "broken.vtk" else 0)


def test_the_table_of_mends():
    repair = README[README.index("### Repair") : README.index("### Passes")]
    rows = [row for row in rows_of(repair) if row[0].removeprefix("`--").strip("`") in MENDS]
    assert rows == [[f"`--{mend.name}`", mend.summary] for mend in MENDS.values()]


def test_the_table_of_items():
    pipelines = README[README.index("### Pipelines") : README.index("## What is kept")]
    rows = [row for row in rows_of(pipelines) if row[0].strip("`") in FORMS]
    assert rows == [[f"`{form.head}`", form.summary] for form in FORMS.values()]


@pytest.mark.parametrize("k", [0, 1])
def test_the_pipelines_work(tmp_path, samples, k):
    pipelines = README[README.index("### Pipelines") : README.index("## What is kept")]
    example = re.findall(r"```toml\n(.*?)```", pipelines, re.DOTALL)[k]
    (tmp_path / "a.toml").write_text(example)
    mesh, output = str(samples / "grid.vtk"), str(tmp_path / "out.vtk")
    assert status_of(["optimize", mesh, output, "--config", str(tmp_path / "a.toml")]) == 0


@pytest.mark.parametrize("subcommand", ["optimize", "report", "view", "repair"])
def test_the_readme_has_every_option_and_format(subcommand):
    command = main.get_command(click.Context(main), subcommand)
    for parameter in command.params:
        if isinstance(parameter, click.Option) and parameter.name != "help":
            for name in (*parameter.opts[:1], *parameter.secondary_opts):
                assert f"`{name}" in README, name
    for name, row in FORMATS.items():
        assert any(
            line.startswith(f"| `{name}` | `{row.extensions[0]}`") for line in README.splitlines()
        ), name
