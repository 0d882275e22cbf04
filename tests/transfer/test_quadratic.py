"""What becomes of arrays on meshes of second order."""

from __future__ import annotations

import numpy as np
import pytest

from meshopt_cli.boundary.policy import Fixed, Slide
from meshopt_cli.mesh.model import Block, Mesh
from support.curved import of_second_order
from support.edits import shaken
from support.meshes import tet_grid, tri_grid
from support.runs import optimized
from support.samples import sample

every_policy = pytest.mark.parametrize("policy", [Fixed(), Slide()], ids=lambda p: p.name)


def quadratic(points):
    x, y, z = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))]).T
    return x * x - 2 * x * y + 3 * y * z + z * z + x - 5


@every_policy
@pytest.mark.parametrize("make", [lambda: shaken(tri_grid(5)), lambda: shaken(tet_grid(4))])
def test_quadratic_fields_stay_exact(make, policy):
    of = of_second_order(make())
    of.point_data = {
        "field": quadratic(of.points),
        "vector": np.column_stack([quadratic(of.points), of.points[:, 0]]),
        "number": np.arange(len(of.points)),
        "single": quadratic(of.points).astype(np.float32),
    }
    result = optimized(of, policy)
    assert list(result.point_data) == list(of.point_data)
    wanted = quadratic(result.points)
    np.testing.assert_allclose(result.point_data["field"], wanted, atol=1e-12)
    np.testing.assert_allclose(result.point_data["vector"][:, 0], wanted, atol=1e-12)
    np.testing.assert_allclose(result.point_data["single"], wanted, atol=1e-5)
    before = dict(zip(map(tuple, of.points.tolist()), of.point_data["number"], strict=True))
    places = list(map(tuple, result.points.tolist()))
    same = [k for k, place in enumerate(places) if place in before]
    assert len(same) < len(places)
    for k in same:
        assert result.point_data["number"][k] == before[places[k]]


def test_data_can_be_dropped():
    of = of_second_order(shaken(tri_grid(5)))
    of.point_data = {"field": quadratic(of.points), "gmsh:dim_tags": np.ones((len(of.points), 2))}
    assert list(optimized(of, with_data=False).point_data) == ["gmsh:dim_tags"]


def test_new_middle_nodes_are_on_the_entities_of_their_cells():
    ball = sample("raw_ball.mesh")
    of = of_second_order(Mesh(ball.points, [Block("tetra", ball.cells)]))
    of.blocks[0].data = {"gmsh:geometrical": np.full(len(of.blocks[0].cells), 7)}
    of.point_data = {"gmsh:dim_tags": np.tile([1, 3], (len(of.points), 1))}
    result = optimized(of)
    tags = result.point_data["gmsh:dim_tags"]
    new = (tags == [3, 7]).all(axis=1)
    assert 0 < new.sum() < len(tags)
    assert (tags[~new] == [1, 3]).all()
