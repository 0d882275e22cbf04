"""For each call that a rule names: a mesh that breaks the rule, the call, and the verdict after."""

from dataclasses import replace

import numpy as np
import pytest

from meshopt_cli.cli.entry import status_of
from meshopt_cli.repairs import MENDS
from meshopt_cli.validity import RULES
from support.broken import BROKEN
from support.curved import bulging, disc, of_second_order
from support.edits import moved, shaken
from support.files import write
from support.meshes import tet_grid, tri_grid

CALLS = [(code, call) for code, rule in RULES.items() for call in rule.calls]


def of_table(name):
    return lambda: BROKEN[name][0]


def with_a_flat_tet():
    """A cube of tets, and one more that lies flat on its lower face."""
    grid = tet_grid(1)
    cells = np.concatenate([grid.blocks[0].cells, [[0, 4, 6, 2]]])
    return replace(grid, blocks=[replace(grid.blocks[0], cells=cells)])


def with_a_flat_triangle_inside():
    grid = tri_grid(4)
    return moved(grid, int(np.flatnonzero((grid.points == 0.5).all(axis=1))[0]), [0.375, 0.625])


def bent_with_a_thin_cell():
    """A disc with a curved rim, and a cell there that is too thin to bear it."""
    one = disc(4)
    inner = np.flatnonzero(np.linalg.norm(one.points, axis=1) < 0.8)
    one.points[inner[-1]] *= 1.28
    return of_second_order(one, bulging(-0.05))


MESHES = {
    ("M001", "repair --unused"): of_table("unused and not a number"),
    ("M003", "repair --flat"): of_table("repeated in a tet"),
    ("M101", "repair --orientation"): of_table("inverted triangle"),
    ("M101", "optimize"): of_table("tets with a vertex beyond them"),
    ("M102", "repair --flat"): with_a_flat_tet,
    ("M102", "optimize"): with_a_flat_triangle_inside,
    ("M103", "repair --orientation"): of_table("all tets inverted"),
    ("M104", "repair --orientation"): of_table("quad that intersects itself"),
    ("M105", "optimize"): bent_with_a_thin_cell,
    ("M201", "repair --duplicates"): of_table("hexahedron twice, turned"),
    ("M202", "repair --merge"): of_table("hexahedra apart"),
    ("M203", "repair --unused"): of_table("unused points"),
    ("M204", "repair --duplicates"): of_table("triangle twice"),
    ("M205", "repair --merge"): of_table("crack between tets"),
    ("M207", "repair --orientation"): of_table("surface with a quad turned"),
    ("M208", "repair --facets"): of_table("declared face without its tet"),
    ("M210", "optimize"): of_table("tangle turned positive"),
    ("M211", "repair --fill"): of_table("hexahedron missing"),
    ("M215", "repair --orientation"): of_table("box of plates turned at random"),
    ("M401", "optimize"): lambda: shaken(tet_grid(4), 0.4),
    ("M402", "optimize"): lambda: shaken(tri_grid(6), 0.4),
    ("M404", "optimize"): lambda: shaken(tet_grid(4), 0.4),
}
GATES = {
    "M401": ["--fail-above", "2.5"],
    "M402": ["--min-angle", "25"],
    "M404": ["--gate", "dihedral-min>=20"],
}


def test_each_call_has_a_mesh():
    assert list(MESHES) == CALLS


@pytest.mark.parametrize(("code", "call"), CALLS, ids=[f"{c} {call}" for c, call in CALLS])
def test_the_call_mends_what_the_rule_finds(code, call, tmp_path, capsys):
    path = write(tmp_path / "broken.vtu", MESHES[code, call]())
    fixed = tmp_path / "fixed.vtu"
    ask = ["check", "--format", "json", "--extend-select", code, *GATES.get(code, [])]
    status_of([*ask, str(path)])
    assert f'"{code}"' in capsys.readouterr().out
    status_of([*call.split(), str(path), str(fixed)])
    capsys.readouterr()
    status = status_of([*ask, str(fixed)])
    assert f'"{code}"' not in capsys.readouterr().out
    assert status == 0


def test_explanations_name_the_calls(capsys):
    for code, call in CALLS:
        assert status_of(["check", "--explain", code]) == 0
        assert f"Fix: meshopt {RULES[code].calls[0]} IN OUT" in capsys.readouterr().out
        assert not call.startswith("repair") or call.split("--")[1] in MENDS


def test_a_refusal_names_the_call(tmp_path, capsys):
    path = write(tmp_path / "broken.vtu", BROKEN["tet twice"][0])
    assert status_of(["optimize", str(path), str(tmp_path / "out.vtu")]) == 1
    assert "can be mended: meshopt repair --duplicates" in capsys.readouterr().err


def test_every_mend_is_named_by_a_rule():
    named = {call.split("--")[1] for _, call in CALLS if "--" in call}
    assert named == set(MENDS)
