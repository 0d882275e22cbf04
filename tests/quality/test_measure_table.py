"""Every row of the table of measures for every family that has it, and all that reads the table."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshopt_cli.cells import FAMILIES
from meshopt_cli.cli.entry import status_of
from meshopt_cli.errors import ConfigError
from meshopt_cli.jobs.check import needs_kernels
from meshopt_cli.kernels.shape.angles import angle_range
from meshopt_cli.mesh.model import Mesh
from meshopt_cli.quality.gates import Gates, gates_of, limit_of
from meshopt_cli.quality.measurable import measurable
from meshopt_cli.quality.measures import (
    DEFAULT_MEASURE,
    LESS,
    MEASURES,
    MORE,
    OF_SIMPLICES,
    POWERS,
    QUALITIES,
    measure_named,
)
from meshopt_cli.quality.summary import summarize
from meshopt_cli.quality.verdict.table import every_measure
from meshopt_cli.validity import check
from support.files import write
from support.meshes import in_space, mesh, octahedron, rotations, tri_grid
from support.processes import run_python
from support.samples import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
ROWS = [(row, family) for row in MEASURES.values() for family in row.ways]
every_row = pytest.mark.parametrize(("row", "family"), ROWS, ids=[f"{r.name}-{f}" for r, f in ROWS])
seeds = st.integers(0, 2**32 - 1)


def reference(family):
    """The ideal cell of a family: its points, and itself."""
    points = FAMILIES[family].reference
    return points, np.arange(len(points))[None]


def shaken(family, seed, amount=0.15):
    """The ideal cell with its corners moved; a face stays in its plane."""
    points, cells = reference(family)
    by = np.random.default_rng(seed).uniform(-amount, amount, points.shape)
    by[:, FAMILIES[family].dimension :] = 0.0
    return points + by, cells


def turned(points, seed):
    """Points after some rotation."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    q[:, 0] *= np.linalg.det(q)
    return points @ q.T


# Rows ----------------------------------------------------------------------------------------


@every_row
def test_a_row_says_all_there_is(row, family):
    way = row.ways[family]
    assert family in FAMILIES
    assert bool(way.kernel) != (way.function is not None)
    assert row.unit in POWERS
    assert row.better in (LESS, MORE)
    assert row.formula
    assert MEASURES[row.name] is row


def test_those_that_steer_are_compiled_and_a_q():
    assert QUALITIES[DEFAULT_MEASURE].drives
    for row in MEASURES.values():
        if row.drives:
            assert row.is_quality
            assert row.is_compiled
        if row.is_compiled:
            assert row.judge.lenience == 0.0
    assert set(QUALITIES) == {name for name, row in MEASURES.items() if row.is_quality}
    assert {FAMILIES[f].dimension for f in QUALITIES[DEFAULT_MEASURE].ways} == {2, 3}


@pytest.mark.parametrize("name", MEASURES)
def test_only_a_q_can_be_the_measure(name):
    if name in QUALITIES:
        assert measure_named(name) is MEASURES[name]
    else:
        with pytest.raises(ConfigError, match=f"no measure '{name}'"):
            measure_named(name)


@every_row
def test_the_ideal_cell(row, family):
    (value,) = row.of(*reference(family), family)
    if row.ideal is not None:
        assert value == pytest.approx(row.ideal, rel=1e-12, abs=1e-12)
    elif row.unit == "length" and row.name.startswith("edge"):
        assert value == pytest.approx(1.0, rel=1e-12)
    assert 0.0 <= value < 180.0


@every_row
@settings(max_examples=20, deadline=None)
@given(seeds, st.integers(-20, 20))
def test_it_does_not_matter_where_a_cell_is_and_its_size_only_as_the_unit_says(
    row, family, seed, exponent
):
    points, cells = shaken(family, seed)
    (value,) = row.of(points, cells, family)
    scale = 2.0**exponent
    moved = scale * (turned(points, seed) + np.array([3.0, -1.0, 2.0]))
    expected = value * scale ** row.power(FAMILIES[family].dimension)
    assert row.of(moved, cells, family)[0] == pytest.approx(expected, rel=1e-7, abs=1e-7)


@every_row
@settings(max_examples=10, deadline=None)
@given(seeds)
def test_it_does_not_matter_where_the_numbering_of_a_cell_begins(row, family, seed):
    points, cells = shaken(family, seed)
    values = [row.of(points, cells[:, turn], family)[0] for turn in rotations(family)]
    assert values == pytest.approx([values[0]] * len(values), rel=1e-9, abs=1e-9)


