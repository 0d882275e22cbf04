"""From pipeline files to a pipeline."""

import tomllib

import pytest

from meshopt_cli.errors import ConfigError
from meshopt_cli.plans.config import Request, load, plan_for
from meshopt_cli.plans.stages import Repeat
from support.options import every_dimension, every_preset, names, refused, rounds_of
from support.samples import ROOT, SAMPLES

CASES = sorted((ROOT / "tests" / "cases").glob("*.toml"))
EXAMPLES = sorted((SAMPLES / "pipelines").glob("*.toml"))

WHOLE = """
measure = "volume-length"
rounds = 4
gain = 0.25
target-quality = 2.5
time-limit = 30

[[before]]
name = "relax"

[[before]]
name = "smooth"
method = "laplace"

[[pass]]
name = "swap"
pick = "best"

[[pass]]
name = "smooth"
sweeps = 2
worse-than = 2

[[pass]]
name = "smooth"
method = "optimize"
"""


def test_a_whole_file(planned):
    plan = planned(WHOLE)
    assert plan.measure.name == "volume-length"
    assert plan.pipeline.time_limit == 30.0
    assert names(plan.pipeline) == ["relax", "smooth", "swap", "smooth", "smooth"]
    rounds = rounds_of(plan.pipeline)
    assert names(rounds) == ["swap", "smooth", "smooth"]
    stop = rounds.stop
    assert (stop.rounds, stop.gain, stop.target_quality) == (4, 0.25, 2.5)
    _, first, swap, second, third = plan.pipeline.passes()
    assert (first.method, swap.pick, third.method) == ("laplace", "best", "optimize")
    assert (second.method, second.sweeps, second.worse_than) == ("quality", 2, 2.0)
    assert isinstance(second.worse_than, float)


def test_options_win_over_the_file(planned):
    plan = planned(
        WHOLE,
        measure="mean-edge",
        rounds=9,
        target_quality=3.0,
        time_limit=1.0,
        settings=("smooth.sweeps=8", "swap.pick=first"),
    )
    assert plan.measure.name == "mean-edge"
    assert plan.pipeline.time_limit == 1.0
    stop = rounds_of(plan.pipeline).stop
    assert (stop.rounds, stop.gain, stop.target_quality) == (9, 0.25, 3.0)
    for step in plan.pipeline.passes():
        assert getattr(step, "sweeps", 8) == 8
        assert getattr(step, "pick", "first") == "first"


@every_dimension
@every_preset
def test_a_file_may_start_from_a_preset(preset, dimension, pipeline_file):
    path = pipeline_file(f'preset = "{preset}"\nrounds = 2')
    got = plan_for(Request(config=path), dimension).pipeline
    assert got == plan_for(Request(preset=preset, rounds=2), dimension).pipeline


def test_an_empty_file_is_the_default(planned):
    assert planned("# nothing").pipeline == plan_for(Request()).pipeline


def test_passes_before_the_rounds_may_be_all(planned):
    pipeline = planned('[[before]]\nname = "smooth"').pipeline
    assert names(pipeline) == ["smooth"]
    assert not any(isinstance(stage, Repeat) for stage in pipeline.stages)


def test_a_file_and_a_list_say_the_same(planned):
    listed = plan_for(Request(passes=("swap", "smooth"))).pipeline
    written = planned('[[pass]]\nname = "swap"\n[[pass]]\nname = "smooth"').pipeline
    assert list(written.passes()) == list(listed.passes())
    assert rounds_of(written) == rounds_of(listed)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("round = 3", "did you mean 'rounds'"),
        ("target_quality = 2", "did you mean 'target-quality'"),
        ("[passes]", "did you mean 'pass'"),
        ("zzzz = 1", "rounds"),
        ("[smooth]\nsweeps = 3", "smooth"),
    ],
)
def test_an_unknown_key_is_named_with_a_hint(refusal, text, said):
    assert said in refusal(text)


@pytest.mark.parametrize(
    "text",
    [
        "rounds = 2.0",
        'rounds = "2"',
        "rounds = true",
        "gain = true",
        'gain = "small"',
        "target-quality = [2]",
        'time-limit = "1 h"',
        "preset = 3",
        "measure = ['mean-edge']",
        'pass = "smooth"',
        "before = 1",
        "[pass]\nname = 'smooth'",
    ],
)
def test_a_value_of_a_wrong_kind_is_refused(refusal, text):
    key = text.split()[0].strip("[]")
    assert key in refusal(text)


