"""Rules are explained, and some are for those who ask."""

import json

import pytest

from meshopt_cli.validity import RULES
from support.files import write
from support.meshes import tet_grid, tri_grid


@pytest.mark.parametrize("code", RULES)
def test_every_rule_is_explained(check, code):
    status, out, err = check("--explain", code.lower())
    rule = RULES[code]
    assert (status, err) == (0, "")
    for part in (code, rule.title, rule.severity, rule.explanation, rule.source, rule.fix):
        assert part in out


def test_an_unknown_rule_is_not_explained(check):
    status, out, err = check("--explain", "M999")
    assert (status, out) == (2, "")
    assert "M999" in err
    assert len(err.splitlines()) == 1


def test_rules_on_request(check, good):
    asked = {code for code, rule in RULES.items() if rule.on_request}
    assert asked == {"M214", "M301", "M302", "M303", "M405"}
    assert check(good)[1] == f"{good}: valid\n"
    status, out, _ = check(good, "--extend-select", "M3", "--format", "json")
    assert status == 0
    assert set(json.loads(out)["files"][0]["counts"]) == {"M302", "M303"}


def test_overconstrained_cells_edges_and_faces(check, tmp_path):
    def counts(of):
        path = write(tmp_path / "one.vtu", of)
        out = check(path, "--select", "M3", "--format", "json")[1]
        return json.loads(out)["files"][0]["counts"]

    # Of the triangles of a square those at two of its corners have two sides in the boundary;
    # the diagonal of a single square joins two corners.
    assert counts(tri_grid(3)) == {"M301": 2, "M302": 2}
    assert counts(tri_grid(1)) == {"M301": 2, "M302": 1}
    # Six tets around a diagonal: all faces inside have it, and two edges in the boundary.
    assert counts(tet_grid(1)) == {"M302": 1, "M303": 6}


def test_obtuse_angles(check, tmp_path):
    path = write(tmp_path / "right.vtu", tri_grid(2))
    assert check(path, "--select", "M405")[1] == f"{path}: valid\n"
    of = tri_grid(2)
    of.points[4] += [0.1, 0.02]
    status, out, _ = check(write(tmp_path / "obtuse.vtu", of), "--select", "M405")
    assert status == 0
    assert "M405" in out
