"""Gates: limits on what can be measured of a cell."""

import json

import numpy as np
import pytest

from meshopt_cli.quality.measures import MEASURES
from meshopt_cli.validity import limit_of
from support.edits import tagged
from support.files import write
from support.meshes import quad_grid, tet_grid


@pytest.mark.parametrize(
    ("gates", "code"),
    [
        (["--min-angle", "44"], None),
        (["--min-angle", "46"], "M402"),
        (["--max-angle", "91"], None),
        (["--max-angle", "89"], "M402"),
        (["--min-size", "0.49"], None),
        (["--min-size", "0.51"], "M403"),
        (["--max-aspect", "1.5"], "M404"),
        (["--max-aspect", "3"], None),
        (["--fail-above", "1.5"], "M401"),
        (["--fail-above", "3"], None),
        (["--gate", "dihedral-min>=44"], None),
        (["--gate", "dihedral-min >= 46"], "M404"),
        (["--gate", "edge-max<=0.9"], None),
        (["--gate", "edge-max<=0.8"], "M404"),
        (["--gate", "content>=0.02"], None),
        (["--gate", "content>=0.021"], "M404"),
        (["--gate", "radius-ratio<=9", "--gate", "edge-ratio<=1.1"], "M404"),
    ],
)
def test_gates(check, good, gates, code):
    status, out, _ = check(good, *gates, "--format", "json")
    (file,) = json.loads(out)["files"]
    assert set(file["counts"]) == ({code} if code else set())
    assert status == (1 if code else 0)


def test_a_gate_needs_not_be_selected_but_can_be_ignored(check, good):
    assert check(good, "--select", "M1", "--min-angle", "80")[0] == 1
    assert check(good, "--ignore", "M402", "--min-angle", "80")[0] == 0


def test_a_gate_on_a_region(check, tmp_path):
    of = tagged(tet_grid(2), [1] * 24 + [2] * 24)
    path = write(tmp_path / "two.mesh", of)

    def n_found(gate):
        counts = json.loads(check(path, "--gate", gate, "--format", "json")[1])["files"][0][
            "counts"
        ]
        return counts.get("M404", 0)

    assert n_found("edge-min>=9") == 48
    assert n_found("edge-min>=9 @ 2") == 24
    for region in ("3", "steel"):
        status, out, err = check(path, "--gate", f"edge-min>=9 @ {region}")
        assert (status, out) == (2, "")
        assert str(path) in err
        assert region in err


def test_a_gate_on_a_region_by_name(check, tmp_path):
    of = tagged(tet_grid(2), [1] * 24 + [7] * 24, "gmsh:physical")
    of.names = {(3, 7): "steel", (2, 1): "steel", (2, 7): "wall"}
    of.blocks[0].data["gmsh:geometrical"] = of.blocks[0].data["gmsh:physical"]
    path = write(tmp_path / "named.msh", of)
    out = check(path, "--gate", "edge-min>=9 @ steel", "--format", "json")[1]
    assert json.loads(out)["files"][0]["counts"]["M404"] == 24
    status, _, err = check(path, "--gate", "edge-min>=9 @ wall")  # of another dimension
    assert status == 2
    assert "steel" in err


@pytest.mark.parametrize(
    "text", ["", "edge-min", "edge-min=1", "edge-min>=", "edge-min>=x", "edge-min>=nan", "foo>=1",
             "edge-min>=1 @"]
)  # fmt: skip
def test_a_gate_that_cannot_be_understood(check, good, text):
    status, out, err = check(good, "--gate", text)
    assert (status, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert repr(text) in err


def test_a_gate_that_no_cell_is_measured_by_is_said(check, tmp_path):
    path = write(tmp_path / "quads.vtu", quad_grid(2))
    for gate in (["--gate", "radius-edge<=2"], ["--gate", "dihedral-min>=1"],
                 ["--gate", "hexahedron.skew<=1"]):  # fmt: skip
        status, out, err = check(path, *gate)
        assert (status, out) == (0, f"{path}: valid\n")
        assert "quad" in err
    assert check(path, "--min-angle", "80", "--min-size", "0.1")[2] == ""


def test_a_gate_is_written_as_it_is_read():
    for text in ("dihedral-min >= 10", "aspect-ratio <= 5 @ steel plate"):
        assert str(limit_of(text)) == text


@pytest.mark.parametrize("name", MEASURES)
def test_quantities_of_the_regular_cells(name):
    height = np.sqrt(2 / 3)
    points = np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0],
                       [0.5, np.sqrt(0.75) / 3, height]])  # fmt: skip
    regular = {
        "face-aspect": (None, 1),
        "radius-diameter": (1 / np.sqrt(3), np.sqrt(6) / 4),
        "dihedral-min": (None, np.degrees(np.arccos(1 / 3))),
        "dihedral-max": (None, np.degrees(np.arccos(1 / 3))),
        "solid-min": (None, np.arccos(23 / 27)),
        "corner-min": (60, None),
        "corner-max": (60, None),
        "height-min": (np.sqrt(0.75), height),
        "content": (np.sqrt(3) / 4, np.sqrt(2) / 12),
    }
    for family, cells, expected in zip(
        ("triangle", "tetra"), ([[0, 1, 2]], [[0, 1, 2, 3]]), regular.get(name, (1, 1)), strict=True
    ):
        if name in regular:
            assert (family in MEASURES[name].ways) == (expected is not None)
        if family in MEASURES[name].ways:
            assert MEASURES[name].of(points, np.array(cells), family) == pytest.approx(expected)
