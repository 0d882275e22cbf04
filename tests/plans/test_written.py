"""Pipelines that hold others, their parts, and what is printed of what holds."""

import itertools
import json
import tomllib

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli import formats
from meshopt_cli.cli.entry import status_of
from meshopt_cli.errors import ConfigError, UnsupportedMeshError
from meshopt_cli.passes.check import Check
from meshopt_cli.passes.smooth import Smooth
from meshopt_cli.passes.swap import Swap
from meshopt_cli.plans.angles import ANGLE_Q, WithAngles
from meshopt_cli.plans.build import _MAKERS
from meshopt_cli.plans.config import Request, load, plan_for, settle
from meshopt_cli.plans.items import FORMS
from meshopt_cli.plans.presets import FOLDER, PRESETS
from meshopt_cli.plans.project import found_in
from meshopt_cli.plans.schema import schema
from meshopt_cli.plans.sources import KINDS
from meshopt_cli.plans.stages import Chain, Outcome, Repeat, Sequence, Trial, Unsettled, UpTo
from meshopt_cli.plans.steering import ByMeasure
from meshopt_cli.plans.stop import Stop
from meshopt_cli.plans.writing import text_of
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.work.kinds import CELLS, FACES, SIMPLICES
from meshopt_cli.work.session import Workspace
from support.meshes import hex_grid
from support.options import OPTIONS, every_preset, field_of, names, refused
from support.samples import ROOT, SAMPLES, sample

# Dimensions and kinds of working meshes.
MESHES = [(2, SIMPLICES), (3, SIMPLICES), (2, FACES), (3, CELLS)]
every_mesh = pytest.mark.parametrize(("dimension", "kind"), MESHES)

NESTED = """
rounds = 4
gain = 0.1
pipeline = [
  { run = "first" },
  { repeat = [
    { repeat = [{ pass = "swap" }], until = { rounds = 2 }, guarded = false },
    { pass = "smooth", worse-than = 2 },
  ], until = { gain-factor = 2, settled = 1.5 } },
  { steps = [{ pass = "swap" }, { repeat = [{ pass = "smooth" }] }], max-cells = 10 },
  { angles = [{ pass = "swap" }], lenient = true },
  { unsettled = [{ pass = "smooth", method = "global" }] },
  { try = [{ pass = "swap" }], then = [{ pass = "smooth" }] },
]
[parts]
first = [{ run = "standard/begin" }, { pass = "smooth" }]
"""


def test_forms_hold_what_they_say(planned):
    stages = planned(NESTED).pipeline.stages
    swap, smooth = Sequence((Swap(),)), Sequence((Smooth(),))
    assert [step.name for stage in stages[:3] for step in stage.passes()] == [
        "check", "untangle", "smooth",
    ]  # fmt: skip
    assert stages[3:] == (
        Repeat(
            Chain((
                Repeat(swap, Stop(2, 0.1), guarded=False),
                Sequence((Smooth(worse_than=2.0),)),
            )),
            Stop(4, 0.2, 1.5),
        ),
        UpTo(10, Chain((swap, Repeat(smooth, Stop(4, 0.1))))),
        WithAngles(swap, lenient=True),
        Unsettled(Sequence((Smooth(method="global"),))),
        Trial(swap, smooth),
    )  # fmt: skip


def test_what_rounds_do_not_say_is_that_of_the_pipeline(planned):
    text = "pipeline = [{ repeat = [{ pass = 'swap' }], until = { rounds = 2 } }]\n"
    (rounds,) = planned(text, target_quality=3.0).pipeline.stages
    assert (rounds.stop.rounds, rounds.stop.target_quality) == (2, 3.0)
    (rounds,) = planned(f"gain = 0.3\n{text}", rounds=9).pipeline.stages
    assert (rounds.stop.rounds, rounds.stop.gain) == (2, 0.3)


def test_tables_of_lists_say_the_same_as_lists_in_lines(planned):
    lines = "pipeline = [{ pass = 'swap' }, { repeat = [{ pass = 'smooth', sweeps = 2 }] }]"
    tables = """
[[pipeline]]
pass = "swap"
[[pipeline]]
[[pipeline.repeat]]
pass = "smooth"
sweeps = 2
"""
    assert planned(lines).pipeline == planned(tables).pipeline


STEERED = """
pipeline = [
  { repeat = [{ pass = "smooth" }, { pass = "swap" }], until = { rounds = 4 } },
  { steps = [{ repeat = [{ pass = "smooth", method = "optimize" }] }], measure = "angle-min" },
]
"""


