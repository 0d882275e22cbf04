"""The tables of forms: each row is reached by its name and by its suffixes, wherever they count."""

import json
import shlex
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import click
import pytest

from meshopt_cli.boundary.policy import POLICIES, TOLERANCE
from meshopt_cli.cli.main import main
from meshopt_cli.errors import ConfigError
from meshopt_cli.jobs.optimize_file import FileTask, optimize_file
from meshopt_cli.jobs.optimize_mesh import Task
from meshopt_cli.jobs.report import Wanted, report_on
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.quality.measures import OF_SIMPLICES
from meshopt_cli.reports.outputs import CHECK_OUTPUTS, NORMAL, OUTPUTS, SUFFIXES, output_of
from meshopt_cli.reports.verdict import Verdict
from support.broken import BROKEN
from support.files import write
from support.meshes import in_space, tri_grid
from support.options import PLAIN
from support.samples import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
every_output = pytest.mark.parametrize("row", OUTPUTS.values(), ids=list(OUTPUTS))
every_check_output = pytest.mark.parametrize("row", CHECK_OUTPUTS.values(), ids=list(CHECK_OUTPUTS))


@pytest.fixture(autouse=True)
def _nothing_configured(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def bad(tmp_path):
    return write(tmp_path / "bad.vtu", BROKEN["hanging node"][0])


def of(path, row, *words):
    """The text of a report on a file, straight from the row, made by some words."""
    one = report_on(path, Wanted(all_measures=row.all_measures, with_pictures=row.pictures))
    return row.text([replace(one, command=shlex.join(map(str, ("meshopt", "report", *words))))])


# Reports -------------------------------------------------------------------------------------


def test_every_form_has_a_suffix_of_its_own():
    assert all(row.suffixes for row in OUTPUTS.values())
    assert len(SUFFIXES) == sum(len(row.suffixes) for row in OUTPUTS.values())
    for suffix, row in SUFFIXES.items():
        assert output_of(Path(f"a.b{suffix.upper()}")) is row


@pytest.mark.parametrize("name", ["report", "report.doc", ".json", "json"])
def test_a_name_without_a_suffix_of_these_says_which_there_are(name):
    with pytest.raises(ConfigError) as caught:
        output_of(Path(name))
    assert all(word in str(caught.value) for word in (name, *SUFFIXES))


@every_output
def test_report_in_every_form(meshopt, tets, tmp_path, row):
    words = tets, "--format", row.name
    expected = of(tets, row, *words)
    assert expected.endswith("\n")
    assert meshopt("report", *words) == (0, expected, "")
    for suffix in row.suffixes:
        path = tmp_path / f"quality{suffix}"
        words = tets, "-o", path
        assert meshopt("report", *words) == (0, "", "")
        assert path.read_text(encoding="utf-8") == of(tets, row, *words)


@pytest.mark.parametrize(
    ("row", "suffix"),
    [(row, s) for row, of in pairwise([*OUTPUTS.values(), OUTPUTS["table"]]) for s in of.suffixes],
)
def test_a_form_that_is_named_wins_over_the_suffix(meshopt, tets, tmp_path, row, suffix):
    path = tmp_path / f"quality{suffix}"
    words = tets, "-o", path, "--format", row.name
    assert meshopt("report", *words)[0] == 0
    assert path.read_text(encoding="utf-8") == of(tets, row, *words)


def test_a_report_file_that_says_no_form_is_refused_before_a_mesh_is_read(meshopt, tmp_path):
    path = tmp_path / "quality.doc"
    status, out, err = meshopt("report", tmp_path / "missing.vtk", "-o", path)
    assert (status, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert all(suffix in err for suffix in SUFFIXES)
    assert not path.exists()


def test_any_name_will_do_where_the_form_is_named(meshopt, tets, tmp_path):
    path = tmp_path / "quality.doc"
    assert meshopt("report", tets, "-o", path, "--format", "csv")[0] == 0
    assert path.read_text(encoding="utf-8") == of(tets, OUTPUTS["csv"])


def test_optimize_writes_every_form(meshopt, tets, tmp_path):
    paths = [tmp_path / f"run{suffix}" for suffix in SUFFIXES]
    asked = [word for path in paths for word in ("--report", path)]
    status, out, _ = meshopt("optimize", tets, tmp_path / "out.vtk", "--preset", "fast", *asked)
    assert status == 0
    assert out.startswith("tets.vtk: ")
    for path in paths:
        text = path.read_text(encoding="utf-8")
        # The first line is that of a report on the mesh alone, and more follows.
        alone = of(tets, output_of(path))
        assert text.splitlines()[0] == alone.splitlines()[0]
        assert text.endswith("\n")
        assert len(text) > len(alone)


def test_a_form_that_tells_all_measures_is_given_them(meshopt, tets, tmp_path):
    path = tmp_path / "run.json"
    meshopt("optimize", tets, tmp_path / "out.vtk", "--preset", "fast", "--report", path)
    value = json.loads(path.read_text())
    for state in ("before", "after"):
        assert set(value[state]["measures"]) == set(OF_SIMPLICES)
        assert value[state]["angles_forced"] is not None


def test_the_readme_names_every_form():
    for suffix in SUFFIXES:
        assert f"`{suffix}`" in README
    for command, rows in (("report", OUTPUTS), ("check", CHECK_OUTPUTS)):
        section = README.split("### Options of report" if command == "report" else "### Check")[1]
        (line,) = [x for x in section.split("\n### ")[0].splitlines() if "`--format NAME`" in x]
        assert all(f"`{name}`" in line for name in rows)


def test_the_options_offer_the_rows_of_the_tables():
    for command, rows in (("report", OUTPUTS), ("check", CHECK_OUTPUTS)):
        parameters = main.get_command(click.Context(main), command).params
        (option,) = [p for p in parameters if p.name == "form"]
        assert option.make_metavar(click.Context(main)).strip("[]").split("|") == list(rows)
    parameters = main.get_command(click.Context(main), "optimize").params
    (option,) = [p for p in parameters if p.name == "boundary"]
    assert list(option.type.choices) == list(POLICIES)
    (option,) = [p for p in parameters if p.name == "slide_tolerance"]
    assert option.default == TOLERANCE


# What check finds ----------------------------------------------------------------------------


@every_check_output
def test_check_in_every_form(meshopt, tets, bad, tmp_path, row):
    missing = tmp_path / "missing.vtu"
    status, out, err = meshopt("check", tets, bad, missing, "--format", row.name)
    assert status == 3
    assert str(missing) in err
    assert "M205" in out
    assert str(bad.name) in out
    assert out.endswith("\n")


@every_check_output
def test_statistics_go_with_the_forms_that_have_some(meshopt, bad, row):
    status, out, err = meshopt("check", bad, "--format", row.name, "--statistics")
    assert status == (1 if row.has_statistics else 2)
    assert ("M205" in out) == row.has_statistics
    assert (row.name in err) != row.has_statistics


def test_text_comes_as_files_are_checked():
    """What is known of the first file is said before the second one is looked at."""
    asked = []

    def verdicts():
        for name in ("a.vtk", "b.vtk"):
            asked.append(name)
            yield Verdict(name, 0, counts={}, severities={})

    parts = CHECK_OUTPUTS["text"].parts(verdicts(), NORMAL)
    assert next(parts) == "a.vtk: valid\n"
    assert asked == ["a.vtk"]
    assert "".join(parts) == "b.vtk: valid\n2 files: 2 valid\n"


# What a preset wants told --------------------------------------------------------------------


@pytest.mark.parametrize("preset", PLAIN)
def test_a_preset_is_measured_alike_wherever_it_is_named(tets, tmp_path, preset):
    path = tmp_path / "pipeline.toml"
    path.write_text(f'preset = "{preset}"\nrounds = 1\n')
    named, filed = Request(preset=preset, rounds=1), Request(config=path)
    assert plan_for(named).all_measures == plan_for(filed).all_measures
    told = []
    for request in (named, filed):
        report = optimize_file(FileTask(tets, tmp_path / "out.vtk", Task(request))).report
        told.append((report.before, report.after))
        wanted = set(OF_SIMPLICES) if PRESETS[preset].all_measures else set()
        assert set(report.after.worst_by_measure) == wanted
        assert (report.after.forced is not None) == PRESETS[preset].all_measures
    assert told[0] == told[1]


def test_best_is_for_more_than_one_measure(meshopt, tets, tmp_path):
    assert [p.name for p in PRESETS.values() if p.all_measures] == ["best"]
    path = tmp_path / "pipeline.toml"
    path.write_text('preset = "best"\n')
    out = meshopt("optimize", tets, tmp_path / "out.vtk", "--config", path)[1]
    assert "the boundary forces" in out


def test_passes_of_ones_own_are_told_by_their_measure(tmp_path):
    for request in (Request(passes=("smooth",)), Request(preset="standard")):
        assert not plan_for(request).all_measures


def test_triangles_have_their_report_too(meshopt, tmp_path):
    path = write(tmp_path / "flat.vtu", in_space(tri_grid(3)))
    for row in OUTPUTS.values():
        words = path, "--format", row.name
        assert meshopt("report", *words) == (0, of(path, row, *words), "")
