"""Pictures as files."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from meshopt_cli.errors import ConfigError
from meshopt_cli.pictures.cut import middle
from meshopt_cli.pictures.drawing import close_up, paint_of, whole
from meshopt_cli.pictures.library import LIBRARIES, REMEDY, missing, require
from meshopt_cli.pictures.scene import SPACE
from meshopt_cli.quality.measures import DEFAULT_MEASURE, MEASURES
from support.corners import pyramid_grid, tri_quad_grid, wedge_grid
from support.edits import shaken
from support.meshes import hex_grid, mesh, octahedron, tet_grid, tri_grid
from support.pictures import is_png, needs_pictures, pixels, scene
from support.samples import ROOT

MEASURE = MEASURES[DEFAULT_MEASURE]
MESHES = {
    "triangles": shaken(tri_grid(4)),
    "faces": tri_quad_grid(4),
    "surface": octahedron(),
    "tets": shaken(tet_grid(3)),
    "hexahedra": hex_grid(2),
    "wedges": wedge_grid(2),
    "pyramids": pyramid_grid(2),
}
any_mesh = pytest.mark.parametrize("one", MESHES.values(), ids=list(MESHES))


def painted(one, negative=False):
    seen = scene(one)
    cut = middle(seen) if seen.kind == SPACE else None
    paint = paint_of(seen, MEASURE, negative)
    return whole(seen, paint, cut, 0.85), paint.scale


@needs_pictures
@any_mesh
@pytest.mark.parametrize("negative", [False, True])
def test_a_bare_picture_is_as_large_as_it_is_asked_for(one, negative):
    from meshopt_cli.pictures.sheet import bare

    png = bare(painted(one, negative)[0], 200, 120)
    assert is_png(png)
    found = pixels(png)
    assert found.shape == (120, 200, 4)
    opaque = found[..., 3] > 200
    assert 0.1 < opaque.mean() < 1.0
    # It fills the height or the width.
    assert opaque.any(axis=1).mean() > 0.9 or opaque.any(axis=0).mean() > 0.9
    assert bare(painted(one, negative)[0], 200, 120) == png


@needs_pictures
def test_cells_have_the_colours_of_their_quality():
    from meshopt_cli.pictures.sheet import bare

    corners = [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.95]]
    one = mesh(corners, triangle=[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    seen = scene(one)
    drawing, scale = painted(one)
    n = 400
    found = pixels(bare(drawing, n, n))
    centre, half = drawing.centre[:2], drawing.half * 1.02
    for middle_of, colour in zip(
        seen.centres("triangle")[:, :2], scale.colours(seen.values["triangle"]), strict=True
    ):
        x, y = (middle_of - centre) / half * (n / 2) * (1, -1) + n / 2
        assert found[round(y), round(x), :3] == pytest.approx(255 * colour, abs=12)


@needs_pictures
@pytest.mark.parametrize("form", ["png", "svg"])
@pytest.mark.parametrize("name", ["triangles", "tets"])
def test_the_same_mesh_is_the_same_file(form, name):
    from meshopt_cli.pictures.sheet import sheet

    seen = scene(MESHES[name])
    family = next(iter(seen.cells))
    paint = paint_of(seen, MEASURE, False)
    several = [close_up(seen, paint, family, row, f"cell {row}") for row in range(3)]
    for drawings in ([painted(MESHES[name])[0]], several):
        one, other = (sheet(drawings, paint.scale, "$a_1$ <&>", form) for _ in range(2))
        assert one == other
        if form == "svg":
            root = ET.fromstring(one)
            text = " ".join(root.itertext())
            assert "$a_1$ <&>" in text
            assert ("cell 2" in text) == (len(drawings) == 3)
            assert b"<dc:date>" not in one
        else:
            assert is_png(one)


def test_what_is_missing_is_named_with_its_remedy(monkeypatch):
    from meshopt_cli.pictures import library

    monkeypatch.setattr(library, "find_spec", lambda name: None)
    with pytest.raises(ConfigError) as caught:
        require()
    assert str(caught.value) == missing()
    assert all(name in missing() for name in LIBRARIES)
    monkeypatch.setattr(library, "find_spec", lambda name: name)
    assert missing() == ""


def test_the_remedy_is_the_extra_of_the_package():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert f"{project['name']}[plot]" in REMEDY
    needed = {row.split(">")[0] for row in project["optional-dependencies"]["plot"]}
    assert needed == set(LIBRARIES)
    assert needed <= {row.split(">")[0] for row in project["optional-dependencies"]["test"]}


@needs_pictures
def test_a_machine_that_renders_nothing_is_said(monkeypatch):
    from meshopt_cli.pictures import solid

    monkeypatch.setattr(solid, "_way", lambda plotter: solid.BY_OSMESA)
    monkeypatch.setattr(solid, "_has_osmesa", lambda: False)
    with pytest.raises(ConfigError, match="no picture can be rendered here"):
        solid.rendered(painted(MESHES["tets"])[0], 20, 20)


@needs_pictures
@pytest.mark.parametrize("side", [0.0, 1.0])
def test_meshes_without_an_extent_are_drawn_all_the_same(side):
    from meshopt_cli.pictures.sheet import sheet

    line = [[0, 0, 0], [side, 0, 0], [2 * side, 0, 0], [side, 0, 0]]
    for one in (mesh(line, triangle=[[0, 1, 2]]), mesh(line, tetra=[[0, 1, 2, 3]])):
        seen = scene(one)
        paint = paint_of(seen, MEASURE, False)
        family = next(iter(seen.cells))
        for drawing in (whole(seen, paint, None, 0.9), close_up(seen, paint, family, 0, "a")):
            assert is_png(sheet([drawing], paint.scale, "", "png"))


@needs_pictures
def test_large_offsets_and_small_sizes_are_no_matter():
    from meshopt_cli.pictures.sheet import bare

    for name in ("triangles", "tets"):
        one = MESHES[name]
        moved = mesh(one.points * 2.0**-20 + 2.0**8, **{one.blocks[0].type: one.blocks[0].cells})
        here, there = (pixels(bare(painted(m)[0], 150, 150)) for m in (one, moved))
        assert np.mean(np.abs(here.astype(int) - there)) < 2.0
