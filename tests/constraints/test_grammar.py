"""What vertices are to keep off, as it is written."""

from __future__ import annotations

import pytest

from meshopt_cli.constraints.grammar import keep_off
from meshopt_cli.errors import ConfigError


@pytest.mark.parametrize(
    ("text", "kind", "points", "name", "distance"),
    [
        ("x=0.5:0.02", "plane", ((0.5, 0.0, 0.0), (1.0, 0.0, 0.0)), "", 0.02),
        ("z=-1e2:3", "plane", ((0.0, 0.0, -100.0), (0.0, 0.0, 1.0)), "", 3.0),
        ("plane=1,2/0,2:1", "plane", ((1.0, 2.0, 0.0), (0.0, 2.0, 0.0)), "", 1.0),
        ("point=1,2,3:1", "point", ((1.0, 2.0, 3.0),), "", 1.0),
        ("edge=0,0,0/1,0,0:.5", "edge", ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), "", 0.5),
        ("boundary:0.1", "boundary", (), "", 0.1),
        ("group=a name:with a colon:0.1", "group", (), "a name:with a colon", 0.1),
    ],
)
def test_what_is_written_is_read(text, kind, points, name, distance):
    found = keep_off(text)
    assert (found.kind, found.points, found.name, found.distance) == (kind, points, name, distance)


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("", "WHAT:DISTANCE"),
        ("x=0.5", "WHAT:DISTANCE"),
        (":1", "WHAT:DISTANCE"),
        ("x=0.5:0", "above 0"),
        ("x=0.5:-1", "above 0"),
        ("x=0.5:nan", "not a number"),
        ("x=0.5:inf", "not a number"),
        ("x=:1", "not a number"),
        ("x=1_0:1", "not a number"),
        ("w=0.5:1", "none of"),
        ("boundary=1:1", "none of"),
        ("group=:1", "none of"),
        ("point:1", "none of"),
        ("point=1:1", "no point"),
        ("point=1,2,3,4:1", "no point"),
        ("edge=0,0:1", "2 points"),
        ("face=0,0/1,1:1", "3 points"),
        ("plane=0,0:1", "a point and a normal"),
        ("plane=0,0/0,0:1", "normal of the plane is 0"),
    ],
)
def test_what_is_wrong_is_named_in_one_line(text, wrong):
    with pytest.raises(ConfigError, match=wrong) as caught:
        keep_off(text)
    assert str(caught.value).startswith("--keep-off")
    assert "\n" not in str(caught.value)
