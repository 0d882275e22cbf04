"""Distances from points to faces, edges and points."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.constraints.near import nearest, off_faces, pairs_within
from support.settings import examples


def some(seed, n=40):
    generator = np.random.default_rng(seed)
    faces = generator.uniform(-1, 1, (n, 3, 3))
    faces[: n // 4, 2] = faces[: n // 4, 1]
    faces[: n // 8, 1:] = faces[: n // 8, :1]
    return faces, generator.uniform(-1.5, 1.5, (n, 3)), generator


def within(faces, generator, n=200):
    """Points of each face, (faces, n, 3)."""
    weights = generator.dirichlet(np.ones(3), (len(faces), n))
    return np.einsum("fnk,fkj->fnj", weights, faces)


@given(st.integers(0, 2**32 - 1))
@examples(20)
def test_no_point_of_a_face_is_nearer(seed):
    faces, points, generator = some(seed)
    there = nearest(faces, points)
    least = np.linalg.norm(points - there, axis=1)
    far = np.linalg.norm(within(faces, generator) - points[:, None], axis=2).min(axis=1)
    assert np.all(least <= far + 1e-12)
    again = nearest(faces, there)
    assert np.allclose(again, there, atol=1e-9)


@given(st.integers(0, 2**32 - 1))
@examples(20)
def test_half_spaces_keep_off_all_of_a_face(seed):
    faces, points, generator = some(seed)
    there = nearest(faces, points)
    distance = np.linalg.norm(points - there, axis=1)
    rows, normals, offsets = off_faces(np.arange(len(points)), points, there, distance, 0.25)
    assert len(rows)
    inside = np.einsum("fnj,fj->fn", within(faces[rows], generator), normals)
    assert np.all(inside <= offsets[:, None] - 0.25 + 1e-9)


def test_pairs_are_those_of_all_distances():
    faces, points, generator = some(3)
    reach = generator.uniform(0.2, 1.0, len(points))
    one, other, _, distance = pairs_within(faces, points, reach)
    found = set(zip(one.tolist(), other.tolist(), strict=True))
    for i in range(len(points)):
        far = np.linalg.norm(
            points[i] - nearest(faces, np.tile(points[i], (len(faces), 1))), axis=1
        )
        assert {j for k, j in found if k == i} == set(np.flatnonzero(far <= reach[i]).tolist())
    assert np.all(distance <= reach[one])
