"""The table of elements: nodes, shape functions and their derivatives."""

import numpy as np
import pytest

from meshopt_cli.cells import FAMILIES
from meshopt_cli.elements import ELEMENTS, element_of
from support.elements import grid, in_space, reference

# VTK's pyramid of second order has shape functions of its own: those of a hexahedron drawn
# together at its top, which are not of second order there.
VTK = {
    "triangle": "Triangle", "quad": "Quad", "tetra": "Tetra", "pyramid": "Pyramid",
    "wedge": "Wedge", "hexahedron": "Hexahedron", "triangle6": "QuadraticTriangle",
    "quad6": "QuadraticLinearQuad", "quad8": "QuadraticQuad", "quad9": "BiQuadraticQuad",
    "tetra10": "QuadraticTetra", "wedge12": "QuadraticLinearWedge", "wedge15": "QuadraticWedge",
    "wedge18": "BiQuadraticQuadraticWedge", "hexahedron20": "QuadraticHexahedron",
    "hexahedron24": "BiQuadraticQuadraticHexahedron", "hexahedron27": "TriQuadraticHexahedron",
}  # fmt: skip
every = pytest.mark.parametrize("name", ELEMENTS)


def inner(name):
    """Points inside a cell, where no pyramid has its top."""
    at = grid(name, 5)
    return at[(at > 0.1).all(axis=1)]


@every
def test_each_shape_function_is_one_at_its_node_only(name):
    element = ELEMENTS[name]
    assert element.values(element.nodes) == pytest.approx(np.eye(element.n_nodes), abs=1e-12)


@every
def test_places_between_nodes_are_what_they_are(name):
    at = grid(name, 4)
    assert ELEMENTS[name].values(at) @ reference(name) == pytest.approx(
        in_space(name, at), abs=1e-12
    )


@every
def test_nodes_are_middles_of_corners(name):
    element, places = ELEMENTS[name], reference(name)
    n_corners = FAMILIES[element.family].n_corners
    assert element.n_nodes == n_corners + len(element.middles)
    for place, corners in zip(places[n_corners:], element.middles, strict=True):
        assert place == pytest.approx(places[list(corners)].mean(axis=0))
    assert len(set(map(frozenset, element.middles))) == len(element.middles)


@every
def test_slopes_are_those_of_the_values(name):
    element, at, h = ELEMENTS[name], inner(name), 1e-6
    for axis, slope in enumerate(element.slopes(at)):
        step = np.zeros(at.shape)
        step[:, axis] = h
        if element.is_collapsed:  # x and y are a w and b w; z is 1 - w
            step[:, axis] = h / at[:, 2] if axis < 2 else -h
        change = (element.values(at + step) - element.values(at - step)) / (2 * h)
        assert slope == pytest.approx(change, abs=1e-7)


@every
def test_reference_cells_run_as_their_family_does(name):
    element, places = ELEMENTS[name], reference(name)
    corners = places[FAMILIES[element.family].corners]
    assert (np.linalg.det(corners[:, 1:] - corners[:, :1]) > 0).all()


@every
def test_as_many_nodes_as_the_name_says(name):
    element = ELEMENTS[name]
    number = name.lstrip("abcdefghijklmnopqrstuvwxyz")
    assert element.n_nodes == (int(number) if number else FAMILIES[name].n_corners)
    assert element_of(name, element.n_nodes) is element
    assert element_of(name, element.n_nodes - 1) is None


@pytest.mark.parametrize("name", VTK)
def test_the_shape_functions_are_those_of_vtk(name):
    vtk = pytest.importorskip("vtk")
    cell = getattr(vtk, f"vtk{VTK[name]}")()
    at = inner(name)
    places = np.zeros((len(at), 3))
    places[:, : at.shape[1]] = at * [1, 1, -1] + [0, 0, 1] if name == "pyramid" else at
    for row, values in zip(places, ELEMENTS[name].values(at), strict=True):
        weights = [0.0] * ELEMENTS[name].n_nodes
        cell.InterpolateFunctions(row, weights)
        assert values == pytest.approx(weights, abs=1e-12)


@pytest.mark.parametrize("family", FAMILIES.values(), ids=list(FAMILIES))
def test_one_cell_is_told_as_one(family):
    assert family.counted(1) in ("1 " + family.name, "1 tetrahedron")
    assert family.counted(1200) == f"1,200 {family.plural}"