@pytest.fixture
def steered(planned):
    """A working mesh, and the two stages of a pipeline, the second by the least angle."""
    first, second = planned(STEERED).pipeline.stages
    assert isinstance(second, ByMeasure)
    work = Workspace(sample("raw_ball.mesh"), QUALITIES["aspect-ratio"].judge)
    outcome = Outcome(work)
    first.run(outcome)
    return outcome, second


def test_another_measure_steers_what_it_is_for(steered):
    """The worst cell gets better by that, as it does not by the measure of the run."""
    outcome, stage = steered
    judge, bounds = outcome.work.mesh.judge, outcome.work.bounds
    before, by_angle = outcome.work.copy(), QUALITIES["angle-min"].judge
    before.judge_by(by_angle)
    stage.run(outcome)
    assert outcome.work.mesh.judge == judge
    assert outcome.work.bounds == bounds
    after = outcome.work.copy()
    after.judge_by(by_angle)
    assert after.standing().is_better_than(before.standing())
    Check().run(outcome.work)


def test_a_measure_that_is_not_for_such_cells_is_refused(tmp_path, pipeline_file, capsys):
    path = pipeline_file("pipeline = [{ steps = [{ pass = 'smooth' }], measure = 'angle-min' }]")
    mesh = tmp_path / "in.vtk"
    formats.write(mesh, hex_grid(2), formats.FORMATS["vtk"].default)
    arguments = ["optimize", str(mesh), str(tmp_path / "out.vtk"), "--config", str(path)]
    assert status_of(arguments) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "measure angle-min cannot steer hexahedra" in err


def test_every_form_is_made():
    assert set(FORMS) == set(_MAKERS)


def test_the_presets_are_the_files_there_are():
    assert {path.stem for path in FOLDER.glob("*")} == set(PRESETS)


def test_tetrahedra_are_mended_until_their_angles_are_good():
    for step in plan_for(Request(preset="best"), 3).pipeline.passes():
        assert step.name != "mend" or step.worse_than == ANGLE_Q


@every_preset
def test_no_part_of_a_preset_is_left_over(preset):
    """Each is run by some pipeline."""
    run = {
        name.rpartition("/")[2]
        for path in FOLDER.glob("*.toml")
        for name in _runs(tomllib.loads(path.read_text()))
    }
    assert set(PRESETS[preset].table.get("parts", {})) <= run


def _runs(value):
    if isinstance(value, dict):
        for key, one in value.items():
            if key == "run":
                yield one
            yield from _runs(one)
    elif isinstance(value, list):
        for one in value:
            yield from _runs(one)


REQUESTS = [
    *({"preset": name} for name in PRESETS),
    {"preset": "best", "rounds": 5, "target_quality": 1.7, "time_limit": 3.0},
    {"preset": "fast", "settings": ("smooth.sweeps=5", "smooth.method=laplace")},
    {"passes": ("swap", "smooth"), "measure": "mean-edge", "allow": ("M202",)},
    {"passes": ("repair", "smooth")},
    {"time_limit": float("inf")},
]


@every_mesh
@pytest.mark.parametrize("request_", REQUESTS, ids=str)
def test_what_is_printed_says_the_same_again(request_, dimension, kind, pipeline_file):
    request = Request(**request_)
    path = pipeline_file(text_of(settle(request)))
    again = Request(config=path)
    if request.preset == "adapt" and kind != SIMPLICES:
        for one in (request, again):
            with pytest.raises(UnsupportedMeshError, match="tetrahedra alone"):
                plan_for(one, dimension, kind)
        return
    plan, other = plan_for(request, dimension, kind), plan_for(again, dimension, kind)
    assert plan.pipeline.stages == other.pipeline.stages
    assert plan.pipeline.repairs == other.pipeline.repairs
    assert plan.pipeline.time_limit == other.pipeline.time_limit
    assert (plan.measure, plan.all_measures, plan.allow) == (
        other.measure, other.all_measures, other.allow,
    )  # fmt: skip
    for line in path.read_text().splitlines():
        if line.endswith(f"= {request.rounds}"):
            assert "--rounds" in line


