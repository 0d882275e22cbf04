"""Meshes with the codes that `check` must give for each, no more and no fewer."""

import numpy as np

from meshopt_cli.mesh.model import Mesh
from support.edits import (
    at,
    cell_inside,
    declaring,
    moved,
    shifted,
    tagged,
    together,
    torn,
    transformed,
    turned,
    untangled_badly,
    with_cells,
    without,
)
from support.elements import HEXAHEDRA
from support.kinds import BROKEN_KINDS, VALID_KINDS
from support.meshes import (
    hex_grid,
    in_space,
    joined,
    mesh,
    octahedron,
    quad_grid,
    tet_grid,
    tri_grid,
)

CORNER = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
CUBE = [[*p, z] for z in (0, 1) for p in SQUARE]
SIDES = [[0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5]]  # middles of those of the square
PRISM = [[*p, z] for z in (0, 1) for p in [SQUARE[0], SQUARE[1], SQUARE[3]]]
PYRAMID = [[*p, 0] for p in SQUARE] + [[0.5, 0.5, 1]]
INCLINED = np.array([[1, 2, 3], [0.5, -1, 2]])
MIDDLES = [(CORNER[a] + CORNER[b]) / 2 for a, b in [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]]

VALID = {
    "tets": tet_grid(2),
    "hexahedra": hex_grid(2),
    "quads": quad_grid(3),
    "triangles": tri_grid(3),
    "one tet": mesh(CORNER, tetra=[[0, 1, 2, 3]]),
    "one hexahedron": mesh(CUBE, hexahedron=[range(8)]),
    "one wedge": mesh(PRISM, wedge=[range(6)]),
    "one pyramid": mesh(PYRAMID, pyramid=[range(5)]),
    "pyramid on a hexahedron": mesh(
        [*CUBE, [0.5, 0.5, 2]], hexahedron=[range(8)], pyramid=[[4, 5, 6, 7, 8]]
    ),
    "closed surface": octahedron(),
    "open surface": in_space(tri_grid(3), np.arange(16) ** 2 / 99),
    "surface of quads": in_space(quad_grid(3), np.arange(16) ** 2 / 99),
    "plane at a height": in_space(tri_grid(3), 5.0),
    "inclined plane": transformed(tri_grid(3), lambda p: p @ INCLINED),
    "inclined plane of quads": transformed(quad_grid(3), lambda p: p @ -INCLINED),
    "clockwise triangles": with_cells(tri_grid(2), tri_grid(2).blocks[0].cells[:, ::-1]),
    "parts a little apart": joined(tet_grid(1), shifted(tet_grid(1), 1.001, 0, 0)),
    "cells of lower dimension are free": mesh(
        CORNER,
        vertex=[[0]],
        line=[[0, 1], [1, 0], [2, 2]],
        triangle=[[0, 1, 2], [2, 1, 0], [0, 1, 2]],
        tetra=[[0, 1, 2, 3]],
    ),
    "second order": mesh([*CORNER, *MIDDLES], tetra10=[range(10)]),
    "no cells": Mesh(np.empty((0, 3)), []),
    "no rows": mesh(np.empty((0, 3)), tetra=np.empty((0, 4))),
    "lines": mesh(SQUARE, line=[[0, 1], [1, 2], [2, 3]]),
    "unknown type": mesh(SQUARE, polygon4=[[0, 1, 2, 3]]),
} | VALID_KINDS

# Sound only where the coordinates are exact enough.
FINE = {
    "thin tets": transformed(tet_grid(2), lambda p: p * [1, 1e-6, 1e-6]),
    "thin triangles": transformed(tri_grid(2), lambda p: p * [1, 1e-7]),
    "short edges in a wide domain": together(
        tet_grid(1), transformed(tet_grid(1), lambda p: p * 1e-13 + [0.0, 0.0, -0.001])
    ),
}


def quad(corner):
    return mesh([[0, 0], [1, 0], corner, [0, 1]], quad=[[0, 1, 2, 3]])


