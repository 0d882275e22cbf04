"""What is planar: `check` and `optimize` are of one mind, to the last digit."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshopt_cli import formats
from meshopt_cli.cli.entry import status_of
from meshopt_cli.errors import UnsupportedMeshError
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.plane import plane_of, precision_of
from meshopt_cli.validity import check
from meshopt_cli.validity.examination import Examination
from support.meshes import in_space, mesh, octahedron, quad_grid, tri_grid

TOLERANCE = 1e-6  # part of the extent, in double precision
INCLINED = [0.36, 0.48, 0.8]


def rotation(normal):
    """A rotation that brings the axis z to a direction."""
    z = np.array(normal) / np.linalg.norm(normal)
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def placed(flat, heights, normal=(0, 0, 1), shift=0.0, dtype=float):
    """A mesh of the plane laid into space, its points off the plane by some heights."""
    placed = in_space(flat, heights)
    placed.points = (placed.points @ rotation(normal).T + shift).astype(dtype)
    return placed


def corners_off(n, deviation):
    """Heights of the points of a grid, of which the corners only are off the plane."""
    heights = np.zeros((n + 1, n + 1))
    heights[0, 0] = heights[-1, -1] = deviation
    heights[0, -1] = heights[-1, 0] = -deviation
    return heights.ravel()


def with_two_turned(flat):
    """Two cells inside run the other way round."""
    cells = flat.blocks[0].cells
    inside = [len(cells) // 2, len(cells) // 3]
    cells[inside] = cells[inside][:, ::-1]
    return flat


def tangled(flat):
    """An inner vertex lies beyond its ball, so that cells are inverted that agree on all edges."""
    n = round(len(flat.points) ** 0.5) - 1
    flat.points[(n // 2) * (n + 2)] += 1.5 / n, 0.1 / n
    return flat


def is_planar(of):
    return Examination(of).plane is not None


def can_be_cast(of):
    try:
        cast(of)
    except UnsupportedMeshError:
        return False
    return True


@pytest.mark.parametrize("spoilt", [tangled, with_two_turned])
@pytest.mark.parametrize("normal", [INCLINED, [0, 0, 1], [1, 0, 0], [0, -1, 0]])
@pytest.mark.parametrize("deviation", [0.0, 0.4 * TOLERANCE, 0.8 * TOLERANCE])
def test_inverted_triangles_on_a_nearly_flat_plane_are_found(spoilt, normal, deviation, tmp_path):
    of = placed(spoilt(tri_grid(6)), corners_off(6, deviation), normal)
    found = {group.code: len(group) for group in check(of).errors}
    assert found.get("M101") == 2
    path = tmp_path / "tilted.vtu"
    formats.write(path, of, formats.encoding_for(path))
    assert status_of(["check", "-q", str(path)]) == 1


@pytest.mark.parametrize("kind", [tri_grid, quad_grid])
@pytest.mark.parametrize("spoilt", [tangled, with_two_turned])
@pytest.mark.parametrize("normal", [[0, 0, 1], [0, 0, -1], [1, 0, 0], INCLINED])
def test_the_same_is_found_whatever_the_deviation(kind, spoilt, normal):
    flat, nearly = (
        placed(spoilt(kind(6)), corners_off(6, deviation), normal)
        for deviation in (0.0, 0.8 * TOLERANCE)
    )
    assert check(flat).codes == check(nearly).codes
    assert not check(flat).is_valid


def test_quads_that_run_clockwise_are_negative_on_a_nearly_flat_plane_too():
    of = placed(quad_grid(3), corners_off(3, 0.8 * TOLERANCE))
    of.blocks[0].cells = of.blocks[0].cells[:, ::-1]
    assert "M101" in check(of).codes


@pytest.mark.parametrize("normal", [INCLINED, [0, 0, 1], [1, 0, 0]])
@pytest.mark.parametrize("deviation", [1.2 * TOLERANCE, 3 * TOLERANCE, 1e-3])
def test_a_surface_that_is_nearly_flat_is_none_for_either(normal, deviation):
    of = placed(tri_grid(6), corners_off(6, deviation), normal)
    assert not is_planar(of)
    assert not can_be_cast(of)
    assert check(of).is_valid


@pytest.mark.parametrize("normal", [INCLINED, [0, 0, 1]])
@pytest.mark.parametrize("shift", [0.0, 1e3, 1e6, 1e9])
def test_far_from_the_origin(normal, shift):
    """Coordinates are rounded more coarsely there than the plane is flat."""
    of = placed(with_two_turned(tri_grid(6)), 0.0, normal, shift * np.array([1.0, -0.3, 0.7]))
    assert is_planar(of)
    assert can_be_cast(of)
    assert {group.code: len(group) for group in check(of).errors}.get("M101") == 2


@pytest.mark.parametrize("normal", [INCLINED, [0, 0, 1]])
@pytest.mark.parametrize(("deviation", "planar"), [(8e-6, True), (2e-5, False)])
def test_single_precision(normal, deviation, planar):
    of = placed(tri_grid(6), corners_off(6, deviation), normal, dtype=np.float32)
    assert is_planar(of) == can_be_cast(of) == planar


def test_a_closed_surface_is_not_planar():
    assert not is_planar(octahedron())
    assert not can_be_cast(octahedron())


heights = st.floats(-4, 4, allow_nan=False).map(lambda x: x * TOLERANCE)


@given(
    st.lists(heights, min_size=16, max_size=16),
    st.tuples(*[st.floats(-1, 1)] * 3),
    st.sampled_from([0.0, 1.0, 1e2, 1e5]),
    st.sampled_from([np.float64, np.float32]),
    st.integers(-60, 60),
)
def test_check_and_optimize_agree(heights, normal, shift, dtype, power):
    """For any heights around the tolerance, any place, size and precision."""
    assume(np.linalg.norm(normal) > 0.1)
    of = placed(tri_grid(3), np.array(heights), normal, shift)
    of.points = np.ldexp(of.points, power).astype(dtype)
    assert is_planar(of) == can_be_cast(of)


def test_flat_cells_lie_in_the_plane_that_an_axis_is_normal_to():
    on_a_line = mesh([[0, 0, 2], [1, 0, 2], [2, 0, 2], [3, 0, 2]], triangle=[[0, 1, 2], [1, 2, 3]])
    assert is_planar(on_a_line)
    assert "M102" in check(on_a_line).codes


@pytest.mark.parametrize("normal", [[0, 0, 1], [0, 0, -1], [0, 1, 0], [-1, 0, 0], INCLINED])
def test_upright_is_as_seen_from_the_axis(normal):
    of = placed(tri_grid(3), 0.0, normal, 5.0)
    frame = plane_of(of.points, of.blocks[0].cells, precision_of(of.points))
    upright = frame.upright()
    axis = int(np.argmax(np.abs(upright.axes[2])))
    assert upright.axes[2, axis] > 0
    np.testing.assert_allclose(upright.axes @ upright.axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(upright.axes) > 0
    assert upright.normal_axis == (-1 if normal is INCLINED else axis)
    flat = upright.flatten(of.points)
    if upright.is_exact:
        assert {tuple(column) for column in flat[:, :2].T} <= {tuple(c) for c in of.points.T}
    np.testing.assert_allclose(upright.unflatten(of.points, flat), of.points, atol=1e-14)