def items():
    """Items of pipelines, at random."""
    steps = st.sampled_from(OPTIONS).map(
        lambda row: {"pass": row[0].name, row[1]: field_of(*row).default}
    )
    until = st.fixed_dictionaries(
        {}, optional={"rounds": st.integers(1, 9), "gain": st.floats(0, 1)}
    )

    def holding(inner):
        some = st.lists(inner, max_size=3)
        return st.one_of(
            st.fixed_dictionaries(
                {"repeat": some}, optional={"until": until, "guarded": st.booleans()}
            ),
            st.fixed_dictionaries({"steps": some}, optional={"max-cells": st.integers(0, 99)}),
            st.fixed_dictionaries({"try": some}, optional={"then": some}),
            st.fixed_dictionaries({"angles": some}, optional={"lenient": st.booleans()}),
        )

    return st.recursive(steps, holding, max_leaves=8)


@given(rows=st.lists(items(), max_size=4), rounds=st.integers(1, 9))
def test_any_pipeline_is_printed_as_it_is(rows, rounds, tmp_path_factory):
    from meshopt_cli.plans.sources import settled, taken

    holds = settled(taken({"pipeline": rows, "rounds": rounds}, lambda name: {}), "here")
    path = tmp_path_factory.mktemp("printed") / "pipeline.toml"
    path.write_text(text_of(holds), encoding="utf-8")
    assert load(path).values == holds.values
    jsonschema.validate(tomllib.loads(path.read_text(encoding="utf-8")), schema())


# What is wrong, where, and what is said of it.
WRONG = [
    ("rounds = 3\ngian = 1", 2, "did you mean 'gain'"),
    ("\n\nrounds = 0", 3, "rounds"),
    ("measure = 'aspect'", 1, "aspect-ratio"),
    ("gain = 0.1\npreset = 'bets'", 2, "best"),
    ("[[pass]]\nname = 'swap'\n\n[[pass]]\nname = 'smooth'\nsweep = 2", 6, "sweeps"),
    ("pipeline = [\n  { pass = 'swap' },\n  { pass = 'smoth' },\n]", 3, "smooth"),
    ("pipeline = [\n  { repeat = [\n    { pass = 'swap', pik = 'best' },\n  ] },\n]", 3, "pick"),
    ("pipeline = [\n  { repeat = [],\n until = { round = 2 } },\n]", None, ""),
    ("pipeline = [\n  { repeat = [], until = { round = 2 } },\n]", 2, "did you mean 'rounds'"),
    ("pipeline = [\n  { repeat = [], until = { rounds = 0 } },\n]", 2, "rounds"),
    ("[[pipeline]]\npass = 'swap'\n[[pipeline]]\nrepeet = []", 4, "did you mean 'repeat'"),
    ("[[pipeline]]\npass = 'swap'\nrepeat = []", 3, "no option 'repeat'"),
    ("[[pipeline]]\nsteps = []\nrepeat = []", 3, "exclude each other"),
    ("[[pipeline]]\nguarded = true", 1, "one of the keys"),
    ("pipeline = [\n3]", 2, "a table"),
    ("pipeline = 3", 1, "pipeline"),
    ("[plane]\nrounds = 3", 1, "pipeline"),
    ("[plane]\nround = 3", 2, "rounds"),
    ("[space]\npipeline = []\nrounds = 1.5", 3, "rounds"),
    ("[plain]\nrounds = 3", 1, "did you mean 'plane'"),
    ("pipeline = [{ run = 'a' }]", 1, "no [parts]"),
    ("pipeline = [{ run = 'begin' }]\n[parts]\nbegine = []", 1, "did you mean 'begine'"),
    ("pipeline = [{ run = 'standard/begn' }]", 1, "did you mean 'begin'"),
    ("pipeline = [{ run = 'standart/begin' }]", 1, "did you mean 'standard'"),
    ("pipeline = [{ run = 'a', sweeps = 2 }]\n[parts]\na = []", 1, "sweeps"),
    ("pipeline = []\n[parts]\na = [{ run = 'b' }]\nb = [{ run = 'a' }]", 4, "runs itself"),
    ("pipeline = []\n[parts]\na = [\n{ pass = 'swap', sweeps = 1 }]", 4, "sweeps"),
    ("pipeline = []\n[parts]\n'a/b' = []", 3, "/"),
    ("rounds = 1\npipeline = []\n[[pass]]\nname = 'swap'", 2, "exclude"),
    ("preset = 'fast'\n[plane]\npipeline = []", 2, "exclude"),
    ("all-measures = 1", 1, "all-measures"),
    ("pipeline = [\n{ steps = [], measure = 'angle-mn' }]", 2, "did you mean 'angle-min'"),
    ("pipeline = [\n{ steps = [], measure = 'edge-ratio' }]", 2, "measure"),
    ("pipeline = [{ pass = 'fit', longest = 0.5 }]", 1, "fit.longest"),
    ('text = """\n# [a]\n"""\n', 1, "unknown key 'text'"),
    ('measure = \"\"\"\naspect-ratio\"\"\"\nrounds = 0', 3, "rounds"),
    ("summary = '''\n[x]\n'''\n\"rounds\" = 0", 4, "rounds"),
    ("plane.pipeline = []\nplane.rounds = 0", 2, "rounds"),
    ("check = 1", 1, "check"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "line", "said"), WRONG)
