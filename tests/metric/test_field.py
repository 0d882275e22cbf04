"""Metrics from arrays: what is accepted, in which order, and who is named when it is none."""

import numpy as np
import pytest

from meshopt_cli.errors import ConfigError
from meshopt_cli.metric.field import MEDIT, VTK, fitted, from_array, matrices, require_definite
from support.metrics import random_tensors

EVERY = np.ones(4, dtype=bool)
SPACE = random_tensors(3, 4, 0.5)
PLANE = random_tensors(2, 4, 0.5)
OF_SPACE = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  # as VTK orders them


def entries(tensors, places):
    return np.array([[m[place] for place in places] for m in tensors])


@pytest.mark.parametrize(
    ("values", "order", "tensors"),
    [
        (entries(SPACE, OF_SPACE), VTK, SPACE),
        (entries(SPACE, ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2))), MEDIT, SPACE),
        (entries(PLANE, ((0, 0), (1, 1), (0, 1))), VTK, PLANE),
        (entries(PLANE, ((0, 0), (0, 1), (1, 1))), MEDIT, PLANE),
        (SPACE.reshape(4, 9), VTK, SPACE),
        (SPACE, MEDIT, SPACE),
        (PLANE.reshape(4, 4), MEDIT, PLANE),
    ],
)
def test_components_stand_where_their_order_says(values, order, tensors):
    metric = from_array(values, EVERY, "m", order)
    assert metric.kind == "tensors"
    assert metric.matrices == pytest.approx(tensors, rel=1e-14)
    assert matrices(metric.values) == pytest.approx(tensors, rel=1e-14)
    if values.shape[1:] in ((3,), (6,)):
        assert ("xx, yy" in metric.source) == (order == VTK)
    again = np.einsum("nki,nkj->nij", metric.maps, metric.maps)
    d = tensors.shape[1]
    assert again[:, :d, :d] == pytest.approx(tensors, rel=1e-12)
    assert np.allclose(np.tril(metric.maps, -1), 0.0)


@pytest.mark.parametrize("shape", [(4,), (4, 1)])
def test_sizes_are_scalars(shape):
    metric = from_array(np.full(shape, 2, dtype=np.float32), EVERY, "h")
    assert (metric.kind, metric.values.dtype) == ("sizes", np.float64)
    assert metric.matrices == pytest.approx(np.tile(np.eye(3) / 4.0, (4, 1, 1)))


@pytest.mark.parametrize(
    ("values", "what"),
    [
        (np.ones(3), "3 rows .*4 vertices"),
        (np.ones((4, 2)), "2 components"),
        (np.array([1.0, np.nan, np.inf, 1.0]), "not finite at vertex 1, vertex 2$"),
        (np.array([1.0, 0.0, -1.0, 1.0]), "not positive at vertex 1, vertex 2$"),
        (np.array([1.0, 1e-200, 1e200, 1.0]), "bounds at vertex 1, vertex 2$"),
        (np.full(4, -1.0), "vertex 0, vertex 1, vertex 2 and 1 more$"),
        (np.tile([1.0, 0.5, 0.2, 1.0], (4, 1)), "not symmetric at vertex 0"),
    ],
)
def test_what_is_no_metric_is_named(values, what):
    with pytest.raises(ConfigError, match=what):
        from_array(values, EVERY, "m", MEDIT)


@pytest.mark.parametrize(
    "tensor",
    [np.diag([1.0, -1.0, 1.0]), np.diag([1.0, 0.0, 1.0]), -np.eye(3), np.zeros((3, 3)),
     np.array([[1.0, 2.0, 0], [2.0, 1.0, 0], [0, 0, 1.0]]), np.diag([1.0, 1e-17, 1.0])],
)  # fmt: skip
def test_tensors_that_are_not_definite_are_named(tensor):
    values = SPACE.copy()
    values[2] = tensor
    metric = from_array(values, EVERY, "m")
    with pytest.raises(ConfigError, match=r"m: a tensor not positive definite at node 3$"):
        require_definite(metric, EVERY, lambda i: f"node {i + 1}")
    used = np.array([True, True, False, True])
    assert require_definite(from_array(values, used, "m"), used).maps[2].tolist() == (
        np.eye(3).tolist()
    )


def test_tensors_beyond_all_bounds():
    values = SPACE * 1e100
    with pytest.raises(ConfigError, match="bounds"):
        require_definite(from_array(values, EVERY, "m"), EVERY)


def test_what_stands_at_points_without_cells_does_not_matter():
    used = np.array([True, False, True, True])
    assert from_array(np.array([1.0, np.nan, 2.0, 3.0]), used, "h").values[1] == 1.0
    tensors = PLANE.reshape(4, 4).copy()
    tensors[1] = np.nan
    for order in (MEDIT, VTK):
        values = tensors[:, [0, 1, 3]]
        found = from_array(values, used, "m", order)
        assert found.values[1].tolist() == [1.0, 0.0, 1.0]


def test_in_the_plane_of_x_and_y_tensors_are_those_of_the_plane():
    """As where a format stores those of the plane among zeros."""
    padded = np.zeros((4, 3, 3))
    padded[:, :2, :2] = PLANE
    metric = fitted(from_array(padded, EVERY, "m"), is_flat=True)
    assert require_definite(metric, EVERY).matrices == pytest.approx(PLANE)
    with pytest.raises(ConfigError, match="not positive definite"):
        require_definite(fitted(from_array(padded, EVERY, "m"), is_flat=False), EVERY)
    with pytest.raises(ConfigError, match="of the plane"):
        fitted(from_array(PLANE, EVERY, "m"), is_flat=False)
