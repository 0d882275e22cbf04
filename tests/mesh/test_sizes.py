"""Contents, fluxes and angles of cells of every family."""

import math
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.cells import FAMILIES
from meshopt_cli.mesh.sizes import (
    CHUNK,
    angles_between,
    area_vectors,
    contents,
    dihedral_angles,
    facet_normals,
    flux,
    norms,
    unfolded,
)

PLANE, SOLIDS = ([f for f in FAMILIES.values() if f.dimension == d] for d in (2, 3))
families = st.sampled_from(PLANE + SOLIDS)
seeds = st.integers(0, 2**32 - 1)
solid = pytest.mark.parametrize("family", SOLIDS, ids=lambda f: f.name)


def rotation(random):
    matrix, _ = np.linalg.qr(random.normal(size=(3, 3)))
    return matrix * np.sign(np.linalg.det(matrix))


def one(family):
    return np.arange(family.n_corners)[None]


@given(families, seeds)
def test_content_is_that_of_a_partition(family, seed):
    """Of an affine image, whose faces are plane, so that all partitions have one content."""
    random = np.random.default_rng(seed)
    d = family.dimension
    image = family.reference[:, :d] @ random.normal(size=(d, d)) + random.normal(size=d)
    content = contents(image, one(family), family.name)[0]
    for way in family.partitions:
        parts = np.linalg.det(image[way[:, 1:]] - image[way[:, :1]]) / math.factorial(d)
        assert content == pytest.approx(parts.sum(), rel=1e-9, abs=1e-12)


@given(families, seeds)
def test_content_is_what_the_facets_enclose(family, seed):
    """Also of warped faces, and wherever the origin is."""
    random = np.random.default_rng(seed)
    points = family.reference + random.normal(scale=0.2, size=family.reference.shape)
    points = points[:, : family.dimension] + random.normal(size=family.dimension)
    enclosed = sum(flux(points[table]).sum() for table in family.facets)
    assert contents(points, one(family), family.name)[0] == pytest.approx(enclosed, abs=1e-12)


@given(families, seeds)
def test_content_changes_its_sign_with_the_orientation(family, seed):
    points = family.reference + np.random.default_rng(seed).normal(scale=0.1, size=(1, 3))
    mirrored = points * [-1.0, 1.0, 1.0]
    d = family.dimension
    content = contents(points[:, :d], one(family), family.name)
    assert content[0] > 0
    np.testing.assert_allclose(contents(mirrored[:, :d], one(family), family.name), -content)


@pytest.mark.parametrize("family", PLANE, ids=lambda f: f.name)
@given(seed=seeds)
def test_areas_in_space_are_those_in_the_plane(family, seed):
    random = np.random.default_rng(seed)
    points = family.reference + random.normal(scale=0.1, size=family.reference.shape) * [1, 1, 0]
    tilted = points @ rotation(random).T
    flat = contents(points[:, :2], one(family), family.name)
    np.testing.assert_allclose(contents(tilted, one(family), family.name), abs(flat), rtol=1e-12)
    np.testing.assert_allclose(norms(area_vectors(tilted, one(family))), 2 * abs(flat), rtol=1e-12)


@pytest.mark.parametrize("name", ["tetra", "hexahedron"])
def test_contents_of_more_cells_than_a_chunk(name):
    family = FAMILIES[name]
    cells = np.repeat(one(family), CHUNK + 3, axis=0)
    content = contents(family.reference, cells, name)
    assert content.shape == (CHUNK + 3,)
    assert (content == content[0]).all()
    assert contents(family.reference, cells[:0], name).shape == (0,)


@solid
def test_normals_are_those_of_the_facets(family):
    normals = facet_normals(family.reference, one(family), family.name)[0]
    middle = family.reference.mean(axis=0)
    rows = [facet for table in family.facets for facet in table]
    assert len(normals) == len(rows)
    for normal, facet in zip(normals, rows, strict=True):
        assert normal @ (family.reference[facet].mean(axis=0) - middle) > 0
    np.testing.assert_allclose(normals.sum(axis=0), 0.0, atol=1e-15)  # they close


ANGLES = {
    "tetra": {math.acos(1 / 3)},
    "pyramid": {math.acos(-1 / 3), math.acos(1 / math.sqrt(3))},
    "wedge": {math.pi / 3, math.pi / 2},
    "hexahedron": {math.pi / 2},
}


@solid
@given(seed=seeds)
def test_dihedral_angles_of_the_ideal_cells(family, seed):
    random = np.random.default_rng(seed)
    points = family.reference @ rotation(random).T * random.uniform(1e-3, 1e3)
    found = dihedral_angles(points, one(family), family.name)[0]
    assert len(found) == len(family.hinges)
    for angle in found:
        assert min(abs(angle - known) for known in ANGLES[family.name]) < 1e-12


@pytest.mark.parametrize("small", [1e-3, 1e-6, 1e-8, 1e-10])
def test_dihedral_angles_near_0_and_180_degrees(small):
    """A tet so flat that the cosine of its angles is 1 to the last digit."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, small]], dtype=float)
    angles = np.sort(dihedral_angles(points, np.array([[0, 1, 2, 3]]), "tetra")[0])
    # Opposite the diagonal 12, both faces rise by `small` over a height of 1 / sqrt(2).
    assert math.pi - angles[-1] == pytest.approx(math.sqrt(2) * small, rel=1e-5)
    assert angles[0] == pytest.approx(small, rel=1e-5)


def test_the_angle_beside_a_facet_without_area_is_a_number():
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 0, 1]], dtype=float)
    angles = dihedral_angles(points, np.array([[0, 1, 2, 3]]), "tetra")
    assert np.isfinite(angles).all()
    assert angles.max() == math.pi


@given(seeds)
def test_gates_and_report_have_the_same_angles(seed):
    from meshopt_cli.kernels.shape.angles import angle_range

    points = np.random.default_rng(seed).normal(size=(4, 3))
    cells = np.array([[0, 1, 2, 3]])
    if contents(points, cells, "tetra")[0] < 0:
        cells = cells[:, [0, 1, 3, 2]]
    found = dihedral_angles(points, cells, "tetra")
    np.testing.assert_allclose([found.min(), found.max()], angle_range(points, cells), rtol=1e-7)


def test_angles_of_vectors():
    axes = np.eye(3)
    for a, b in permutations(axes, 2):
        assert angles_between(a[None], b[None]) == pytest.approx(math.pi / 2)
    assert angles_between(axes, axes).tolist() == [0.0] * 3
    assert angles_between(axes, -axes).tolist() == [math.pi] * 3
    near = np.array([[1.0, 1e-12, 0.0]])
    assert angles_between(near, axes[:1])[0] == pytest.approx(1e-12)


@given(seeds)
def test_unfolded_triangles_keep_their_sides(seed):
    points = np.random.default_rng(seed).normal(size=(8, 3))
    triangles = np.array([[0, 1, 2], [5, 3, 7], [1, 2, 6]])
    flat, cells = unfolded(points, triangles)
    assert not flat[:, 2].any()
    assert len(np.unique(cells)) == cells.size
    assert (contents(flat[:, :2], cells, "triangle") > 0).all()
    for k in range(3):
        sides = norms(points[triangles[:, k]] - points[triangles[:, k - 1]])
        np.testing.assert_allclose(norms(flat[cells[:, k]] - flat[cells[:, k - 1]]), sides)


def test_an_unfolded_point_is_a_point():
    flat, _ = unfolded(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    assert not flat.any()
