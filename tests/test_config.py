"""From options and pipeline files to a pipeline."""

import itertools
import math
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshopt_cli.errors import ConfigError
from meshopt_cli.passes import PASSES
from meshopt_cli.plans.config import Request, load, plan_for
from meshopt_cli.plans.pipeline import Repeat
from meshopt_cli.plans.presets import DEFAULT_PRESET, PRESETS
from meshopt_cli.quality.summary import DEFAULT_MEASURE, MEASURES

CASES = sorted((Path(__file__).parent / "cases").glob("*.toml"))
EXAMPLES = sorted((Path(__file__).parent.parent / "samples").rglob("*.toml"))
DIMENSIONS = (2, 3)

every_preset = pytest.mark.parametrize("preset", PRESETS)
every_dimension = pytest.mark.parametrize("dimension", DIMENSIONS)

OPTIONS = [(p, f.name.replace("_", "-")) for p in PASSES.values() for f in fields(p)]


def over_options(options):
    ids = [f"{kind.name}.{name}" for kind, name in options]
    return pytest.mark.parametrize(("kind", "option"), options, ids=ids)


every_option = over_options(OPTIONS)


@pytest.fixture
def pipeline_file(tmp_path):
    """Write a pipeline file."""

    def write(text):
        path = tmp_path / "pipeline.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def planned(pipeline_file):
    """The pipeline of a file, and of options beside it."""

    def plan(text, **options):
        return plan_for(Request(config=pipeline_file(text), **options))

    return plan


@pytest.fixture
def refusal(pipeline_file):
    """What is said about a pipeline file: one line."""
    return lambda text, **options: refused(config=pipeline_file(text), **options)


def refused(**options):
    """What is said about options: one line."""
    with pytest.raises(ConfigError) as caught:
        plan_for(Request(**options))
    assert "\n" not in str(caught.value)
    return str(caught.value)


def names(pipeline):
    return [step.name for step in pipeline.passes()]


def rounds_of(pipeline):
    """The part that runs in rounds; there must be one."""
    (found,) = [stage for stage in pipeline.stages if isinstance(stage, Repeat)]
    return found


def field_of(kind, option):
    return next(f for f in fields(kind) if f.name == option.replace("-", "_"))


def another(kind, option):
    """A value of the option that is allowed and not the default."""
    f = field_of(kind, option)
    if f.metadata["choices"]:
        return next(c for c in f.metadata["choices"] if c != f.default)
    if f.metadata["most"] is None:
        return f.default + 1
    return type(f.default)((f.default + f.metadata["most"]) / 2)


# Presets and lists of passes --------------------------------------------------------------


@every_dimension
@every_preset
def test_presets_begin_and_end_with_a_check(preset, dimension):
    steps = names(plan_for(Request(preset=preset), dimension).pipeline)
    assert steps[0] == steps[-1] == "check"
    assert set(steps) > {"check", "smooth"}


@every_dimension
def test_nothing_said_means_the_default_preset(dimension):
    plan = plan_for(Request(), dimension)
    assert plan.pipeline == plan_for(Request(preset=DEFAULT_PRESET), dimension).pipeline
    assert plan.measure is MEASURES[DEFAULT_MEASURE]
    assert plan.pipeline.time_limit == math.inf


@every_preset
def test_a_pipeline_is_made_anew_each_time(preset):
    changed = plan_for(Request(preset=preset, settings=("smooth.sweeps=77",))).pipeline
    fresh = plan_for(Request(preset=preset)).pipeline
    assert all(step.sweeps == 77 for step in changed.passes() if step.name == "smooth")
    assert all(step.sweeps != 77 for step in fresh.passes() if step.name == "smooth")


@settings(deadline=None)
@given(st.lists(st.sampled_from(list(PASSES)), min_size=1, max_size=6))
def test_passes_run_in_the_order_given(wanted):
    pipeline = plan_for(Request(passes=tuple(wanted))).pipeline
    assert names(pipeline) == wanted
    assert names(rounds_of(pipeline)) == wanted
    assert len({id(step) for step in pipeline.passes()}) == len(wanted)


def test_an_empty_list_of_passes_is_refused():
    assert "passes" in refused(passes=())


def test_an_unknown_name_lists_those_that_are_known():
    for message, known in (
        (refused(preset="fats"), PRESETS),
        (refused(passes=("smooth", "swapp")), PASSES),
        (refused(measure="aspect"), MEASURES),
    ):
        assert all(name in message for name in known)


@pytest.mark.parametrize("pair", list(itertools.combinations(("preset", "passes", "config"), 2)))
def test_a_pipeline_comes_from_one_place(pair, tmp_path):
    values = {"preset": "fast", "passes": ("swap",), "config": tmp_path / "any.toml"}
    message = refused(**{name: values[name] for name in pair})
    assert all(f"--{name}" in message for name in pair)


