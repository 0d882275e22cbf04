"""Whatever is wrong with a mesh, it is optimized to a valid one, or refused."""

import warnings

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshopt_cli import validity
from meshopt_cli.boundary.policy import Fixed, Slide
from meshopt_cli.errors import InvariantError, MeshoptError
from meshopt_cli.jobs import optimize as job
from meshopt_cli.jobs.optimize_cells import optimize_cells
from meshopt_cli.jobs.optimize_mesh import kind_of
from meshopt_cli.plans.config import Request, plan_for
from support.corners import pyramid_grid, tri_quad_grid, wedge_grid
from support.meshes import hex_grid, quad_grid, tet_grid, tri_grid
from support.random_edits import cells, meshes
from support.settings import examples

MEANT = tuple(code for code, rule in validity.RULES.items() if rule.can_be_meant)


@pytest.mark.parametrize("grid", [tri_grid(4), tet_grid(2)], ids=["plane", "space"])
@examples(150)
@given(data=st.data())
def test_a_mesh_is_mended_or_refused(grid, data):
    mesh = data.draw(meshes(grid))
    policy = data.draw(st.sampled_from([Fixed(), Slide()]))
    allowed = data.draw(st.sampled_from([(), MEANT]))
    plan = plan_for(Request(preset=data.draw(st.sampled_from(["fast", "best"]))), mesh.dimension())
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result = job.optimize(
                mesh, plan.pipeline, plan.measure, policy=policy, allowed=allowed
            ).mesh
    except InvariantError:
        raise
    except MeshoptError:
        return
    # Where solids overlap is not looked for before they are optimized.
    assert validity.check(result, ignore=allowed, overlaps=False).is_valid


CELLS = [quad_grid(4), tri_quad_grid(4), hex_grid(2), wedge_grid(2), pyramid_grid(2)]


@pytest.mark.parametrize("grid", CELLS, ids=["quads", "faces", "hexahedra", "wedges", "solids"])
@examples(60)
@given(data=st.data())
def test_any_cells_are_mended_or_refused(grid, data):
    mesh = data.draw(cells(grid))
    allowed = data.draw(st.sampled_from([(), MEANT]))
    request = Request(preset=data.draw(st.sampled_from(["fast", "standard", "best"])))
    plan = plan_for(request, mesh.dimension(), kind_of(mesh))
    came = {code for code in ("M105", "M209") if not validity.check(mesh, (code,)).is_valid}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result = optimize_cells(mesh, plan.pipeline, plan.measure, allowed=allowed).mesh
    except InvariantError:
        raise
    except MeshoptError:
        return
    assert validity.check(result, ignore=(*allowed, *came)).is_valid
