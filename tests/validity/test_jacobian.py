"""The Jacobian of cells: proven positive, or the cell is named (M105)."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from meshopt_cli.elements import ELEMENTS
from meshopt_cli.mesh.model import Block, Mesh
from meshopt_cli.validity import check
from meshopt_cli.validity.examination import Examination
from meshopt_cli.validity.jacobian import (
    AT_CORNER,
    INSIDE,
    jacobians,
    not_looked_at,
    not_positive,
    table_of,
)
from support.elements import (
    BENT,
    HEXAHEDRA,
    SOLIDS,
    middles_of,
    one,
    reference,
    sampled,
    shaken,
)
from support.meshes import hex_grid, mesh, tet_grid
from support.settings import examples

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(BENT)
TRIANGLE = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
TET = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]


def codes(of):
    return check(of, select=["M1"]).codes


def found(of):
    """What is found, with no cell left out."""
    study = Examination(of)
    return not_positive(study, np.zeros(study.n_cells, dtype=bool))


def rotation(dimension, generator):
    turned = np.linalg.qr(generator.normal(size=(dimension, dimension)))[0]
    return turned * [*[1] * (dimension - 1), np.sign(np.linalg.det(turned))]


def with_middle(t, name="triangle6"):
    """A straight cell, but for its first middle node, which is at a part of its edge."""
    nodes = middles_of(name, TRIANGLE if name == "triangle6" else TET)
    nodes[len(nodes) - len(ELEMENTS[name].middles), 0] = t
    return nodes


@examples(80)
@given(kinds, seeds)
def test_straight_cells_are_valid(name, seed):
    """Of any shape and in any place, also where a line of theirs is all but flat."""
    generator = np.random.default_rng(seed)
    d = ELEMENTS[name].nodes.shape[1]
    stretch = np.diag(10.0 ** generator.uniform(-4, 2, d))
    by = rotation(d, generator) @ stretch @ rotation(d, generator)
    points = reference(name) @ by.T + generator.normal(size=d)
    assert codes(one(name, points)) == ()


@examples(150)
@given(kinds, seeds, st.floats(0.05, 0.45))
def test_cells_are_named_where_samples_are_negative(name, seed, amount):
    points = shaken(name, amount, seed)
    values = sampled(name, points)
    named = found(one(name, points))
    corners = np.linalg.det(points[_corner(name)] - points[[0]])
    values = values * np.sign(corners)
    if values.min() <= 0:
        assert len(named.numbers)
    if len(named.numbers):
        # A sample may miss the least value by what it changes from one to the next.
        assert values.min() < 0.1 * np.abs(values).max()
        assert named.ratio[0] <= 1e-10


def _corner(name):
    """The neighbours of corner 0 along the edges, positive in a valid cell."""
    return {
        "triangle": [1, 2], "quad": [1, 3], "tetra": [1, 2, 3], "pyramid": [1, 3, 4],
        "wedge": [1, 2, 3], "hexahedron": [1, 3, 4],
    }[ELEMENTS[name].family]  # fmt: skip


@examples(60)
@given(kinds, seeds, st.floats(0.05, 0.4))
def test_bounds_hold_all_samples(name, seed, amount):
    element, points = ELEMENTS[name], shaken(name, amount, seed)
    table = table_of(name)
    values = jacobians(table, element, points.T[None] - points[0][:, None])
    coefficients = table.basis.coefficients(values)
    seen = sampled(name, points)
    seen = seen * np.sign(np.linalg.det(points[_corner(name)] - points[[0]]))
    size = 1e-9 * np.abs(coefficients).max()
    assert coefficients.min() - size <= seen.min()
    assert seen.max() <= coefficients.max() + size


@examples(60)
@given(kinds, seeds, st.floats(0.05, 0.4), st.floats(-60, 60), st.booleans())
def test_scale_and_direction_do_not_matter(name, seed, amount, power, far):
    points = shaken(name, amount, seed)
    before = found(one(name, points))
    generator = np.random.default_rng(seed)
    turned = points @ rotation(points.shape[1], generator).T
    after = found(one(name, 10.0**power * (turned + 10.0 * far)))
    assume(not len(before.ratio) or before.ratio[0] < -1e-6)
    assert before.numbers.tolist() == after.numbers.tolist()
    assert before.kinds.tolist() == after.kinds.tolist()
    assert before.ratio == pytest.approx(after.ratio, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("name", ["triangle6", "tetra10"])
@pytest.mark.parametrize(
    ("t", "valid"),
    [(0.5, True), (0.26, True), (0.2501, True), (0.25 + 1e-8, True), (0.25, False), (0.24, False),
     (0.05, False), (0.7499, True), (0.75, False), (1.1, False)],
)  # fmt: skip
def test_middle_nodes_stay_within_the_middle_half_of_their_edge(name, t, valid):
    assert codes(one(name, with_middle(t, name))) == (() if valid else ("M105",))


def test_swapped_middle_nodes():
    for name, corners in (("triangle6", TRIANGLE), ("tetra10", TET)):
        nodes = middles_of(name, corners)
        nodes[[-1, -2]] = nodes[[-2, -1]]
        assert codes(one(name, nodes)) == ("M105",)


@pytest.mark.parametrize("where", HEXAHEDRA)
def test_hexahedra_whose_corners_are_positive(where):
    points = HEXAHEDRA[where] / 10
    assert sampled("hexahedron", points, 1).min() > 0
    assert check(one("hexahedron", points), ignore=["M105"]).is_valid
    named = found(one("hexahedron", points))
    assert named.kinds.tolist() == [INSIDE]
    assert named.ratio[0] == pytest.approx(sampled("hexahedron", points, 20).min()
                                           / np.abs(sampled("hexahedron", points, 20)).max(),
                                           abs=0.1)  # fmt: skip
    (group,) = check(one("hexahedron", points)).groups
    assert group.code == "M105"
    assert "inside the cell" in group.findings(one("hexahedron", points))[0].message


def test_what_lies_inside_is_found_in_every_solid():
    """Cells at random whose corners are positive, but not all that is between."""
    for name in SOLIDS:
        n_found = 0
        for seed in range(4000):
            points = shaken(name, 0.55, seed)
            corners = table_of(name).basis.corners
            values = jacobians(table_of(name), ELEMENTS[name], points.T[None])[0]
            if values[corners].min() > 0 > values.min():
                named = found(one(name, points))
                assert named.kinds.tolist() == [INSIDE], name
                n_found += 1
                if n_found == 3:
                    break
        assert n_found == 3, name


def test_pyramids_and_plane_quads_of_first_order_are_decided_by_their_corners():
    """The reason why they are left out: no Jacobian between is less than all at the corners."""
    for name in ("pyramid", "quad"):
        for seed in range(200):
            values = sampled(name, shaken(name, 0.6, seed), 8)
            at_corners = sampled(name, shaken(name, 0.6, seed), 1)
            assert values.min() == pytest.approx(at_corners.min(), abs=1e-12)


def test_the_way_a_mesh_runs_is_no_matter_of_jacobians():
    nodes = middles_of("triangle6", TRIANGLE)
    clockwise = mesh(nodes, triangle6=[[0, 2, 1, 5, 4, 3]])
    assert codes(clockwise) == ()
    of = hex_grid(2)
    turned = Mesh(of.points, [Block("hexahedron", of.blocks[0].cells[:, [4, 5, 6, 7, 0, 1, 2, 3]])])
    assert codes(turned) == ("M103",)


def test_what_other_rules_name_is_not_named_again():
    nodes = middles_of("tetra10", TET)
    inverted = mesh(nodes, tetra10=[range(10), [1, 0, 2, 3, *range(4, 10)]])
    assert "M101" in codes(inverted)
    assert "M105" not in codes(inverted)
    flat = middles_of("tetra10", [*TET[:3], (0.3, 0.3, 0.0)])
    assert codes(one("tetra10", flat)) == ("M102",)


def thin(seed, height, far, kind):
    """A straight tetrahedron of second order, as thin as is told, and stored in some precision."""
    generator = np.random.default_rng(seed)
    corners = generator.uniform(size=(4, 3))
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    corners[3] = corners[:3].mean(axis=0) + height * normal / np.linalg.norm(normal)
    of = one("tetra10", middles_of("tetra10", (corners + far).astype(kind)).astype(kind))
    of.points = of.points.astype(kind)
    return of


@examples(60)
@given(
    seeds, st.floats(-12, 0), st.sampled_from([np.float32, np.float64]), st.sampled_from([0, 10])
)
def test_straight_tets_that_corners_allow_are_valid(seed, power, kind, far):
    of = thin(seed, 10.0**power, far, kind)
    assume(check(of, select=["M101", "M102", "M103"]).is_valid)
    assert codes(of) == ()


@pytest.mark.parametrize(("kind", "far"), [(np.float32, 10.0), (np.float64, 1e7)])
def test_rounding_of_middle_nodes_proves_nothing(kind, far):
    """Cells hardly thicker than rounding, with middle nodes off by the last digit."""
    n_allowed = n_negative = 0
    for seed in range(200):
        noise = 4 * np.finfo(kind).eps * (far + 1)
        of = thin(seed, noise * (1 + seed / 200), far, kind)
        if not check(of, select=["M101", "M102", "M103"]).is_valid:
            continue
        towards = np.random.default_rng(seed).choice([-np.inf, np.inf], (6, 3))
        of.points[4:] = np.nextafter(of.points[4:], towards.astype(kind), dtype=kind)
        points = of.points.astype(float)
        n_allowed += 1
        n_negative += sampled("tetra10", points - points[0]).min() <= 0
        assert codes(of) == ()
    assert n_allowed > 100
    assert n_negative > 10


def shell(name, angle):
    """A cell of the unit sphere, or of a shell of it, that spans an angle along both sides."""
    at = ELEMENTS[name].nodes
    u, v = (at[:, 0] - 0.5) * angle, (at[:, 1] - 0.5) * angle
    ball = np.stack([np.sin(u) * np.cos(v), np.sin(v), np.cos(u) * np.cos(v)], axis=1)
    return ball * (1 + 0.3 * at[:, [2]]) if at.shape[1] == 3 else ball


@pytest.mark.parametrize("name", ["triangle6", "quad8", "quad9", "wedge15", "wedge18",
                                  "hexahedron20", "hexahedron27"])  # fmt: skip
def test_strongly_curved_cells_are_valid(name):
    assert codes(one(name, shell(name, 1.2))) == ()


def sphere(name):
    """The faces of an octahedron or of a cube, all nodes moved onto a sphere."""
    if ELEMENTS[name].family == "triangle":
        cells = [middles_of(name, np.diag(signs)) for signs in product((1, -1), repeat=3)]
    else:
        square = np.column_stack([2 * ELEMENTS[name].nodes - 1, np.ones(ELEMENTS[name].n_nodes)])
        cells = [
            np.roll(square * [1, 1, side], axis, axis=1) for side in (1, -1) for axis in range(3)
        ]
    points = np.concatenate(cells)
    points /= np.linalg.norm(points, axis=1)[:, None]
    return mesh(points, **{name: np.arange(len(points)).reshape(len(cells), -1)})


faces = pytest.mark.parametrize("name", ["triangle6", "quad8", "quad9"])


@faces
def test_large_faces_of_a_sphere_are_valid(name):
    of = sphere(name)
    assert Examination(of).plane is None
    assert codes(of) == ()


@faces
def test_faces_that_are_folded(name):
    of = sphere(name)
    first = ELEMENTS[name].n_nodes - len(ELEMENTS[name].middles)
    of.points[first] = 0.95 * of.points[0] + 0.05 * of.points[1]
    named = found(of)
    assert named.numbers.tolist() == [0]
    assert named.kinds.tolist() == [AT_CORNER]


@faces
def test_faces_whose_middle_nodes_run_the_other_way(name):
    """Against the corners: such a face is negative but around its middle."""
    of = sphere(name)
    first = ELEMENTS[name].n_nodes - len(ELEMENTS[name].middles)
    n = 3 if name == "triangle6" else 4
    of.blocks[0].cells[1, first : first + n] = np.roll(of.blocks[0].cells[1, first : first + n], 1)
    assert found(of).numbers.tolist() == [1]


def test_quads_in_space_that_are_not_convex():
    dart = [[0, 0, 0], [1, 0, 0.1], [0.2, 0.2, 0], [0, 1, 0.1]]
    assert codes(one("quad", dart)) == ("M105",)
    warped = [[0, 0, 0], [1, 0, 1], [1, 1, 0], [0, 1, 1]]
    assert codes(one("quad", warped)) == ()


VTK_CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1),
               (0, 1, 1)]  # fmt: skip


def exact_hexahedron(points, at):
    """The Jacobian of a hexahedron with whole coordinates at a rational place, by fractions."""
    rows = []
    for axis in range(3):
        row = [Fraction(0)] * 3
        for corner, point in zip(VTK_CORNERS, points.tolist(), strict=True):
            weight = Fraction(1 if corner[axis] else -1)
            for other in {0, 1, 2} - {axis}:
                weight *= at[other] if corner[other] else 1 - at[other]
            row = [r + weight * x for r, x in zip(row, point, strict=True)]
        rows.append(row)
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


@examples(15)
@given(seeds)
@example(0)
def test_hexahedra_by_exact_arithmetic(seed):
    """Whatever is named is not positive, and whatever is not is, on a grid of exact places."""
    generator = np.random.default_rng(seed)
    points = np.array(VTK_CORNERS) * 8 + generator.integers(-5, 6, (8, 3))
    least = min(
        exact_hexahedron(points, at) for at in product([Fraction(k, 8) for k in range(9)], repeat=3)
    )
    assume(exact_hexahedron(points, (0, 0, 0)) > 0)
    named = found(one("hexahedron", points))
    if least <= 0:
        assert len(named.numbers)
    if len(named.numbers):
        assert least < 8**3 / 4


@examples(40)
@given(st.fractions(-1, 2, max_denominator=50), st.fractions(-1, 1, max_denominator=50))
def test_triangles_by_their_formula(s, t):
    """With its first middle node at (s, t) the Jacobian is 1 + (4 s - 2)(1 - 2 x - y) - 4 t x:
    its least value is at a corner."""
    nodes = middles_of("triangle6", TRIANGLE)
    nodes[3] = float(s), float(t)
    least = min(1 + (4 * s - 2) * (1 - 2 * x - y) - 4 * t * x for x, y in [(0, 0), (1, 0), (0, 1)])
    assume(least != 0)
    assert codes(one("triangle6", nodes)) == (() if least > 0 else ("M105",))


def test_cells_with_nodes_that_are_nowhere_are_left_to_other_rules():
    nodes = middles_of("tetra10", TET)
    nodes[7] = np.nan
    assert check(one("tetra10", nodes)).codes == ("M001",)
    of = one("tetra10", middles_of("tetra10", TET))
    of.blocks[0].cells[0, 9] = 77
    assert check(of).codes == ("M002", "M203")


def test_types_that_are_not_looked_at_are_counted():
    of = tet_grid(1)
    of.blocks += [Block("tetra20", np.zeros((3, 20), np.int64)),
                  Block("tetra20", np.zeros((2, 20), np.int64)),
                  Block("polyhedron8", np.zeros((1, 8), np.int64)),
                  Block("triangle10", np.zeros((1, 10), np.int64))]  # fmt: skip
    assert not_looked_at(of) == {"tetra20": 5, "polyhedron8": 1}
    assert not_looked_at(hex_grid(1)) == {}
