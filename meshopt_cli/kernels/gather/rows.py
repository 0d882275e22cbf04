"""The rows at a vertex of a mesh of any cells, laid out as a star."""

from __future__ import annotations

import math

import numpy as np

from ...compiled.decorators import inlined, kernel
from ..shape.simplex import SCALED_JACOBIAN
from ..types import CLOCK, EDITION, FACES, MAX_BALL, CellMesh, Scratch
from ..vectors import Vec, at, square_distance
from .star import FACTORS, JACOBIAN


@kernel
def gather_rows(mesh: CellMesh, vertex: int, scratch: Scratch) -> int:
    """Put the handles of the rows at a vertex into `scratch.ball`; returns how many, -1 if more
    than fit."""
    first = mesh.ball_start[vertex]
    n = mesh.ball_start[vertex + 1] - first
    if n > MAX_BALL:
        return -1
    for i in range(n):
        scratch.ball[i] = mesh.ball[first + i]
    return n


@inlined
def vertex_of(mesh: CellMesh, row: int, local: int) -> int:
    """A vertex of a row; local = 3 is the fourth of a quad in the plane."""
    if local == mesh.cells.shape[1]:
        return mesh.fourth[row]
    return mesh.cells[row, local]


@inlined
def put(star: np.ndarray, k: int, i: int, p: Vec) -> None:
    """Set vector k of entry i of a star."""
    star[3 * k, i] = p.x
    star[3 * k + 1, i] = p.y
    star[3 * k + 2, i] = p.z


@kernel
def load_rows(mesh: CellMesh, n: int, scratch: Scratch) -> None:
    """Lay the rows of `scratch.ball` out in `scratch.star`."""
    for i in range(n):
        if mesh.judge.form == FACES:
            load_face(mesh, i, scratch)
        else:
            load_corner(mesh, i, scratch)


@kernel
def load_face(mesh: CellMesh, i: int, scratch: Scratch) -> None:
    """The corners after, before and across from the vertex of a face."""
    star = scratch.star
    row = scratch.ball[i] >> 2
    local = scratch.ball[i] & 3
    n = 3 if mesh.fourth[row] < 0 else 4
    put(star, 0, i, at(mesh.points, vertex_of(mesh, row, (local + 1) % n)))
    put(star, 1, i, at(mesh.points, vertex_of(mesh, row, (local + n - 1) % n)))
    star[FACTORS, i] = 0.0
    if n == 4:
        put(star, 2, i, at(mesh.points, vertex_of(mesh, row, (local + 2) % n)))
        star[FACTORS, i] = 1.0


@kernel
def load_corner(mesh: CellMesh, i: int, scratch: Scratch) -> None:
    """The edges of a corner that are judged, as `c + t p`.

    The first two change places: they then see the point at the end of the row, not at its
    beginning, as those of a star do.
    """
    star = scratch.star
    row = scratch.ball[i] >> 2
    local = scratch.ball[i] & 3
    s = mesh.shape[row]
    # A scaled Jacobian is that of the edges as they are.
    plain = mesh.judge.code == SCALED_JACOBIAN
    star[JACOBIAN, i] = mesh.stretch[s, 3, 1] if plain and s != 0 else 0.0
    apex = at(mesh.points, mesh.cells[row, 0])
    for k in range(3):
        x = 0.0
        y = 0.0
        z = 0.0
        t = 0.0
        for j in range(3):
            m = (1.0 if k == j else 0.0) if plain else mesh.stretch[s, k, j]
            # Each edge leads from the first vertex to another: one end, or neither, is the point.
            if local != j + 1:
                q = at(mesh.points, mesh.cells[row, j + 1])
                x += m * q.x
                y += m * q.y
                z += m * q.z
            else:
                t += m
            if local != 0:
                x -= m * apex.x
                y -= m * apex.y
                z -= m * apex.z
            else:
                t -= m
        to = k if k == 2 else 1 - k
        put(star, to, i, Vec(x, y, z))
        star[FACTORS + to, i] = t


@kernel
def longest_from(mesh: CellMesh, n: int, p: Vec, scratch: Scratch) -> float:
    """Length of the longest way from p to another vertex of the rows of `scratch.ball`."""
    longest = 0.0
    for i in range(n):
        row = scratch.ball[i] >> 2
        for k in range(mesh.cells.shape[1]):
            longest = max(longest, square_distance(p, at(mesh.points, mesh.cells[row, k])))
    return math.sqrt(longest)


@inlined
def touch_row(mesh: CellMesh, row: int) -> None:
    """Note that something around the vertices of a row changed in the current sweep."""
    clock = mesh.state[CLOCK]
    for k in range(mesh.cells.shape[1]):
        mesh.vertex_clock[mesh.cells[row, k]] = clock
    if mesh.fourth[row] >= 0:
        mesh.vertex_clock[mesh.fourth[row]] = clock
    mesh.state[EDITION] += 1
