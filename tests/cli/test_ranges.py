"""The numbers that options take: one table for the command line and for files."""

import math
import re
from datetime import date, datetime, time

import click
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.cli.check_config import NOT_KEYS
from meshopt_cli.cli.entry import status_of
from meshopt_cli.cli.main import COMMANDS, main
from meshopt_cli.cli.options import Number
from meshopt_cli.errors import ConfigError
from meshopt_cli.plans.config import Request, load, plan_for
from meshopt_cli.plans.ranges import MOST, RANGES, Range, cut, quoted
from meshopt_cli.plans.sources import NUMBERS
from meshopt_cli.quality.gates import limit_of
from support.files import write
from support.meshes import tet_grid


def options_of(command):
    parameters = main.get_command(click.Context(main), command).params
    return [p for p in parameters if isinstance(p, click.Option)]


FLAGS = [
    (command, option.opts[0].removeprefix("--"))
    for command in COMMANDS
    for option in options_of(command)
    if isinstance(option.type, Number)
]
CHECK_KEYS = [key for command, key in FLAGS if command == "check" and key not in NOT_KEYS]
every_flag = pytest.mark.parametrize(("command", "key"), FLAGS)
every_key = pytest.mark.parametrize("key", NUMBERS)
every_check_key = pytest.mark.parametrize("key", CHECK_KEYS)
every_range = pytest.mark.parametrize("key", RANGES)


def wrong_values(key):
    """Texts that no option takes, and those out of its range; all of them are TOML too."""
    row = RANGES[key]
    texts = ["nan", "-inf", str(row.least - 1)]
    if not row.is_endless:
        texts.append("inf")
    if math.isfinite(row.most):
        texts += [str(2**63), str(row.most * 1.01) if not row.is_whole else str(row.most + 1)]
    if row.is_whole:
        texts += ["1.5", "3.0", "1e1"]
    if row.is_open:
        texts.append(str(row.least))
    return texts


# Numbers to Python, or nearly so.
ODD_TEXTS = ["1_000", "\u0663", "0x10", "1\u20093", "\x1b[31m1", "-" + "9" * 10_000]