@every_row
def test_a_mirrored_cell_is_as_good_as_before(row, family):
    """Whether it is turned the wrong way is not for a measure to say."""
    points, cells = shaken(family, 3)
    (value,) = row.of(points, cells, family)
    mirrored = points * np.array([-1.0, 1.0, 1.0])
    assert row.of(mirrored, cells, family)[0] == pytest.approx(value, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", ["aspect-ratio", "worst-simplex", "volume-length"])
@pytest.mark.parametrize("family", [f for f in FAMILIES if not FAMILIES[f].is_simplex])
@pytest.mark.parametrize("corner", range(4))
def test_a_cell_that_is_inverted_at_a_corner_has_no_quality(name, family, corner):
    points, cells = reference(family)
    middle = points.mean(axis=0)
    moved = points.copy()
    moved[corner] += 1.7 * (middle - moved[corner])
    assert MEASURES[name].of(moved, cells, family).tolist() == [math.inf]


@pytest.mark.parametrize(("row", "family"), [(r, f) for r, f in ROWS if r.ideal is not None])
@settings(max_examples=20, deadline=None)
@given(seeds)
def test_no_cell_is_better_than_the_ideal_one(row, family, seed):
    (value,) = row.of(*shaken(family, seed), family)
    assert value >= row.ideal - 1e-12 if row.better == LESS else value <= row.ideal + 1e-12


@every_row
def test_many_cells_are_measured_as_one_by_one(row, family):
    parts = [shaken(family, seed) for seed in range(5)]
    n = FAMILIES[family].n_corners
    points = np.concatenate([p for p, _ in parts])
    cells = np.arange(5 * n).reshape(5, n)
    alone = [row.of(p, c, family)[0] for p, c in parts]
    assert row.of(points, cells, family).tolist() == alone
    assert row.of(points, cells[:0], family).shape == (0,)


# Gates ---------------------------------------------------------------------------------------


@every_row
@pytest.mark.parametrize("scale", [1.0, 1e-5])
def test_a_gate_on_every_row(row, family, scale):
    """It lets a cell pass whose value is within the limit, and no other."""
    points, cells = shaken(family, 7)
    points[0, 2] += 0.1  # a quad that is folded
    points = scale * points
    value = float(row.of(points, cells, family)[0])
    of = mesh(points, **{family: cells})
    for sign, better in ((">=", 1 - 1e-6), ("<=", 1 + 1e-6)):
        for factor, found in ((better, ()), (2 - better, ("M404",))):
            gates = Gates(others=(limit_of(f"{row.name}{sign}{factor * value!r}"),))
            assert check(of, ["M404"], gates=gates).codes == found


@pytest.mark.parametrize("name", [name for name in every_measure() if name not in MEASURES])
@pytest.mark.parametrize("scale", [1.0, 1e-5])
def test_a_gate_on_every_measure_of_verdict(name, scale):
    """Of a cell of its family, in whatever unit; other cells are let through."""
    (family,) = every_measure()[name].ways
    points, cells = shaken(family, 7)
    points = scale * points
    value = float(every_measure()[name].of(points, cells, family)[0])
    of = mesh(points, **{family: cells})
    less, more = value - 1e-6 * abs(value), value + 1e-6 * abs(value)
    for gate, found in ((f">={less!r}", ()), (f"<={more!r}", ())):
        assert check(of, ["M404"], gates=Gates(others=(limit_of(name + gate),))).codes == found
    for gate in (f">={more + 1e-9 * scale**3!r}", f"<={less - 1e-9 * scale**3!r}"):
        gates = Gates(others=(limit_of(name + gate),))
        assert check(of, ["M404"], gates=gates).codes == ("M404",)
    other = "tetra" if family != "tetra" else "hexahedron"
    points, cells = shaken(other, 7)
    gates = Gates(others=(limit_of(f"{name}<=-1e9"),))
    assert check(mesh(points, **{other: cells}), ["M404"], gates=gates).is_valid


@pytest.mark.parametrize("name", every_measure())
@given(value=st.floats(-1e6, 1e6), is_least=st.booleans(), region=st.none() | st.just("steel 2"))
def test_a_gate_reads_back(name, value, is_least, region):
    text = f"{name}{'>=' if is_least else '<='}{value!r}{'' if region is None else ' @ ' + region}"
    limit = limit_of(text)
    assert (limit.name, limit.is_least, limit.value, limit.region) == (
        name,
        is_least,
        value,
        region,
    )
    assert limit_of(str(limit)).measure is every_measure()[name]


@pytest.mark.parametrize("name", MEASURES)
def test_kernels_are_needed_for_what_is_compiled(name):
    gates = gates_of(gates=[f"{name}<=5"])
    assert needs_kernels([], gates) == MEASURES[name].is_compiled


def test_the_gates_with_options_of_their_own():
    everything = gates_of(2.0, "mean-edge", 10.0, 170.0, 0.1, 5.0, ["content>=1"])
    assert everything.codes == ("M401", "M402", "M403", "M404")
    told = {(limit.code, str(limit)) for limit in everything.limits}
    assert told == {
        ("M401", "mean-edge <= 2"),
        ("M402", "dihedral-min >= 10"),
        ("M402", "corner-min >= 10"),
        ("M402", "dihedral-max <= 170"),
        ("M402", "corner-max <= 170"),
        ("M403", "edge-min >= 0.1"),
        ("M404", "aspect-ratio <= 5"),
        ("M404", "content >= 1"),
    }
    assert gates_of().limits == ()
    with pytest.raises(ConfigError, match="dihedral-min"):
        gates_of(2.0, "dihedral-min")


def test_no_angle_of_one_family_is_held_against_another():
    """A cube has right angles, whatever is asked of its corners."""
    points, cells = reference("hexahedron")
    of = mesh(points, hexahedron=cells)
    assert check(of, ["M402"], gates=gates_of(min_angle=89.0, max_angle=91.0)).codes == ()
    assert check(of, ["M402"], gates=gates_of(min_angle=91.0)).codes == ("M402",)


@settings(max_examples=50, deadline=None)
@given(seeds, st.integers(0, 9))
def test_gates_and_reports_have_the_same_dihedral_angles(seed, flat):
    """Near 0 and 180 degrees too, where the cosine of an angle says nothing of it."""
    points, cells = shaken("tetra", seed)
    points[3, 2] *= 10.0**-flat
    least, greatest = np.degrees(angle_range(points, cells))
    (low,), (high,) = (MEASURES[f"dihedral-{x}"].of(points, cells, "tetra") for x in ("min", "max"))
    assert low == pytest.approx(least, rel=1e-9, abs=1e-12)
    assert 180 - high == pytest.approx(180 - greatest, rel=1e-6, abs=1e-12)


def test_check_without_a_measure_needs_no_kernels(tmp_path):
    """Neither does one with limits on angles and lengths."""
    points, cells = reference("tetra")
    path = write(tmp_path / "one.vtu", mesh(points, tetra=cells))
    ask = ["check", str(path), "--no-config", "--min-angle", "1", "--gate", "height-min>=0.1"]
    code = (
        "import sys; from meshopt_cli.cli.entry import status_of\n"
        f"assert status_of({ask!r}) == 0\n"
        "print([m for m in sys.modules if m.startswith('meshopt_cli.kernels.shape.')])"
    )
    assert run_python(code).splitlines()[-1] == "[]"


# Lists ---------------------------------------------------------------------------------------


def test_the_list_shows_every_row(capsys):
    assert status_of(["list", "measures"]) == 0
    out = capsys.readouterr().out
    starts = [re.search(rf"^{name} ", out, re.M).start() for name in MEASURES]
    assert starts == sorted(starts)
    for row, start, end in zip(MEASURES.values(), starts, [*starts[1:], len(out)], strict=True):
        part = " ".join(out[start:end].split())
        assert all(family in part for family in row.ways)
        assert ("only" in part) != row.drives
        assert row.unit in part


def test_the_readme_names_every_row():
    text = README[README.index("### Measures") :]
    text = text[: text.index("\n## ")]
    named = [n for n in re.findall(r"`([a-z-]+)`", text) if n in MEASURES]
    assert sorted(named) == sorted(MEASURES)
    assert set(named[: len(QUALITIES) - 1]) <= set(QUALITIES)


# Surfaces ------------------------------------------------------------------------------------


def bent(of, angle):
    """A planar mesh with what lies right of x = 1/2 turned up around that line."""
    points = in_space(of).points.copy()
    right = points[:, 0] > 0.5
    x = points[right, 0] - 0.5
    points[right, 0], points[right, 2] = 0.5 + math.cos(angle) * x, math.sin(angle) * x
    return Mesh(points, of.blocks)


@pytest.mark.parametrize("name", OF_SIMPLICES)
def test_a_surface_is_measured_as_it_was_before_it_was_bent(name):
    flat, up = measurable(tri_grid(4)), measurable(bent(tri_grid(4), 1.0))
    assert flat.notes == ()
    assert len(up.notes) == 1
    one, other = (summarize(p.simplices, OF_SIMPLICES[name]) for p in (flat, up))
    assert (one.n_points, one.n_cells, one.counts) == (other.n_points, other.n_cells, other.counts)
    for figure in ("worst", "mean", "best", "target", "angle_min", "angle_max"):
        assert getattr(one, figure) == pytest.approx(getattr(other, figure), rel=1e-9)


def test_a_surface_has_the_points_it_has():
    part = measurable(octahedron())
    summary = summarize(part.simplices, QUALITIES[DEFAULT_MEASURE])
    assert (summary.n_points, summary.n_cells) == (6, 8)
    assert summary.n_invalid == 0
