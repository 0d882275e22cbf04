"""From options to a pipeline."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.passes import PASSES
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.plans.presets import DEFAULT_PRESET, PRESETS
from meshopt_cli.plans.stages import Repeat
from meshopt_cli.quality.measures import DEFAULT_MEASURE, QUALITIES
from support.options import (
    OPTIONS,
    another,
    every_dimension,
    every_option,
    every_preset,
    field_of,
    names,
    over_options,
    refused,
    rounds_of,
)


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
    assert plan.measure is QUALITIES[DEFAULT_MEASURE]
    assert plan.pipeline.time_limit == math.inf


@every_preset
def test_a_pipeline_is_made_anew_each_time(preset):
    changed = plan_for(Request(preset=preset, settings=("smooth.sweeps=77",))).pipeline
    fresh = plan_for(Request(preset=preset)).pipeline
    assert all(step.sweeps == 77 for step in changed.passes() if step.name == "smooth")
    assert all(step.sweeps != 77 for step in fresh.passes() if step.name == "smooth")


@given(st.lists(st.sampled_from(list(PASSES)), min_size=1, max_size=6))
def test_passes_run_in_the_order_given(wanted):
    """But for repair, which mends the mesh of the file: that is once, and first."""
    pipeline = plan_for(Request(passes=tuple(wanted))).pipeline
    rounds = [name for name in wanted if name != "repair"]
    assert names(rounds_of(pipeline)) == rounds
    assert names(pipeline) == ["repair"] * wanted.count("repair") + rounds


def test_an_empty_list_of_passes_is_refused():
    assert "passes" in refused(passes=())


def test_an_unknown_name_says_which_may_be_meant():
    """One that is near, or all that are known."""
    for wrong, meant in (
        ({"preset": "fats"}, ["fast"]),
        ({"preset": "xyz"}, PRESETS),
        ({"passes": ("smooth", "swapp")}, ["swap"]),
        ({"passes": ("???",)}, PASSES),
        ({"measure": "aspect-ration"}, ["aspect-ratio"]),
        ({"measure": "?"}, QUALITIES),
    ):
        message = refused(**wrong)
        assert all(name in message for name in meant)
        assert len(meant) > 1 or "did you mean" in message


@pytest.mark.parametrize("pair", list(itertools.combinations(("preset", "passes", "config"), 2)))
def test_a_pipeline_comes_from_one_place(pair, tmp_path):
    values = {"preset": "fast", "passes": ("swap",), "config": tmp_path / "any.toml"}
    message = refused(**{name: values[name] for name in pair})
    assert all(f"--{name}" in message for name in pair)


@pytest.mark.parametrize("name", QUALITIES)
def test_only_a_measure_that_drives_can_steer(name):
    if QUALITIES[name].drives:
        assert plan_for(Request(measure=name)).measure is QUALITIES[name]
    else:
        assert name in refused(measure=name)


def stops_of(stage):
    """The criteria of all rounds in a stage."""
    if isinstance(stage, Repeat):
        yield stage.stop
    inner = getattr(stage, "stages", None) or [s for s in [getattr(stage, "body", None)] if s]
    for one in inner:
        yield from stops_of(one)


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_stop_criteria_reach_the_rounds(preset, dimension):
    request = Request(preset=preset, rounds=7, target_quality=2.5, time_limit=9.0)
    plan = plan_for(request, dimension)
    stops = list(stops_of(plan.pipeline))
    assert any(stop.rounds == 7 and stop.target_quality == 2.5 for stop in stops)
    assert plan.pipeline.time_limit == 9.0


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
    several = ("smooth.worse-than=2", "smooth.sweeps=5", "swap.pick=best", "smooth.worse-than=3")
    smooth, swap = plan_for(Request(passes=("smooth", "swap"), settings=several)).pipeline.passes()
    assert (smooth.worse_than, smooth.sweeps, swap.pick) == (3.0, 5, "best")


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
        ("collapse.worse-than=2", "collapse"),
    ],
)
def test_a_wrong_setting_is_refused(setting, said):
    assert said in refused(passes=("smooth", "swap"), settings=(setting,))