@pytest.fixture
def tets(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return write(tmp_path / "tets.vtk", tet_grid(2))


def test_no_number_option_has_a_range_of_its_own():
    for command in COMMANDS:
        for option in options_of(command):
            assert not isinstance(
                option.type, click.types.IntParamType | click.types.FloatParamType
            )
            if isinstance(option.type, Number):
                assert option.opts == [f"--{option.type.key}"]
    assert {key for _, key in FLAGS} | set(NUMBERS) == set(RANGES)


@every_flag
def test_a_flag_refuses_what_is_out_of_range(tets, tmp_path, capsys, command, key):
    arguments = [
        command,
        str(tets),
        *([str(tmp_path / "out.vtk")] if command == "optimize" else []),
    ]
    for text in (*wrong_values(key), "much", "", *ODD_TEXTS):
        status = status_of([*arguments, f"--{key}={text}"])
        out, err = capsys.readouterr()
        assert (status, out) == (2, ""), text
        assert f"--{key}" in err
        assert text[:40] in err or repr(text) in err
        assert len(err.splitlines()) == 1
        assert len(err) < 300
    assert not (tmp_path / "out.vtk").exists()


@every_key
def test_a_pipeline_file_refuses_what_is_out_of_range(tmp_path, key):
    path = tmp_path / "pipeline.toml"
    for text in wrong_values(key):
        path.write_text(f"{key} = {text}\n")
        with pytest.raises(ConfigError) as caught:
            plan_for(Request(config=path))
        message = str(caught.value)
        assert str(path) in message
        assert key in message.removeprefix(str(path))


@every_check_key
def test_the_configuration_of_check_refuses_what_is_out_of_range(tets, tmp_path, capsys, key):
    path = tmp_path / "meshopt.toml"
    for text in wrong_values(key):
        path.write_text(f"[check]\n{key} = {text}\n")
        status = status_of(["check", str(tets)])
        out, err = capsys.readouterr()
        assert (status, out) == (2, ""), text
        assert str(path) in err
        assert key in err.replace(str(path), "")


@every_key
def test_a_request_is_held_to_the_same_ranges(key):
    if key == "gain":
        return  # only a file has it
    for value in (math.nan, -math.inf, 2**63 if RANGES[key].is_whole else RANGES[key].least - 1):
        with pytest.raises(ConfigError, match=key):
            plan_for(Request(**{key.replace("-", "_"): value}))


def test_no_limit_of_time_can_be_said(tmp_path):
    path = tmp_path / "pipeline.toml"
    path.write_text("time-limit = inf\n")
    assert plan_for(Request(config=path)).pipeline.time_limit == math.inf
    assert plan_for(Request(time_limit=math.inf)).pipeline.time_limit == math.inf


def test_a_number_of_a_wrong_kind_is_refused_when_the_file_is_read(tmp_path):
    path = tmp_path / "pipeline.toml"
    for key in NUMBERS:
        for text in ("true", '"1"', "[1]", *(["2.0"] if RANGES[key].is_whole else [])):
            path.write_text(f"{key} = {text}\n")
            with pytest.raises(ConfigError, match=key):
                load(path)


@every_range
@given(value=st.floats() | st.integers() | st.integers(2**63 - 2, 2**64) | st.just(10**400))
def test_a_range_takes_what_is_in_it_and_nothing_else(key, value):
    row = RANGES[key]
    large = value in (math.inf, 10**400)
    inside = row.least <= value <= row.most and not (row.is_open and value == row.least)
    inside &= row.is_endless or not large
    inside &= not row.is_whole or isinstance(value, int)
    for given_value in (value, repr(value)):
        if inside:
            assert row.number(given_value) == (
                math.inf if large else value if row.is_whole else float(value)
            )
        else:
            with pytest.raises(ValueError, match=re.escape(cut(repr(value)))):
                row.number(given_value)


@every_range
@given(
    value=st.one_of(
        st.text(), st.dates(), st.times(), st.booleans(), st.none(), st.lists(st.floats())
    )
)
def test_a_range_takes_no_other_things(key, value):
    row = RANGES[key]
    number, message = number_or_message(row, value)
    if number is None:
        assert len(message) < 200
        assert message.isprintable()
    else:
        assert isinstance(value, str)
        assert value.isascii()
        assert row.least <= number <= row.most


def number_or_message(row, value):
    try:
        return row.number(value), ""
    except ValueError as error:
        return None, str(error)


@every_range
@pytest.mark.parametrize("n_digits", [400, 4000, 10_000])
def test_numbers_of_any_length(key, n_digits):
    row = RANGES[key]
    for number in (10**n_digits, -(10**n_digits)):
        if number > 0 and row.is_endless:
            assert row.number(number) == math.inf
            continue
        for value in (number, ("-" if number < 0 else "") + "9" * n_digits):
            with pytest.raises(ValueError, match="out of range") as caught:
                row.number(value)
            assert len(str(caught.value)) < 200


@pytest.mark.parametrize(
    "value",
    ["nan", "inf", "-inf", "1e999", "1_000", "\u0663", "1,5", "0x1", "", "9" * 10_000],
)
def test_a_gate_has_a_finite_number(value):
    with pytest.raises(ConfigError, match="VALUE is a finite number") as caught:
        limit_of(f"height-min>={value}")
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("value", ["1", "-1.5", "+.5", "5.", "1e3", "2.5E-7"])
def test_a_gate_is_a_number_as_anyone_writes_it(value):
    assert limit_of(f"height-min >= {value} @ steel").value == float(value)


TOML_VALUES = [
    "nan", "-1", "1979-05-27", "07:32:00", "true", "false", "[]", "[1]", "[[]]", "{}", '""',
    '"x\\u001b\\n"', "9223372036854775808", "1e400", '["height-min>=nan"]', '"\\u0000"',
]  # fmt: skip


@pytest.mark.parametrize(
    "key", [option.opts[-1].removeprefix("--") for option in options_of("check")]
)
def test_whatever_a_file_says_check_ends_with_a_status(tets, tmp_path, capsys, key):
    for text in TOML_VALUES:
        (tmp_path / "meshopt.toml").write_text(f"[check]\n{key} = {text}\n")
        status = status_of(["check", str(tets)])
        _, err = capsys.readouterr()
        assert status in (0, 1, 2), (text, err)
        if status == 2:
            (line,) = err.splitlines()
            assert line.isprintable()
            assert not re.search(r"datetime|Error|True", line)


def test_what_is_shown_of_values():
    """No words of Python, and one short line."""
    assert [quoted(v) for v in (True, {"a": 1}, [1], 1.5, "a\nb")] == [
        "true", "a table", "a list", "1.5", r"'a\nb'",
    ]  # fmt: skip
    assert quoted(date(1979, 5, 27)) == "1979-05-27"
    assert quoted(datetime(1979, 5, 27, 7, 32)) == "1979-05-27T07:32:00"
    assert quoted(time(7, 32)) == "07:32:00"
    assert len(quoted("x" * 10_000)) < 100
    assert len(quoted(10**10_000)) < 100


def test_a_number_too_long_to_be_read_is_refused(tmp_path):
    path = tmp_path / "pipeline.toml"
    path.write_text(f"rounds = {'9' * 5000}\n")
    with pytest.raises(ConfigError, match="TOML"):
        load(path)


def test_what_a_range_says_of_itself():
    assert str(Range(1)) == "finite and at least 1"
    assert str(Range(0, is_endless=True)) == "at least 0"
    assert str(Range(0, 1)) == "from 0 to 1"
    assert str(Range(0, 0.1, is_open=True)) == "above 0 and at most 0.1"
    assert str(Range(1, MOST, is_whole=True)) == f"from 1 to {MOST}"
