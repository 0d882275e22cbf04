"""fit: edges toward length 1 in a metric."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli.errors import ConfigError
from meshopt_cli.mesh.cast import cast
from meshopt_cli.passes.fit import Fit
from meshopt_cli.passes.smooth import Smooth
from meshopt_cli.passes.swap import Swap
from meshopt_cli.passes.untangle import Untangle
from meshopt_cli.work.lengths import UNKNOWN, lengths_of
from support.driven import layered, workspace_in
from support.edits import declaring_some, halves, shaken
from support.invariants import assert_kept, workspace
from support.meshes import tet_grid, tri_grid
from support.metrics import random_tensors

GRIDS = [pytest.param(tri_grid, 8, id="plane"), pytest.param(tet_grid, 5, id="space")]


def isotropic(one, size):
    d = one.points.shape[1]
    return np.tile(np.eye(d) / size**2, (len(one.points), 1, 1))


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 1.0), st.booleans(), st.sampled_from([2, 3]))
def test_meshes_stay_whole(seed, size, gains, d):
    grid = tri_grid(5) if d == 2 else tet_grid(4)
    one = declaring_some(halves(shaken(grid, 0.8, seed % 1000)))
    tensors = random_tensors(d, len(one.points), 0.3, seed) / size**2
    work = workspace_in(one, tensors)
    fit = Fit(gains="yes" if gains else "no", max_vertices=20.0)
    for step in (fit, Swap(), Smooth(method="descent", accept="mean", least_quality=0.02), fit):
        step.run(work)
        assert_kept(cast(one), work)


@pytest.mark.parametrize(("make", "n"), GRIDS)
def test_long_edges_inside_are_split(make, n):
    one = make(n)
    h = 0.4 / (n - 1)
    work = workspace_in(one, isotropic(one, h))
    before = work.lengths()[1].max()
    for _ in range(6):
        Fit(shortest=0.0, least_quality=0.01).run(work)
    assert work.n_vertices > 2 * len(one.points)
    assert work.lengths()[1].mean() < 0.7 * before


@pytest.mark.parametrize(("make", "n"), GRIDS)
def test_short_edges_are_collapsed(make, n):
    one = shaken(make(n))
    work = workspace_in(one, isotropic(one, 5.0 / (n - 1)))
    inner = work.n_vertices - np.count_nonzero(work.mesh.fixed)
    for _ in range(4):
        Fit(longest=1e3, slack=1.0, least_quality=0.01).run(work)
    left = work.n_vertices - np.count_nonzero(work.mesh.fixed)
    assert left < 0.5 * inner


@pytest.mark.parametrize(("make", "n"), GRIDS)
def test_where_each_change_must_gain_the_index_rises(make, n):
    one = shaken(make(n))
    work = workspace_in(one, layered(one.points))
    work.aim_at((), fits=True)
    before = tau(work)
    applied = Fit(gains="yes", longest=1.2, shortest=0.9).run(work).applied
    assert applied
    assert tau(work) > before


def tau(work):
    """The efficiency index as the kernels measure lengths, of all edges."""
    d = work.dimension
    cells = work.corners(work.living())
    ends = [(i, j) for i in range(d + 1) for j in range(i)]
    edges = np.unique(np.sort(np.concatenate([cells[:, e] for e in ends]), axis=1), axis=0)
    m = np.zeros((len(work.mesh.points), 3, 3))
    k = work.mesh.points[:, 3:]
    m[:, [0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]] = k
    m[:, [1, 2, 2], [0, 0, 1]] = k[:, [1, 3, 4]]
    e = work.places[edges[:, 1]] - work.places[edges[:, 0]]
    a, b = (np.sqrt(np.einsum("ni,nij,nj->n", e, m[edges[:, i]], e)) for i in (0, 1))
    near = np.abs(a - b) <= 1e-3 * a
    sizes = np.where(near, (a + b) / 2, (a - b) / np.log(np.where(near, 2.0, a / b)))
    return 1 - np.mean((1 - np.minimum(sizes, 1 / sizes)) ** 2)


@pytest.mark.parametrize("method", ["laplace", "quality", "optimize", "descent"])
@pytest.mark.parametrize(("make", "n"), GRIDS)
def test_relocation_in_a_constant_metric_is_that_of_the_mapped_mesh(make, n, method):
    one = shaken(make(n))
    d = one.points.shape[1]
    matrix = random_tensors(d, 1, 0.3)[0]
    root = np.linalg.cholesky(matrix)
    work = workspace_in(one, np.tile(matrix, (len(one.points), 1, 1)))
    image = workspace(type(one)(one.points @ root, one.blocks))
    smooth = Smooth(method=method, order="index", sweeps=1)
    assert smooth.run(work).applied == smooth.run(image).applied > 0
    np.testing.assert_allclose(work.places[:, :d] @ root, image.places[:, :d], atol=1e-5)


def test_new_vertices_have_the_metric_of_the_input():
    one = shaken(tri_grid(6))
    work = workspace_in(one, layered(one.points))
    for step in (Fit(), Smooth(method="descent"), Swap()):
        step.run(work)
        rows = np.flatnonzero(work.mesh.vertex_cell >= 0)
        region = work.mesh.region[work.mesh.vertex_cell[rows]]
        expected = work._background.at(work.places[rows], region)
        np.testing.assert_allclose(work.mesh.points[rows, 3:], expected, rtol=1e-6, atol=1e-9)


def test_vertices_stay_within_their_bound():
    one = tet_grid(4)
    work = workspace_in(one, isotropic(one, 0.02))
    for _ in range(4):
        Fit(max_vertices=1.5).run(work)
    assert work.n_points <= 1.5 * len(one.points) + 1


def variants():
    """Each choice and each limit of each option, one by one."""
    for f in fields(Fit):
        limits = [v for v in (f.metadata["least"], f.metadata["most"]) if v is not None]
        for value in (*f.metadata["choices"], *limits):
            if value != f.default and f.name != "max_vertices":
                yield pytest.param({f.name: value}, id=f"{f.name}={value}")


@pytest.mark.parametrize("options", list(variants()))
@pytest.mark.parametrize("make", [tri_grid, tet_grid])
def test_every_option_keeps_meshes_whole(make, options):
    one = shaken(make(4), 0.6, 3)
    work = workspace_in(one, layered(one.points))
    for _ in range(2):
        Fit(**{"max_vertices": 8.0, **options}).run(work)
    assert_kept(cast(one), work)


@pytest.mark.parametrize("which", ["longest", "shortest"])
def test_either_may_be_left_out(which):
    one = shaken(tri_grid(8))
    h = 0.02 if which == "shortest" else 0.6
    work = workspace_in(one, isotropic(one, h))
    n = work.n_vertices
    Fit(**{which: 0.0}).run(work)
    assert work.n_vertices > n if which == "shortest" else work.n_vertices < n
    other = workspace_in(one, isotropic(one, h))
    Fit(longest=0.0, shortest=0.0).run(other)
    assert other.n_vertices == n


def test_only_bad_places_are_visited():
    one = shaken(tri_grid(8))
    work = workspace_in(one, isotropic(one, 0.02))
    assert Fit(worse_than=1.01 / work.standing().worst).run(work).visited == 0
    assert Fit().run(work).applied > 0


def test_what_stays_as_it_is_is_not_tried_again():
    one = shaken(tri_grid(10))
    work = workspace_in(one, layered(one.points))
    fit = Fit()
    tried = [fit.run(work).visited for _ in range(12)]
    assert tried[0] > 0
    assert tried[-1] < 0.2 * tried[0]


@pytest.mark.parametrize(
    "change", [{"longest": -1.0}, {"longest": 0.5}, {"shortest": 1.5}, {"slack": 2.0}]
)
def test_values_out_of_range_are_named(change):
    with pytest.raises(ConfigError, match=next(iter(change))):
        Fit(**change)


@pytest.mark.parametrize(("make", "n"), GRIDS)
def test_lengths_that_are_remembered_are_those_that_are_found(make, n):
    """Of cells that did not change they are not looked for again, whatever was done to others."""
    one = shaken(make(n))
    work = workspace_in(one, layered(one.points))
    work.lengths()
    kept = work.copy()
    smooth = Smooth(method="descent", accept="mean", least_quality=0.02)
    for step in (Swap(), smooth, Fit(), Swap(worse_than=2.0), Fit(gains="yes"), Untangle(), smooth):
        step.run(work)
        known, anew = work.lengths(), lengths_of(work.mesh, UNKNOWN).values
        np.testing.assert_array_equal(known[:, : anew.shape[1]], anew)
    work.move(work.places)
    np.testing.assert_array_equal(work.lengths(), lengths_of(work.mesh, UNKNOWN).values)
    np.testing.assert_array_equal(kept.lengths(), lengths_of(kept.mesh, UNKNOWN).values)
