"""A boundary whose edges may be split: no obtuse triangle, and all of it covered as it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli import formats, validity
from meshopt_cli.boundary.policy import Fixed, Split
from meshopt_cli.boundary.splitting import splittable
from meshopt_cli.cli.entry import status_of
from meshopt_cli.errors import EXIT_USAGE, ConfigError
from meshopt_cli.mesh import adjacency
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.tags import REQUIRED
from support.angles import n_obtuse
from support.edits import declaring, halves, shaken, with_regions
from support.invariants import region_volumes
from support.meshes import mesh, tet_grid, tri_grid
from support.runs import optimized
from support.settings import examples


def split(one, **request):
    return optimized(one, Split(), passes=("nonobtuse",), **request)


def convex(n, seed):
    """A convex polygon of n corners, in triangles around the first; each side has a tag."""
    random = np.random.default_rng(seed)
    gaps = 1.0 + random.uniform(0.0, 1.0, n)
    angle = random.uniform(0.0, 7.0) + 2.0 * np.pi * np.cumsum(gaps) / gaps.sum()
    wide, high = random.uniform(0.4, 1.0, 2)
    points = np.stack([wide * np.cos(angle), high * np.sin(angle), 0.0 * angle], axis=1)
    fan = np.stack([np.zeros(n - 2, int), np.arange(1, n - 1), np.arange(2, n)], axis=1)
    return sides_declared(mesh(points, triangle=fan))


def sides_declared(one):
    """A mesh whose borders are declared, each edge with a tag of its own."""
    edges = adjacency.distinct_rows(np.sort(cast(one).skin, axis=1))[0]
    made = declaring(one, line=edges)
    lines = replace(made.blocks[0], data={"medit:ref": 10 + np.arange(len(edges))})
    return replace(made, blocks=[lines, *made.blocks[1:]])


def polygon(points):
    """Triangles around the first point of a list."""
    points = np.column_stack([np.array(points, float), np.zeros(len(points))])
    n = len(points)
    return mesh(points, triangle=[[0, k, k + 1] for k in range(1, n - 1)])


RECTANGLE = polygon([(2, 1), (0, 1), (0, 0), (3, 0), (7, 0), (7, 1)])
# The corner that all triangles see is the one that points inwards.
ANGLE = polygon([(1, 1), (0, 3), (0, 0), (4, 0), (4, 1)])


def assert_covered(before, after):
    """What was declared is the union of what is declared now with the same tag, in its places."""
    (old,) = (b for b in before.blocks if b.type == "line")
    (new,) = (b for b in after.blocks if b.type == "line")
    skin = np.sort(cast(after).skin, axis=1)
    assert {tuple(row) for row in np.sort(new.cells, axis=1)} == {tuple(row) for row in skin}
    for (a, b), tag in zip(old.cells, old.data["medit:ref"], strict=True):
        start, along = before.points[a], before.points[b] - before.points[a]
        parts = after.points[new.cells[new.data["medit:ref"] == tag]] - start
        where = parts @ along / (along @ along)
        off = parts - where[..., None] * along
        assert np.abs(off).max() <= 1e-12 * np.abs(before.points).max()
        assert where.min() == pytest.approx(0.0, abs=1e-15)
        assert np.all(where[:, 1] > where[:, 0])  # in the direction that it was declared in
        assert np.sum(where[:, 1] - where[:, 0]) == pytest.approx(1.0, abs=1e-12)
        assert where.max() == pytest.approx(1.0, abs=1e-12)


def assert_right(before, after):
    part, source = cast(after), cast(before)
    assert n_obtuse(part.points, part.cells) == 0
    assert validity.check(after).is_valid
    np.testing.assert_allclose(region_volumes(part), region_volumes(source), rtol=1e-12)
    assert_covered(before, after)


@examples(12)
@given(st.integers(4, 9), st.integers(0, 2**32 - 1))
def test_no_convex_polygon_stays_obtuse(n, seed):
    before = convex(n, seed)
    assert_right(before, split(before))


@pytest.mark.parametrize("one", [RECTANGLE, ANGLE], ids=["rectangle", "angle"])
def test_polygons(one):
    before = sides_declared(one)
    after = split(before)
    assert_right(before, after)
    assert len(after.points) <= 3 * len(before.points)


@pytest.mark.parametrize("single", [False, True])
def test_both_sides_of_an_interface_are_split_at_once(single):
    """Two regions, which only their interface and few vertices keep obtuse."""
    flat = polygon([(0, 0), (5, -1), (6, 0.3), (4, 1.1), (1, 1)])
    before = sides_declared(with_regions(flat, np.array([0, 0, 1])))
    if single:
        before = replace(before, points=before.points.astype(np.float32))
    after = split(before)
    assert after.points.dtype == before.points.dtype
    if not single:
        assert_right(before, after)
    np.testing.assert_allclose(
        region_volumes(cast(after)), region_volumes(cast(before)), rtol=1e-6 if single else 1e-12
    )


def test_arrays_go_along():
    """A linear one on the points is found on new ones, too."""
    before = convex(7, 3)
    values = before.points @ [1.0, 2.0, 0.0]
    after = split(replace(before, point_data={"height": values}))
    assert len(after.points) > len(before.points)
    np.testing.assert_allclose(
        after.point_data["height"], after.points @ [1.0, 2.0, 0.0], atol=1e-9
    )


def test_vertices_of_the_boundary_stay_bit_for_bit():
    before = convex(8, 5)
    after = split(before)
    assert {p.tobytes() for p in before.points} <= {p.tobytes() for p in after.points}


def test_what_must_stay_is_not_split():
    before = convex(7, 3)
    lines = before.blocks[0]
    required = np.arange(len(lines.cells)) % 2
    lines = replace(lines, data={**lines.data, REQUIRED: required})
    before = replace(before, blocks=[lines, *before.blocks[1:]])
    allowed = {tuple(row) for row in np.sort(splittable(before, cast(before)), axis=1)}
    assert allowed == {tuple(row) for row in lines.cells[required == 0]}
    after = split(before)
    kept = after.blocks[0].cells[after.blocks[0].data[REQUIRED] == 1]
    assert len(kept) == np.count_nonzero(required)


def test_a_fine_mesh_ends_with_fewer_than_with_its_boundary_fixed():
    before = sides_declared(halves(shaken(tri_grid(8), 0.6, 2)))
    counts = []
    for policy in (Fixed(), Split()):
        part = cast(optimized(before, policy, passes=("nonobtuse",)))
        counts.append(n_obtuse(part.points, part.cells))
    assert counts[1] <= counts[0]
    assert counts[1] == 0


def test_the_same_every_time():
    one, other = (split(convex(7, 3)) for _ in range(2))
    assert one.points.tobytes() == other.points.tobytes()


def test_time_that_is_up_leaves_a_whole_mesh():
    before = convex(9, 4)
    after = split(before, time_limit=0.0)
    assert validity.check(after).is_valid


def test_meshes_in_space_are_refused():
    with pytest.raises(ConfigError, match="triangles of a plane"):
        split(tet_grid(1))


def test_a_run_that_would_not_split_is_refused(tmp_path, capsys):
    path = tmp_path / "in.vtu"
    formats.write(path, RECTANGLE, formats.FORMATS["vtu"].default)
    out = tmp_path / "out.vtu"
    arguments = ["optimize", str(path), str(out), "--boundary", "split"]
    assert status_of(arguments) == EXIT_USAGE
    (said,) = capsys.readouterr().err.splitlines()
    assert "nonobtuse" in said
    assert not out.exists()
