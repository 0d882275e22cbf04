"""Files of options: what is no TOML, or no file, is refused in one line."""

import math
import os
import re
from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.errors import ConfigError
from meshopt_cli.passes import PASSES
from meshopt_cli.plans.config import Request, load, plan_for
from meshopt_cli.plans.keys import Number, Text
from meshopt_cli.plans.settings import option_of
from meshopt_cli.plans.sources import KEYS
from meshopt_cli.plans.toml import LARGEST, nearest_table, read_toml
from support.options import every_option, field_of

DEEP = 3000
TOO_DEEP = {
    "lists": "rounds = " + "[" * DEEP,
    "closed lists": "rounds = " + "[" * DEEP + "]" * DEEP,
    "tables": "rounds = " + "{a = " * DEEP,
    "a dotted key": "rounds" + ".a" * DEEP + " = 1",
    "a dotted table": "[rounds" + ".a" * DEEP + "]",
    "a dotted key of a pass": "[[pass]]\nname = 'smooth'\nsweeps" + ".a" * DEEP + " = 1",
    "a dotted name of a pass": "[[pass]]\nname" + ".a" * DEEP + " = 1",
    "a dotted code": "allow = [{a" + ".a" * DEEP + " = 1}]",
    "hexadecimal": "rounds = 0x" + "f" * DEEP,
    "digits": "rounds = " + "9" * DEEP,
    "a long key": "a" * DEEP + " = 1",
}
# What TOML has besides numbers.
OTHER_VALUES = {
    "1979-05-27": "1979-05-27",
    "07:32:00": "07:32:00",
    "1979-05-27T07:32:00Z": "1979-05-27T07:32:00+00:00",
    "true": "true",
    "[1, 2]": "a list",
    "{a = 1}": "a table",
}


def one_line(message):
    assert message.isprintable()
    assert not re.search(r"Error|datetime|True|\b(int|float|str|dict)\b", message)
    return message


@pytest.mark.parametrize("what", TOO_DEEP)
def test_what_is_too_deep_or_too_long_is_refused(refusal, what):
    assert len(one_line(refusal(TOO_DEEP[what]))) < 400


@pytest.mark.parametrize("value", OTHER_VALUES)
@pytest.mark.parametrize("key", [key for key in KEYS if isinstance(KEYS[key], Number | Text)])
def test_no_key_takes_values_of_other_kinds(refusal, key, value):
    message = one_line(refusal(f"{key} = {value}"))
    assert key in message
    assert OTHER_VALUES[value] in message


@pytest.mark.parametrize("value", OTHER_VALUES)
@every_option
def test_no_option_takes_values_of_other_kinds(refusal, kind, option, value):
    message = one_line(refusal(f"[[pass]]\nname = '{kind.name}'\n{option} = {value}"))
    assert f"{kind.name}.{option}" in message
    assert OTHER_VALUES[value] in message


@every_option
@given(
    value=st.floats()
    | st.integers()
    | st.text()
    | st.sampled_from([10**400, -(10**5000), 2**63 - 1, 2**63, -(2**63), None])
)
def test_an_option_is_within_its_limits_or_refused(kind, option, value):
    f = field_of(kind, option)
    for is_text in (False, True):
        got, message = taken(kind, option, as_text(value) if is_text else value, is_text)
        if message:
            assert f"{kind.name}.{option}: " in message
            assert len(message) < 300
            assert message.isprintable()
        else:
            assert type(got) is type(f.default)
            if not f.metadata["choices"]:
                assert math.isfinite(got)
                assert f.metadata["least"] <= got <= f.metadata["most"]


def taken(kind, option, value, is_text):
    """What a pass has for an option that is set to a value, or why it has not."""
    try:
        name, made = option_of(kind, option, value, is_text)
        return getattr(kind(**{name: made}), name), ""
    except ConfigError as error:
        return None, str(error)


def as_text(value):
    try:
        return str(value)
    except ValueError:  # more digits than Python writes
        return "-" + "9" * 5000


def test_a_byte_order_mark_and_line_ends_of_windows(tmp_path):
    path = tmp_path / "pipeline.toml"
    path.write_bytes(b"\xef\xbb\xbfrounds = 3\r\ngain = 0.5\r\n")
    assert load(path).values == {"rounds": 3, "gain": 0.5}


def test_a_file_without_an_end_is_refused(tmp_path):
    path = tmp_path / "pipeline.toml"
    path.write_bytes(b"#" * (LARGEST + 1))
    for large in (path, *(["/dev/zero"] if os.path.exists("/dev/zero") else [])):
        with pytest.raises(ConfigError, match="larger than any file of options"):
            read_toml(type(path)(large))


def test_a_folder_is_no_file_of_options(tmp_path):
    with pytest.raises(ConfigError, match=str(tmp_path)):
        plan_for(Request(config=tmp_path))


def test_what_is_no_file_is_passed_over(tmp_path):
    """On the way upwards: a pipe would be waited for."""
    below = tmp_path / "below"
    below.mkdir()
    (tmp_path / "x.toml").write_text("[check]\nlimit = 3\n")
    os.mkfifo(below / "x.toml")
    assert nearest_table(below, {"x.toml": ("check",)}) == (tmp_path / "x.toml", {"limit": 3})


def test_every_option_is_a_number_or_a_text():
    for kind in PASSES.values():
        assert {f.type for f in fields(kind)} <= {"int", "float", "str"}
