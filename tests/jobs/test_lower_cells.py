"""Beams and shells beside the cells that are worked on come out as they went in."""

import numpy as np
import pytest

from meshopt_cli.boundary.policy import Fixed, Slide
from meshopt_cli.errors import UnsupportedMeshError
from meshopt_cli.mesh.cast import cast
from meshopt_cli.mesh.model import Block, Mesh, main_type
from support.edits import declaring
from support.held import counts, optimized_as, places_of, shaken_where_free
from support.kinds import plate_with_beam, solid_with_fin
from support.meshes import in_space, mesh, tet_grid, tri_grid


def second_order(of, kind, row):
    """A mesh with the cells of a block of lower dimension as such of second order."""
    block = of.blocks[row]
    ends = {"line": [[0, 1]], "triangle": [[0, 1], [1, 2], [2, 0]]}[block.type]
    edges = np.sort(block.cells[:, ends].reshape(-1, 2), axis=1)
    edges, number = np.unique(edges, axis=0, return_inverse=True)
    middles = of.points[edges].mean(axis=1)
    number = len(of.points) + number.reshape(len(block.cells), -1)
    blocks = list(of.blocks)
    blocks[row] = Block(kind, np.concatenate([block.cells, number], axis=1))
    return Mesh(np.concatenate([of.points, middles]), blocks)


def strut(of, vertex, *away):
    """A mesh with a line from one of its vertices to a point of its own."""
    tip = of.points[vertex] + np.array(away)
    lines = Block("line", np.array([[vertex, len(of.points)]]))
    return Mesh(np.vstack([of.points, tip]), [*of.blocks, lines])


INSIDE = 31  # a vertex inside tet_grid(4)
MIXED = {
    "beam on a plate": (plate_with_beam(6, 3), ["line"]),
    "beam on a plate, of second order": (second_order(plate_with_beam(6, 3), "line3", 1),
                                         ["line3"]),
    "beam from inside a plate": (strut(in_space(tri_grid(6)), 24, 0, 0, 1), ["line"]),
    "fin on a solid": (solid_with_fin(4), ["triangle"]),
    "fin of quads": (solid_with_fin(4, "quad"), ["quad"]),
    "fin of second order": (second_order(solid_with_fin(4), "triangle6", 1), ["triangle6"]),
    "beam from inside a solid": (strut(tet_grid(4), INSIDE, 5, 5, 5), ["line"]),
    "shell of quads inside a solid": (
        declaring(tet_grid(4), quad=[[62, 63, 68, 67], [63, 64, 69, 68]]), ["quad"]),
    "facets inside of second order": (
        second_order(declaring(tet_grid(4), triangle=tet_grid(4).blocks[0].cells[100:104, :3]),
                     "triangle6", 0), ["triangle6"]),
}  # fmt: skip


@pytest.mark.parametrize("policy", [Fixed(), Slide()], ids=lambda policy: policy.name)
@pytest.mark.parametrize("name", MIXED)
def test_lower_cells_are_kept_to_the_bit(name, policy):
    of, kinds = MIXED[name]
    of = shaken_where_free(of, 0.03)
    result = optimized_as(of, policy)
    for kind in kinds:
        assert len(places_of(of, kind))
        assert places_of(result.mesh, kind) == places_of(of, kind)
    assert counts(result.mesh) == counts(of)
    assert result.after.worst < result.before.worst
    # No point of theirs is gone, and none is there twice.
    assert len(np.unique(result.mesh.points, axis=0)) == len(result.mesh.points)


@pytest.mark.parametrize("name", MIXED)
def test_their_vertices_are_fixed(name):
    of, kinds = MIXED[name]
    source = cast(of)
    held = source.fixed.copy()
    held[source.skin] = held[source.edges] = True
    for block in of.blocks:
        if block.type in kinds:
            assert held[block.cells].all()


def test_arrays_on_them_come_along():
    of = shaken_where_free(plate_with_beam(6, 3), 0.03)
    of.blocks[1].data["section"] = np.array([0.25, 0.5, 0.75])
    of.blocks[1].data["medit:ref"] = np.array([7, 8, 9])
    of.point_data["load"] = np.arange(len(of.points), dtype=float)
    result = optimized_as(of).mesh
    (line,) = [block for block in result.blocks if block.type == "line"]
    assert line.data["section"].tolist() == [0.25, 0.5, 0.75]
    assert line.data["medit:ref"].tolist() == [7, 8, 9]
    assert result.point_data["load"][line.cells[1:]].tolist() == (
        of.point_data["load"][of.blocks[1].cells[1:]].tolist()
    )


def test_cells_of_the_same_dimension_are_still_refused():
    of = declaring(tet_grid(1), pyramid=[[0, 1, 3, 2, 4]])
    with pytest.raises(UnsupportedMeshError, match="pyramid"):
        main_type(of)
    assert main_type(declaring(tet_grid(1), line3=[[0, 1, 2]], quad=[[0, 1, 3, 2]])) == "tetra"
    with pytest.raises(UnsupportedMeshError, match="quad"):
        main_type(mesh(np.eye(4, 3), triangle=[[0, 1, 2]], quad=[[0, 1, 2, 3]]))
