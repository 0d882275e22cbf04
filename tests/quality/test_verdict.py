"""The measures of Verdict: against VTK, on ideal, shaken, moved, inverted and degenerate cells."""

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshopt_cli.cells import FAMILIES
from meshopt_cli.errors import ConfigError
from meshopt_cli.quality.verdict import VERDICT, mean_size, verdict_quality
from meshopt_cli.quality.verdict.model import LESS, MORE, POWERS, SIZE
from verdict import KINDS, by_vtk, compared, mesh_of, ours, quality_filter

SOLIDS = [key for key in VERDICT if FAMILIES[key[0]].dimension == 3]
seeds = st.integers(0, 2**32 - 1)


def each(keys):
    return pytest.mark.parametrize(("kind", "name"), keys, ids=["-".join(key) for key in keys])


every_row = each(list(VERDICT))


def shaken(kind, seed, n=20, amount=0.15):
    """Ideal cells with their corners moved in space, (n, k, 3): valid for the usual amount."""
    reference = FAMILIES[kind].reference
    by = np.random.default_rng(seed).uniform(-amount, amount, (n, *reference.shape))
    return reference + by


@pytest.fixture(scope="module")
def vtk():
    pytest.importorskip("vtkmodules.vtkFiltersVerdict")
    return by_vtk


# Rows ----------------------------------------------------------------------------------------


@every_row
def test_a_row_says_all_there_is(kind, name):
    row = VERDICT[kind, name]
    assert (row.cell_type, row.name) == (kind, name)
    assert row.unit in POWERS
    assert row.better in (LESS, MORE, SIZE)
    assert row.formula
    assert (row.ideal is None) == (row.unit in ("length", "area", "volume"))
    assert row.sized == ("size" in name)


def test_all_measures_of_vtk_are_there(vtk):
    for kind, (word, _, count) in KINDS.items():
        start = f"Set{word}QualityMeasureTo"
        theirs = {a.removeprefix(start) for a in dir(quality_filter()) if a.startswith(start)}
        assert theirs == {name.title().replace("-", "") for k, name in VERDICT if k == kind}
        assert len(theirs) == count


@pytest.mark.parametrize(("kind", "name"), [("tetra", "taper"), ("vertex", "area")])
def test_unknown_measures_are_told(kind, name):
    with pytest.raises(ConfigError, match="no measure"):
        ours(shaken("tetra", 0), kind, name)


@every_row
def test_no_cells_have_no_values(kind, name):
    assert ours(np.empty((0, FAMILIES[kind].n_corners, 3)), kind, name).shape == (0,)


def test_cells_of_higher_order_count_by_their_corners():
    points, cells = mesh_of(shaken("tetra", 0))
    more = np.hstack([cells, cells])
    for name in ("shape", "shape-and-size"):
        found = verdict_quality(points, more, "tetra", name)
        assert np.array_equal(found, verdict_quality(points, cells, "tetra", name))


# VTK -----------------------------------------------------------------------------------------


@every_row
@settings(max_examples=10, deadline=None)
@given(seed=seeds)
def test_values_are_those_of_vtk(vtk, kind, name, seed):
    a, b = compared(vtk, shaken(kind, seed), kind, name)
    # Those near 0 are differences of numbers about 1, which leave 1e-16 of these.
    assert a == pytest.approx(b, rel=1e-12, abs=1e-14)


@every_row
@pytest.mark.parametrize("amount", [0.5, 2.0])
def test_values_of_any_cells_are_those_of_vtk(vtk, kind, name, amount):
    """Inverted, concave and nearly flat ones too: there, few digits of a volume are left."""
    a, b = compared(vtk, shaken(kind, 1, 2000, amount), kind, name)
    assert len(a) > 20
    # The arc cosine of VTK leaves 1e-16 of a cosine, which is more of an angle near 0.
    least = 1e-9 if VERDICT[kind, name].unit == "degrees" else 1e-12
    assert a == pytest.approx(b, rel=1e-9, abs=least)


# Those that are not the same for a cell with two corners in one, as their notes tell.
NOTED = ("inradius", "skew", "distortion", "min-angle", "max-angle", "collapse-ratio")
# Quotients of two numbers that vanish, or with the sign of one.
NOISE = {("tetra", "condition"), ("tetra", "radius-ratio")}