# What is broken, and the codes for it: no more and no fewer.
BROKEN = {
    "not a number": (moved(tet_grid(2), 13, [np.nan, 0, 0]), "M001"),
    "infinite": (moved(tet_grid(2), 13, [0, -np.inf, 0]), "M001"),
    "unused and not a number": (
        mesh([*CORNER, [0, 0, np.nan]], tetra=[[0, 1, 2, 3]]),
        "M001 M203",
    ),
    "vertex beyond the last": (mesh(CORNER, tetra=[[0, 1, 2, 3], [0, 1, 2, 4]]), "M002"),
    "vertex before the first": (mesh(CORNER, tetra=[[0, 1, 2, 3], [-1, 1, 2, 3]]), "M002"),
    "vertex far out": (mesh(CORNER, tetra=[[0, 1, 2, 3], [0, 1, 2, 2**62]]), "M002"),
    "line beyond the last": (mesh(CORNER, line=[[0, 4]], tetra=[[0, 1, 2, 3]]), "M002"),
    "unknown type beyond the last": (mesh(SQUARE, polygon4=[[0, 1, 2, 3], [0, 1, 2, 4]]), "M002"),
    "repeated in a tet": (mesh(CORNER, tetra=[[0, 1, 2, 3], [0, 1, 2, 0]]), "M003"),
    "repeated in a quad": (mesh(SQUARE, quad=[[0, 1, 2, 3], [0, 1, 1, 2]]), "M003"),
    "repeated in a hexahedron": (
        mesh(CUBE, hexahedron=[range(8), [0, 1, 2, 3, 4, 5, 6, 6]]),
        "M003",
    ),
    "inverted tet": (turned(tet_grid(2), 5), "M101"),
    "inverted triangle": (turned(tri_grid(2), 5), "M101"),
    "inverted triangle in an inclined plane": (turned(VALID["inclined plane"], 5), "M101"),
    "inverted triangle among clockwise ones": (turned(VALID["clockwise triangles"], 5), "M101"),
    "tets with a vertex beyond them": (moved(tet_grid(2), 13, [1.2, 0.5, 0.5]), "M101"),
    "hexahedron inverted at a corner": (moved(VALID["one hexahedron"], 6, [0.2] * 3), "M101"),
    "wedge inverted at a corner": (moved(VALID["one wedge"], 5, [0.1, 0.1, -0.1]), "M101"),
    "pyramid inverted at a corner": (moved(VALID["one pyramid"], 2, [0.2, 0.2, 0]), "M101"),
    "negative quad": (mesh(SQUARE, quad=[[3, 2, 1, 0]]), "M101"),
    "negative quad among others": (turned(quad_grid(2), 1), "M101"),
    "negative quad in an inclined plane": (turned(VALID["inclined plane of quads"], 1), "M101"),
    "flat tet": (mesh([[*p, 0] for p in SQUARE], tetra=[range(4)]), "M102"),
    "tet on a line": (mesh([[k, k, k] for k in range(4)], tetra=[range(4)]), "M102"),
    "nearly flat tet": (moved(VALID["one tet"], 3, [0.3, 0.3, 1e-13]), "M102"),
    "hexahedron flat at a corner": (moved(VALID["one hexahedron"], 6, [2 / 3] * 3), "M102"),
    "flat triangle in the plane": (mesh([[0, 0], [1, 0], [3, 0]], triangle=[range(3)]), "M102"),
    "flat triangle on a surface": (
        mesh([*CORNER, [0.5, 0.5, 0]], triangle=[[0, 1, 3], [0, 3, 2], [1, 4, 2], [1, 2, 3]]),
        "M102",
    ),
    "flat quad": (mesh([[0, 0], [1, 0], [2, 0], [3, 0]], quad=[range(4)]), "M102"),
    "all tets inverted": (
        with_cells(tet_grid(2), tet_grid(2).blocks[0].cells[:, [1, 0, 2, 3]]),
        "M103",
    ),
    "all hexahedra inverted": (
        with_cells(hex_grid(2), np.roll(hex_grid(2).blocks[0].cells, 4, axis=1)),
        "M103",
    ),
    "quad not convex": (quad([0.2, 0.2]), "M104"),
    "quad that intersects itself": (mesh(SQUARE, quad=[[0, 2, 1, 3]]), "M104"),
    "degenerate quad": (quad([0.5, 0.5]), "M104"),
    "negative quad not convex": (with_cells(quad([0.2, 0.2]), [[3, 2, 1, 0]]), "M101 M104"),
    "tet twice": (mesh(CORNER, tetra=[[0, 1, 2, 3], [1, 2, 0, 3]]), "M201"),
    "hexahedron twice, turned": (
        mesh(CUBE, hexahedron=[range(8), [1, 2, 3, 0, 5, 6, 7, 4]]),
        "M201",
    ),
    "triangle twice": (mesh(SQUARE, triangle=[[0, 1, 2], [2, 3, 0], [1, 2, 0]]), "M201 M204"),
    "parts with a point in one place": (
        mesh([*CORNER, *-CORNER], tetra=[[0, 1, 2, 3], [4, 6, 5, 7]]),
        "M202",
    ),
    "points nearly in one place": (
        mesh([*CORNER, *(-CORNER - 1e-13)], tetra=[[0, 1, 2, 3], [4, 6, 5, 7]]),
        "M202",
    ),
    "stray copy": (mesh([*CORNER, CORNER[0]], tetra=[[0, 1, 2, 3]]), "M202 M203"),
    "unused points": (mesh([*CORNER, [5, 5, 5], [5, 5, 5]], tetra=[[0, 1, 2, 3]]), "M203"),
    "unused point far away": (mesh([*CORNER, [1e300, 0, 0]], tetra=[[0, 1, 2, 3]]), "M203"),
    "used by a vertex only": (
        mesh([*CORNER, [5, 5, 5]], vertex=[[4]], tetra=[[0, 1, 2, 3]]),
        "M203",
    ),
    "three tets on a face": (
        mesh([*CORNER, [1, 1, 1], [2, 3, 7]], tetra=[[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 3, 5]]),
        "M204 M209",
    ),
    "three hexahedra on a face": (
        mesh(
            [*CUBE, *[[x, y, 2] for x, y in SQUARE], *[[x + 0.1, y + 0.3, 3] for x, y in SQUARE]],
            hexahedron=[range(8), range(4, 12), [4, 5, 6, 7, 12, 13, 14, 15]],
        ),
        "M204",
    ),
    "hanging node": (
        mesh([*SQUARE, [0.5, 0.5]], triangle=[[0, 1, 2], [0, 4, 3], [4, 2, 3]]),
        "M205",
    ),
    "hanging node off the middle, in an inclined plane": (
        mesh(
            np.array([*SQUARE, [0.3, 0.3]]) @ INCLINED, triangle=[[0, 1, 2], [0, 4, 3], [4, 2, 3]]
        ),
        "M205",
    ),
    "hanging node on a face": (
        mesh(
            [*CORNER, [1 / 3] * 3, [1, 1, 1]],
            tetra=[[0, 1, 2, 3], [1, 2, 4, 5], [2, 3, 4, 5], [3, 1, 4, 5]],
        ),
        "M205",
    ),
    "hanging nodes of hexahedra": (
        joined(hex_grid(1), shifted(hex_grid(2), 1, 0, 0)),
        "M205",
    ),
    "crack between triangles": (torn(tri_grid(2), 1), "M202 M205"),
    "crack between tets": (torn(tet_grid(2), 5), "M202 M205"),
    "crack between hexahedra": (torn(hex_grid(2), 1), "M202 M205"),
    "surface with a triangle turned": (turned(octahedron(), 3), "M207"),
    "surface with a quad turned": (turned(VALID["surface of quads"], 4), "M207"),
    "tets on one side of a face": (
        mesh([*CORNER, [-1, -1, 2]], tetra=[[0, 1, 2, 3], [0, 1, 2, 4]]),
        "M207 M209",
    ),
    "edges that cross": (
        mesh(
            [[0, 0], [3, 0], [1.5, 3], [0, 2], [1.5, -1], [3, 2]], triangle=[[0, 1, 2], [3, 4, 5]]
        ),
        "M209",
    ),
    "cell inside another": (
        mesh([[0, 0], [9, 0], [0, 9], [1, 1], [2, 1], [1, 2]], triangle=[[0, 1, 2], [3, 4, 5]]),
        "M209",
    ),
    "folded triangles": (
        mesh([[0, 0], [1, 0], [0, 1], [1, 1]], triangle=[[0, 1, 2], [0, 1, 3]]),
        "M207 M209",
    ),
}