@pytest.mark.parametrize(
    "text",
    [
        "rounds = 0",
        "rounds = -3",
        "gain = -0.1",
        "gain = nan",
        "target-quality = 0.5",
        "target-quality = nan",
        "time-limit = -1",
        "time-limit = nan",
    ],
)
def test_a_value_out_of_range_is_refused(refusal, text):
    assert text.split()[0] in refusal(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('preset = "fats"', "fast"),
        ('measure = "aspect"', "aspect-ratio"),
        ('measure = "edge-ratio"', "edge-ratio"),
        ('[[pass]]\nname = "smoth"', "smooth"),
        ('[[before]]\nname = "smoth"', "smooth"),
        ("[[pass]]\nsweeps = 2", "name"),
        ("[[pass]]\nname = 3", "name"),
        ("pass = [3]", "name"),
        ('pass = ["smooth"]', "name"),
        ('[[pass]]\nname = "smooth"\nsweep = 2', "did you mean 'sweeps'"),
        ('[[pass]]\nname = "smooth"\nsweeps = 0', "smooth.sweeps"),
        ('[[pass]]\nname = "smooth"\nworse-than = 0.5', "smooth.worse-than"),
        ('[[pass]]\nname = "smooth"\nmethod = "no"', "laplace"),
        ('preset = "fast"\n[[pass]]\nname = "smooth"', "preset"),
        ('preset = "fast"\n[[before]]\nname = "smooth"', "preset"),
    ],
)
def test_what_is_wrong_in_a_file_is_said(refusal, text, said):
    assert said in refusal(text)


@pytest.mark.parametrize(
    "text",
    [
        "rounds",
        "round = 3",
        "rounds = true",
        "rounds = 0",
        'preset = "fats"',
        'measure = "aspect"',
        'measure = "edge-ratio"',
        "pass = [3]",
        '[[pass]]\nname = "smoth"',
        '[[pass]]\nname = "smooth"\nsweep = 2',
        '[[before]]\nname = "smooth"\nsweeps = 2.5',
        '[[pass]]\nname = "smooth"\nsweeps = 0',
    ],
)
def test_what_is_wrong_in_a_file_is_said_with_its_name(pipeline_file, text):
    path = pipeline_file(text)
    assert str(path) in refused(config=path)


@pytest.mark.parametrize("text", ["rounds", "rounds = ", "rounds = 1\nrounds = 2", "[[pass]", "\0"])
def test_what_is_no_toml_is_refused(refusal, text):
    assert "TOML" in refusal(text)


def test_what_is_no_text_is_refused(tmp_path):
    path = tmp_path / "binary.toml"
    path.write_bytes(b"rounds = 1 # \xff\xfe")
    with pytest.raises(ConfigError, match=r"binary\.toml"):
        load(path)


@pytest.mark.parametrize("name", ["missing.toml", "", "file/pipeline.toml"])
def test_a_file_that_cannot_be_read_is_refused(tmp_path, name):
    (tmp_path / "file").write_text("no folder")
    path = tmp_path / name
    with pytest.raises(ConfigError) as caught:
        load(path)
    assert str(path) in str(caught.value)


def test_a_setting_for_a_pass_the_file_does_not_have(pipeline_file):
    path = pipeline_file('[[pass]]\nname = "swap"')
    assert "smooth" in refused(config=path, settings=("smooth.sweeps=3",))


def check_loaded(path, dimension):
    """A pipeline file is used as a whole."""
    plan = plan_for(Request(config=path), dimension)
    written = tomllib.loads(path.read_text(encoding="utf-8"))
    listed = [table["name"] for key in ("before", "pass") for table in written.get(key, [])]
    if listed:
        assert names(plan.pipeline) == listed
    else:
        assert plan.pipeline.name == written["preset"]
    return plan


@every_dimension
@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_the_pipelines_of_the_cases_load(path, dimension, pipeline_file):
    text = tomllib.loads(path.read_text(encoding="utf-8"))["pipeline"]
    check_loaded(pipeline_file(text), dimension)


@every_dimension
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_pipelines_of_the_samples_load(path, dimension):
    check_loaded(path, dimension)