@each([key for key in VERDICT if not key[1].endswith(NOTED) and key not in NOISE])
def test_cells_with_two_corners_in_one_are_as_vtk_has_them(vtk, kind, name):
    x = shaken(kind, 3, 1)
    edges = FAMILIES[kind].edges.tolist()
    for one, other in combinations(range(x.shape[1]), 2):
        y = x.copy()
        y[:, other] = y[:, one]
        a, b = compared(vtk, y, kind, name)
        if (kind, name) in UNSCALED and [one, other] in edges:
            assert (a <= 0.0).all()
            continue
        # Of a volume that vanishes there may be noise left, in either.
        a, b = np.clip(a, -1e6, 1e6), np.clip(b, -1e6, 1e6)
        assert a == pytest.approx(b, rel=1e-9, abs=1e-7), (one, other)


# There, VTK gives infinite or leaves out a corner with an edge without length.
UNSCALED = {("wedge", "scaled-jacobian"), ("hexahedron", "scaled-jacobian")}


@settings(max_examples=10, deadline=None)
@given(seed=seeds, side=st.integers(0, 3))
def test_quads_with_a_side_without_length_are_triangles(seed, side):
    x = shaken("triangle", seed)
    folded = np.roll(x[:, [0, 1, 2, 2]], side - 2, axis=1)
    same = ["min-angle", "max-angle"]
    if side == 2:  # only that, as VTK has it
        same += ["condition", "scaled-jacobian", "distortion"]
        assert ours(folded, "quad", "jacobian") == pytest.approx(2 * ours(x, "triangle", "area"))
    for name in same:
        assert ours(folded, "quad", name) == pytest.approx(ours(x, "triangle", name), rel=1e-12)


# Properties ----------------------------------------------------------------------------------


@each([key for key, row in VERDICT.items() if row.ideal is not None])
def test_the_ideal_cell_has_the_ideal_value(kind, name):
    found = ours(FAMILIES[kind].reference[None], kind, name)
    assert found == pytest.approx(VERDICT[kind, name].ideal, abs=1e-13, rel=1e-14)


# A face that is bent may have short diagonals.
@each([k for k, row in VERDICT.items() if row.ideal is not None and "stretch" not in k[1]])
@settings(max_examples=10, deadline=None)
@given(seed=seeds)
def test_no_valid_cell_is_better_than_the_ideal_one(kind, name, seed):
    row, values = VERDICT[kind, name], ours(shaken(kind, seed), kind, name)
    better = row.ideal - values if row.better == LESS else values - row.ideal
    assert (better < 1e-9).all()


@every_row
@settings(max_examples=10, deadline=None)
@given(seed=seeds, scale=st.integers(-15, 15))
def test_values_stay_when_cells_are_turned_moved_and_scaled(kind, name, seed, scale):
    rng = np.random.default_rng(seed)
    x = shaken(kind, seed)
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    q[:, 0] *= np.linalg.det(q)
    moved = 10.0**scale * (x @ q.T + rng.uniform(-1.0, 1.0, 3))
    power = 10.0 ** (scale * POWERS[VERDICT[kind, name].unit])
    a, b = ours(moved, kind, name) / power, ours(x, kind, name)
    assert a == pytest.approx(b, rel=1e-9, abs=1e-9)


# Other numberings of the same cell, not mirrored.
TURNS = {
    "triangle": [[1, 2, 0]],
    "quad": [[1, 2, 3, 0]],
    "tetra": [[1, 2, 0, 3], [1, 0, 3, 2]],
    "pyramid": [[1, 2, 3, 0, 4]],
    "wedge": [[1, 2, 0, 4, 5, 3], [3, 5, 4, 0, 2, 1]],
    "hexahedron": [[1, 2, 3, 0, 5, 6, 7, 4], [0, 3, 7, 4, 1, 2, 6, 5]],
}
# Verdict takes the normal of corner 0 for that of a bent quad.
BENT = {("pyramid", "shape"), ("quad", "distortion")}


@each([key for key in VERDICT if key not in BENT])
@settings(max_examples=10, deadline=None)
@given(seed=seeds)
def test_values_stay_when_corners_are_numbered_otherwise(kind, name, seed):
    x = shaken(kind, seed)
    for turn in TURNS[kind]:
        a, b = ours(x[:, turn], kind, name), ours(x, kind, name)
        assert a == pytest.approx(b, rel=1e-11, abs=1e-13)


# What a solid inside out gives, where that is not the same as for its image.
INVERTED = {
    "negative": {
        ("tetra", "collapse-ratio"), ("tetra", "condition"), ("tetra", "inradius"),
        ("tetra", "mean-ratio"), ("tetra", "normalized-inradius"),
        *((k, n) for k, n in SOLIDS if n in ("volume", "jacobian", "scaled-jacobian")),
    } - {("pyramid", "scaled-jacobian")},
    "zero": {
        ("pyramid", "scaled-jacobian"),
        *((k, n) for k, n in SOLIDS if n.startswith(("shape", "shear")) or n.endswith("squared")),
    },
    "infinite": {
        ("hexahedron", name)
        for name in ("condition", "max-aspect-frobenius", "med-aspect-frobenius", "oddy",
                     "nodal-jacobian-ratio")
    },
    "beyond 1": {("tetra", "squish-index")},
}  # fmt: skip