@pytest.mark.parametrize("name", MEASURES)
def test_only_a_measure_that_drives_can_steer(name):
    if MEASURES[name].drives:
        assert plan_for(Request(measure=name)).measure is MEASURES[name]
    else:
        assert name in refused(measure=name)


def test_stop_criteria_reach_the_rounds():
    plan = plan_for(Request(rounds=7, target_quality=2.5, time_limit=9.0))
    stops = [s.stop for s in plan.pipeline.stages if isinstance(s, Repeat)]
    assert any(stop.rounds == 7 and stop.target_quality == 2.5 for stop in stops)
    assert plan.pipeline.time_limit == 9.0


# --set ------------------------------------------------------------------------------------------


# Some have no other value than their default.
every_choice = over_options(
    [row for row in OPTIONS if len(field_of(*row).metadata["choices"]) != 1]
)


@every_choice
def test_every_option_can_be_set(kind, option):
    value = another(kind, option)
    assert value != field_of(kind, option).default
    setting = f"{kind.name}.{option}={value}"
    plan = plan_for(Request(passes=(kind.name, "check", kind.name), settings=(setting,)))
    for step in plan.pipeline.passes():
        if step.name == kind.name:
            got = getattr(step, option.replace("-", "_"))
            assert got == value
            assert type(got) is type(field_of(kind, option).default)


@every_choice
def test_every_option_can_be_in_a_file(kind, option, planned):
    value = another(kind, option)
    shown = f'"{value}"' if isinstance(value, str) else value
    for key in {option, option.replace("-", "_")}:
        (step,) = planned(f'[[pass]]\nname = "{kind.name}"\n{key} = {shown}').pipeline.passes()
        assert getattr(step, option.replace("-", "_")) == value


@every_option
@pytest.mark.parametrize("value", ["", "much", "nan", "1e3x", "-1"])
def test_no_option_takes_nonsense(kind, option, value):
    message = refused(passes=(kind.name,), settings=(f"{kind.name}.{option}={value}",))
    assert f"{kind.name}.{option}" in message


@every_option
def test_no_option_takes_a_value_of_another_kind_from_a_file(kind, option, refusal):
    default = field_of(kind, option).default
    wrong = {
        str: ["1", "1.5", "true"],
        int: ["1.5", "2.0", "true", '"2"', "[2]"],
        float: ["true", '"2"', '"2.5"', "[2.5]", "1979-05-27"],
    }[type(default)]
    for value in wrong:
        message = refusal(f'[[pass]]\nname = "{kind.name}"\n{option} = {value}')
        assert f"{kind.name}.{option}" in message


def test_several_settings_add_up_and_the_last_one_wins():
    several = ("smooth.below=2", "smooth.sweeps=5", "swap.pick=best", "smooth.below=3")
    smooth, swap = plan_for(Request(passes=("smooth", "swap"), settings=several)).pipeline.passes()
    assert (smooth.below, smooth.sweeps, swap.pick) == (3.0, 5, "best")


def test_blanks_around_a_setting_do_no_harm():
    plan = plan_for(Request(passes=("smooth",), settings=(" smooth.sweeps = 5 ",)))
    assert next(plan.pipeline.passes()).sweeps == 5


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("smooth", "PASS.OPTION=VALUE"),
        ("smooth.sweeps", "PASS.OPTION=VALUE"),
        ("sweeps=3", "PASS.OPTION=VALUE"),
        ("=", "PASS.OPTION=VALUE"),
        ("smoth.sweeps=3", "smooth"),
        ("smooth.sweep=3", "did you mean 'sweeps'"),
        ("smooth.zzzz=3", "sweeps"),
        ("smooth.name=swap", "name"),
        ("smooth.sweeps=3.5", "smooth.sweeps"),
        ("smooth.sweeps=0", "smooth.sweeps"),
        ("smooth.relaxation=1.5", "smooth.relaxation"),
        ("smooth.method=Laplace", "laplace"),
        ("collapse.below=2", "collapse"),
    ],
)
def test_a_wrong_setting_is_refused(setting, said):
    assert said in refused(passes=("smooth", "swap"), settings=(setting,))


# Pipeline files ---------------------------------------------------------------------------


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
below = 2

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
    assert (second.method, second.sweeps, second.below) == ("quality", 2, 2.0)
    assert isinstance(second.below, float)


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
        ('[[pass]]\nname = "smooth"\nbelow = 0.5', "smooth.below"),
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


# Pipelines of the cases and the samples ---------------------------------------------------


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