def test_what_is_wrong_is_told_with_its_line(pipeline_file, text, line, said):
    path = pipeline_file(text)
    message = refused(config=path)
    assert said in message
    assert message.startswith(f"{path}:{line}: " if line else f"{path}:")


def test_parts_that_double_each_other_are_not_too_many(pipeline_file):
    doubled = "".join(
        f"a{i} = [{{ run = 'a{i + 1}' }}, {{ run = 'a{i + 1}' }}]\n" for i in range(60)
    )
    path = pipeline_file(f"pipeline = [{{ run = 'a0' }}]\n[parts]\n{doubled}a60 = []\n")
    assert "items at most" in refused(config=path)


def test_a_pipeline_for_other_meshes_is_refused(planned, pipeline_file):
    path = pipeline_file("[plane]\npipeline = [{ pass = 'smooth' }]")
    assert names(plan_for(Request(config=path)).pipeline) == ["smooth"]
    with pytest.raises(UnsupportedMeshError, match=r"triangles alone.*space"):
        plan_for(Request(config=path), 3)


def test_a_setting_may_be_for_some_meshes_only():
    request = Request(preset="fast", settings=("odt.sweeps=3",))
    assert "odt" in names(plan_for(request).pipeline) or plan_for(request, 2)
    with pytest.raises(ConfigError, match="no pass odt"):
        plan_for(request, 3)


# The files of a project ---------------------------------------------------------------------------


def test_the_later_wins(tmp_path, pipeline_file):
    """Files of the project, then --config, then options."""
    (tmp_path / "meshopt.toml").write_text(
        "rounds = 2\ngain = 0.2\ntime-limit = 2\npreset = 'best'"
    )
    (tmp_path / "pyproject.toml").write_text("[tool.meshopt]\ngain = 0.3\n[tool.other]\nx = 1")
    below = tmp_path / "a" / "b"
    below.mkdir(parents=True)
    project = found_in(below)
    assert project == found_in(tmp_path)
    config = pipeline_file("time-limit = 4\n[[pass]]\nname = 'swap'\n")
    holds = settle(Request(project=project, config=config, rounds=7))
    assert {key: holds.values[key] for key in ("rounds", "gain", "time-limit")} == {
        "rounds": 7, "gain": 0.3, "time-limit": 4.0,
    }  # fmt: skip
    assert holds.origins["rounds"] == "--rounds"
    assert holds.origins["gain"].endswith("pyproject.toml")
    assert holds.origins["time-limit"] == str(config)
    assert names(plan_for(Request(project=project, config=config), 3).pipeline) == ["swap"]
    chosen = plan_for(Request(project=project, preset="fast"), 3).pipeline
    assert chosen.name == "fast"
    assert chosen.time_limit == 2.0
    text = text_of(holds)
    assert "rounds = 7  # --rounds" in text
    assert "pyproject.toml" in text


def test_a_table_for_a_kind_gives_way_to_what_comes_after_it(pipeline_file):
    path = pipeline_file("rounds = 2\n[plane]\nrounds = 5\npipeline = [{ repeat = [] }]")
    assert plan_for(Request(config=path), 2).pipeline.stages[0].stop.rounds == 5
    assert plan_for(Request(config=path, rounds=3), 2).pipeline.stages[0].stop.rounds == 3


@pytest.mark.parametrize(
    "text", ["[tool.other]\nx = 1", "[tool.meshopt.check]\nlimit = 3", "what = is [ this? "]
)
def test_files_for_other_things_are_passed_by(tmp_path, text):
    (tmp_path / "meshopt.toml").write_text("rounds = 2")
    below = tmp_path / "below"
    below.mkdir()
    (below / "pyproject.toml").write_text(text)
    assert found_in(below).values == {"rounds": 2}