@each([key for key in SOLIDS if key[1] != "distortion"])
@settings(max_examples=5, deadline=None)
@given(seed=seeds)
def test_inverted_cells_are_detected(kind, name, seed):
    row, x = VERDICT[kind, name], shaken(kind, seed)
    more = (mean_size(*mesh_of(x), kind),) if row.sized else ()
    values, image = row.function(x, *more), row.function(x * [-1.0, 1.0, 1.0], *more)
    if (kind, name) in INVERTED["negative"]:
        assert (image < 0.0).all()
    elif (kind, name) in INVERTED["zero"]:
        assert (image == 0.0).all()
    elif (kind, name) in INVERTED["infinite"]:
        assert (image == (math.inf if row.better == LESS else -math.inf)).all()
    elif (kind, name) in INVERTED["beyond 1"]:
        assert (image > 1.0).all()
    else:
        assert image == pytest.approx(values, rel=1e-12, abs=1e-14)


def test_concave_quads_are_detected():
    dart = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]]])
    values = {name: float(ours(dart, kind, name)[0]) for kind, name in VERDICT if kind == "quad"}
    assert max(values["jacobian"], values["scaled-jacobian"], values["distortion"]) < 0.0
    assert values["shape"] == values["shear"] == values["shape-and-size"] == 0.0
    assert values["condition"] == math.inf
    # All but the angle between (1.5, -0.5) and (-0.5, 1.5), of cosine -3/5.
    assert values["max-angle"] == pytest.approx(360.0 - math.degrees(math.acos(-0.6)))


@every_row
def test_cells_without_extent_have_values(kind, name):
    """The worst there are, where less or more is better, and no warning."""
    x = shaken(kind, 0, 3)
    x[0] = x[0, :1]
    x[1, :, 1:] = 0.0
    x[2, :, 2] = 0.0
    assert not np.isnan(ours(x, kind, name)).any()


# What VTK gives other values for, by hand.
BOX = FAMILIES["hexahedron"].reference * [1, 1, 2]
CUT = [[0, 0, 0], [2, 0, 0], [1, 1, 0], [0, 1, 0], [0.75, 0.5, math.sqrt(2)]]
BOWTIE = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
RIGHT_TRIANGLE = [[0, 0, 0], [0, 0, 0], [1, 0, 0], [0, 1, 0]]
HAND = [
    ("triangle", "normalized-inradius", RIGHT_TRIANGLE[:3], 0.0),
    ("tetra", "normalized-inradius", RIGHT_TRIANGLE, 0.0),
    ("hexahedron", "edge-ratio", BOX, 2.0),
    # Height of corner 2, 2 / sqrt(12), by edge 13, sqrt(8).
    ("tetra", "collapse-ratio", [[1, 1, 0], [-1, 0, 1], [-1, 1, 1], [1, 0, -1]], 1 / math.sqrt(24)),
    # Along edge 13, the corners 0 and 2 are at (1, 2) and (2, 1).
    ("tetra", "min-angle", [[0, 0, 1], [-1, 2, -1], [1, 0, 0], [-1, -1, -1]],
     math.degrees(math.acos(0.8))),
    ("tetra", "equivolume-skew", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], 1.0),
    # Base of shape 2/3; straight; as high as its longest edge, 2, asks for.
    ("pyramid", "shape", CUT, 2 / 3),
    ("quad", "skew", BOWTIE, math.inf),
    ("quad", "min-angle", RIGHT_TRIANGLE, 45.0),
    ("quad", "max-angle", RIGHT_TRIANGLE, 90.0),
    ("quad", "equiangle-skew", RIGHT_TRIANGLE, 0.5),
    ("quad", "distortion", np.roll(RIGHT_TRIANGLE, 2, axis=0), 1.0),
    ("hexahedron", "scaled-jacobian", [BOX[0], BOX[0], *BOX[2:]], 0.0),
    ("wedge", "scaled-jacobian",
     [*FAMILIES["wedge"].reference[:5], FAMILIES["wedge"].reference[2]], 0.0),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "name", "x", "value"), HAND, ids=["-".join(h[:2]) for h in HAND])
def test_what_vtk_has_wrong_is_right(kind, name, x, value):
    assert VERDICT[kind, name].note
    assert ours(np.array([x], dtype=float), kind, name) == pytest.approx(value, abs=1e-13)