BROKEN |= BROKEN_KINDS

CUBES = {  # two unit cubes that have the points in common that the name says
    "edge": joined(hex_grid(1), shifted(hex_grid(1), 1, 1, 0)),
    "vertex": joined(hex_grid(1), shifted(hex_grid(1), 1, 1, 1)),
}
BROKEN |= {
    "cubes that touch in an edge": (CUBES["edge"], "M212"),
    "cubes that touch in a vertex": (CUBES["vertex"], "M212"),
    "tets that touch in a vertex": (
        mesh([*CORNER, *-CORNER[1:]], tetra=[[0, 1, 2, 3], [0, 5, 4, 6]]),
        "M212",
    ),
    "tets that touch in an edge": (
        mesh([*CORNER, [-1, 0, 0], [0, -1, 0]], tetra=[[0, 1, 2, 3], [0, 4, 5, 3]]),
        "M212",
    ),
    "triangles that touch in a vertex": (
        mesh([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]], triangle=[[0, 1, 2], [0, 3, 4]]),
        "M212",
    ),
    "quads that touch in a vertex": (
        joined(in_space(quad_grid(1)), in_space(shifted(quad_grid(1), 1, 1))),
        "M212",
    ),
    "part that touches itself in an edge": (
        joined(
            *(
                shifted(hex_grid(1), *p)
                for p in [(0, 0, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
            )
        ),
        "M206",
    ),
    "quads around a hole that touch in a vertex": (
        joined(
            *(
                in_space(shifted(quad_grid(1), *p))
                for p in [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (-1, 2), (-1, 1)]
            )
        ),
        "M212",
    ),
    "part that touches itself in a vertex": (
        joined(
            *(
                shifted(hex_grid(1), *p)
                for p in [
                    (0, 0, 0),
                    (0, 0, -1),
                    (1, 0, -1),
                    (2, 0, -1),
                    (3, 0, -1),
                    (3, 1, -1),
                    (3, 1, 0),
                    (3, 1, 1),
                    (2, 1, 1),
                    (1, 1, 1),
                ]
            )
        ),
        "M212",
    ),
    "tet missing inside": (without(tet_grid(4), cell_inside(tet_grid(4))), "M211"),
    "tet missing in another orientation": (
        without(
            with_cells(tet_grid(4), tet_grid(4).blocks[0].cells[:, [1, 0, 2, 3]]),
            cell_inside(tet_grid(4)),
        ),
        "M103 M211",
    ),
    "two tets missing": (
        without(tet_grid(6), at(tet_grid(6), 0.3, 0.3, 0.3), at(tet_grid(6), 0.7, 0.7, 0.7)),
        "M211",
    ),
    "hexahedron missing": (without(hex_grid(3), 13), "M211"),
    "triangle missing": (without(tri_grid(4), at(tri_grid(4), 0.4, 0.3)), "M211"),
    "triangle missing among clockwise ones": (
        without(
            with_cells(tri_grid(4), tri_grid(4).blocks[0].cells[:, ::-1]), at(tri_grid(4), 0.4, 0.3)
        ),
        "M211",
    ),
    "quad missing": (without(quad_grid(3), 4), "M211"),
    "declared face without its tet": (
        declaring(without(tet_grid(2), 0), triangle=[tet_grid(2).blocks[0].cells[0, :3]]),
        "M208",
    ),
    "declared face that is a facet of no tet": (
        declaring(tet_grid(2), triangle=[[0, 13, 26]]),
        "M208",
    ),
    "declared face with a vertex twice": (declaring(tet_grid(2), triangle=[[0, 1, 1]]), "M208"),
    "declared quad that is a facet of no hexahedron": (
        declaring(hex_grid(2), quad=[[0, 2, 8, 6]]),
        "M208",
    ),
    "declared line that is no edge of a triangle": (declaring(tri_grid(3), line=[[0, 2]]), "M208"),
    "tangle turned positive": (
        untangled_badly(tet_grid(3), 21, [0.9, 0.4, 0.45]),
        "M207 M209 M210",
    ),
    "triangles across each other": (
        mesh([*SQUARE, [0.5, 2]], triangle=[[0, 1, 2], [0, 2, 3], [0, 1, 4]]),
        "M207 M209",
    ),
    "tets across each other": (
        together(VALID["one tet"], shifted(VALID["one tet"], 0.1, 0.1, 0.1)),
        "M209",
    ),
    "tet inside another": (
        together(
            transformed(VALID["one tet"], lambda p: 9.0 * p), shifted(VALID["one tet"], 1, 1, 1)
        ),
        "M209",
    ),
    "grid across another": (together(tet_grid(2), shifted(tet_grid(2), 0.3, 0.2, 0.1)), "M209"),
    "hexahedra across each other": (
        together(hex_grid(1), shifted(hex_grid(1), 0.5, 0.4, 0.3)),
        "M209",
    ),
    "wedges across each other": (
        together(VALID["one wedge"], shifted(VALID["one wedge"], 0.1, 0.2, 0.3)),
        "M209",
    ),
    "tets of a star": (
        mesh(CUBE, tetra=[[0, 2, 7, 5], [1, 3, 4, 6]]),
        "M209",
    ),
    "quads across each other": (
        together(quad_grid(1), shifted(quad_grid(1), 0.5, 0.5)),
        "M209",
    ),
    "region in two parts": (tagged(tri_grid(3), [1] * 3 + [2] * 12 + [1] * 3), "M213"),
    "region of tets in two parts": (
        tagged(tet_grid(2), [1] * 6 + [2] * 36 + [1] * 6, "gmsh:physical"),
        "M213",
    ),
    "hexahedron on two tets": (
        mesh(
            [*CUBE, [0.2, 0.3, 2]],
            hexahedron=[range(8)],
            tetra=[[4, 5, 6, 8], [4, 6, 7, 8]],
        ),
        "M205",
    ),
    "hanging node on an edge of tets": (
        mesh(
            [*CORNER, [0.5, 0.5, 0], [1, 1, -1]],
            tetra=[[0, 1, 2, 3], [4, 1, 0, 5], [2, 4, 0, 5]],
        ),
        "M205",
    ),
    "hexahedron inverted along an edge": (mesh(HEXAHEDRA["edge"], hexahedron=[range(8)]), "M105"),
    "hexahedron inverted in a face": (mesh(HEXAHEDRA["face"], hexahedron=[range(8)]), "M105"),
    "second-order tet inverted": (
        mesh(
            [*CORNER, *MIDDLES],
            tetra10=[[1, 0, 2, 3, *range(4, 10)], [0, 1, 2, 3, *range(4, 10)]],
        ),
        "M101 M106 M201",
    ),
    "second-order triangle turned": (
        mesh(
            [*SQUARE, [0.5, 0], [1, 0.5], [0.5, 0.5], [0.5, 1], [0, 0.5]],
            triangle6=[[0, 1, 2, 4, 5, 6], [3, 2, 0, 7, 6, 8]],
        ),
        "M101",
    ),
    "two middle nodes on a side": (
        mesh(
            [*SQUARE, *SIDES, [0.5, 0.5], [0.52, 0.52]],
            triangle6=[[0, 1, 2, 4, 5, 8], [0, 2, 3, 9, 6, 7]],
        ),
        "M106",
    ),
    "a middle node of two sides": (
        mesh(
            [*SQUARE, *SIDES, [0.5, 0.5]],
            triangle6=[[0, 1, 2, 4, 5, 8], [0, 2, 3, 8, 6, 6]],
        ),
        "M105 M106 M203",
    ),
}