def test_what_is_wrong_in_a_project_is_told_with_its_line(tmp_path):
    (tmp_path / "pyproject.toml").write_text("[project]\nname = 'x'\n\n[tool.meshopt]\nround = 3\n")
    with pytest.raises(ConfigError, match=r"pyproject\.toml:5: unknown key 'round'.*rounds"):
        found_in(tmp_path)
    (tmp_path / "pyproject.toml").write_text("[tool]\nmeshopt = 3\n")
    with pytest.raises(ConfigError, match=r"pyproject\.toml:2: .*table"):
        found_in(tmp_path)


def test_the_command_line_takes_the_file_of_the_project(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    mesh = str(SAMPLES / "grid.vtk")

    def run(*options):
        capsys.readouterr()
        status = status_of(["optimize", *options])
        return status, capsys.readouterr()

    def passes(*options):
        status, (out, _) = run(mesh, "out.vtk", "--json", *options)
        assert status == 0
        return {one["name"] for one in json.loads(out)["passes"]}

    path = tmp_path / "meshopt.toml"
    path.write_text("[check]\nmin-angle = 3\n")
    usual = passes()
    path.write_text("[check]\nmin-angle = 3\n[[pass]]\nname = 'swap'\n")
    assert passes() == {"swap"}
    assert passes("--no-config") == passes("--preset", "standard") == usual
    status, (out, _) = run("--show-config")
    assert status == 0
    assert f"# {path}" in out
    path.write_text("round = 3")
    status, (out, err) = run(mesh, "out.vtk")
    assert (status, out) == (2, "")
    assert f"{path}:1: unknown key 'round': did you mean 'rounds'?" in err
    assert run()[0] == run("--no-config")[0] == 2


@pytest.mark.parametrize("preset", ["fast", "standard"])
@pytest.mark.parametrize("name", ["grid.vtk", "raw_ball.mesh"])
def test_what_is_printed_makes_the_same_mesh(preset, name, tmp_path, capsys):
    options = ["--preset", preset, "--rounds", "2", "--set", "smooth.worse-than=1.3", "--no-config"]
    assert status_of(["optimize", *options, "--show-config"]) == 0
    (tmp_path / "saved.toml").write_text(capsys.readouterr().out)
    outputs = []
    for k, how in enumerate((options, ["--config", str(tmp_path / "saved.toml")])):
        output = tmp_path / f"{k}_{name}"
        assert status_of(["optimize", "-q", str(SAMPLES / name), str(output), *how]) == 0
        outputs.append(output.read_bytes())
    assert outputs[0] == outputs[1] != (SAMPLES / name).read_bytes()


# The schema ---------------------------------------------------------------------------------------


def test_the_schema_takes_all_presets_and_samples():
    jsonschema.Draft202012Validator.check_schema(schema())
    paths = [*FOLDER.glob("*.toml"), *(SAMPLES / "pipelines").glob("*.toml")]
    assert len(paths) > len(PRESETS)
    for path in paths:
        jsonschema.validate(tomllib.loads(path.read_text(encoding="utf-8")), schema())
    for path in (ROOT / "tests" / "cases").glob("*.toml"):
        case = tomllib.loads(path.read_text(encoding="utf-8"))
        jsonschema.validate(tomllib.loads(case["pipeline"]), schema())
    jsonschema.validate(tomllib.loads(NESTED), schema())


OF_TABLES = (
    "runs itself",
    "no [parts]",
    "begine",
    "begin'",
    "standard'",
    "/",
    "exclude",
    "fit.longest",
)


@pytest.mark.parametrize(
    "text", [text for text, _, said in WRONG if said and not any(one in said for one in OF_TABLES)]
)  # fmt: skip
def test_the_schema_refuses_what_is_refused(text):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(tomllib.loads(text), schema())


def test_the_command_prints_the_schema(capsys):
    assert status_of(["schema"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads(json.dumps(schema()))
    said = {
        d["properties"]["pass"]["const"]
        for d in printed["$defs"].values()
        if "pass" in d.get("properties", {})
    }
    assert said == {kind.name for kind, _ in OPTIONS} | {"check"}


def test_kinds_are_those_of_working_meshes():
    assert set(KINDS) == {"plane", "space", FACES, CELLS}
    assert len(list(itertools.chain(*MESHES))) == 2 * len(KINDS)
