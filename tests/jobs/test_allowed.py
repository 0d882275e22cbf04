"""Meshes that break rules on purpose: cracks and contacts stay as they are."""

import numpy as np
import pytest

from meshopt_cli.boundary.policy import Fixed, Slide
from meshopt_cli.errors import ConfigError
from meshopt_cli.jobs.admission import InvalidMeshError
from meshopt_cli.mesh.model import Block
from meshopt_cli.validity import ERROR, RULES, meant, vertices_apart
from support.broken import BROKEN, INCLINED
from support.edits import moved, shifted, together, transformed, with_cells
from support.held import counts, doubled_places, optimized_as, shaken_where_free
from support.kinds import apart, cut
from support.meshes import joined, tet_grid, tri_grid

CRACK = ("M202", "M205")
ABLE = [code for code, rule in RULES.items() if rule.can_be_meant]


def contact():
    """Two cubes of tets that touch with faces divided in different ways."""
    one, other = tet_grid(2), shifted(tet_grid(3), 1, 0, 0)
    return together(one, other)


CRACKED = {
    "crack in a plane": cut(tri_grid(8), 0.1, 0.9),
    "crack in an inclined plane": transformed(cut(tri_grid(8), 0.1, 0.9), lambda p: p @ INCLINED),
    "crack in a solid": cut(tet_grid(4), 0.1, 0.9),
    "crack from the boundary": cut(tet_grid(4), -1, 0.6),
    "plane cut in two": cut(tri_grid(8), -1, 2),
    "solid cut in two": cut(tet_grid(4), -1, 2),
    "contact of other grids": contact(),
    "tets apart": apart(tet_grid(3)),
}


@pytest.mark.parametrize("policy", [Fixed(), Slide()], ids=lambda policy: policy.name)
@pytest.mark.parametrize("name", CRACKED)
def test_what_meets_without_being_shared_stays(name, policy):
    of = CRACKED[name]
    if name in ("crack in a plane", "crack in a solid", "plane cut in two"):
        of = shaken_where_free(of, 0.03)
    with pytest.raises(InvalidMeshError, match="M20"):
        optimized_as(of, policy)
    result = optimized_as(of, policy, CRACK)
    assert doubled_places(result.mesh) == doubled_places(of)
    assert counts(result.mesh) == counts(of)
    assert result.after.worst <= result.before.worst
    held = {tuple(p) for p in of.points[vertices_apart(of)].tolist()}
    assert held
    assert held <= {tuple(p) for p in result.mesh.points.tolist()}


def test_a_cracked_mesh_gets_better():
    of = shaken_where_free(cut(tet_grid(4), 0.1, 0.9), 0.04)
    result = optimized_as(of, allowed=CRACK)
    assert result.after.worst < 0.9 * result.before.worst


@pytest.mark.parametrize("allowed", [(), ("M202",), ("M205",), ("M206", "M208", "M209", "M211")])
def test_nothing_else_is_allowed(allowed):
    with pytest.raises(InvalidMeshError) as caught:
        optimized_as(CRACKED["crack in a plane"], allowed=allowed)
    left = sorted(set(CRACK) - set(allowed))
    assert [group.code for group in caught.value.report.errors] == left
    hint = ",".join(sorted({*left, *allowed}))
    assert str(caught.value).endswith(f"--allow {hint}")


def test_what_cannot_be_meant_gets_no_hint():
    of = cut(tri_grid(4), 0.1, 0.9)
    of.blocks.append(Block("triangle", of.blocks[0].cells[:1]))
    with pytest.raises(InvalidMeshError, match="M201") as caught:
        optimized_as(of)
    assert "--allow" not in str(caught.value)


def test_a_tangle_beside_a_crack_is_mended():
    of = cut(tri_grid(8), 0.1, 0.9)
    vertex = int(np.argmin(np.linalg.norm(of.points - 0.25, axis=1)))
    of = moved(of, vertex, of.points[vertex] + [0.02, 0.2])
    assert "M101" in counts(of)
    result = optimized_as(of, allowed=CRACK)
    assert counts(result.mesh) == counts(cut(tri_grid(8), 0.1, 0.9))


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("triangle missing", "M211"),
        ("two tets missing", "M211"),
        ("part with lost facet", "M208"),
        ("planes across each other", "M209"),
        ("hanging node", "M205"),
        ("solid that touches itself", "M206"),
    ],
)
def test_each_rule_that_can_be_meant(name, code):
    meshes = {
        "part with lost facet": BROKEN["declared face that is a facet of no tet"][0],
        "planes across each other": together(tri_grid(4), shifted(tri_grid(4), 0.3, 0.2)),
        "solid that touches itself": joined(
            *(
                shifted(tet_grid(1), *p)
                for p in [(0, 0, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
            )
        ),
    }
    of = meshes.get(name) or BROKEN[name][0]
    assert [c for c in counts(of) if RULES[c].severity == ERROR] == [code]
    with pytest.raises(InvalidMeshError):
        optimized_as(of)
    for policy in (Fixed(), Slide()):
        result = optimized_as(of, policy, (code,))
        assert set(counts(result.mesh)) <= set(counts(of))


def test_points_in_one_place_inside_of_both_stay_apart():
    """Two grids in one place: no vertex is on the boundary of both, and none moves away."""
    one = tri_grid(4)
    of = together(one, with_cells(one, one.blocks[0].cells[:, [1, 2, 0]]))
    allowed = tuple(c for c in counts(of) if RULES[c].severity == ERROR)
    assert set(allowed) == {"M202", "M205", "M209"}
    result = optimized_as(of, allowed=allowed)
    assert doubled_places(result.mesh) == doubled_places(of)


def test_which_rules_can_be_meant():
    assert ABLE == ["M202", "M205", "M206", "M208", "M209", "M211"]
    assert meant(["M2"]) == tuple(ABLE)
    assert meant(["m202", "M205", "M202"]) == CRACK
    assert meant([]) == ()
    # A warning keeps no mesh out.
    assert meant(["M212"]) == ()


@pytest.mark.parametrize(
    "code", [c for c, rule in RULES.items() if rule.severity == ERROR and not rule.can_be_meant]
)
def test_the_others_are_refused_by_name(code):
    with pytest.raises(ConfigError, match=f"{code} cannot be allowed.*{', '.join(ABLE)}"):
        meant([code])


def test_unknown_codes_are_refused():
    for code in ("M999", "x", ""):
        with pytest.raises(ConfigError, match="no rule"):
            meant([code])
