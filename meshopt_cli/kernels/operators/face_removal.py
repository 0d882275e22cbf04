"""Multi-face removal (de Cougny and Shephard 1995): an edge in place of several faces at once.

The inverse of the edge swap: the faces between two vertices, each of them seen by both, make
way for the edge that joins these. Removing one face is the swap of two tets for three.
"""

from __future__ import annotations

import math

from ...cells import TET_FACETS
from ...compiled.decorators import kernel
from ..accept import is_accepted, threshold
from ..cavity import has_room
from ..gather.ball import local_index, next_stamp
from ..gather.shell import is_required
from ..judge import q_of_tet
from ..types import APPLIED, FIXED, FULL, INVALID, MAX_SHELL, NOT_BETTER, Scratch, SimplexMesh
from .ring import put
from .swap import SwapPlan

MAX_FACES = MAX_SHELL // 2  # each face has two tets in `scratch.shell`


@kernel
def set_rim(
    mesh: SimplexMesh,
    i: int,
    a: int,
    b: int,
    above: int,
    below: int,
    d: int,
    e: int,
    scratch: Scratch,
) -> None:
    """Put an edge of a face, with the tets at that face, on the rim, and measure its new tet."""
    rim = scratch.facets
    rim[i, 0] = a
    rim[i, 1] = b
    rim[i, 2] = above
    rim[i, 3] = below
    scratch.values[i] = q_of_tet(mesh, e, a, b, d)


@kernel
def beyond_rim(mesh: SimplexMesh, i: int, d: int, e: int, scratch: Scratch) -> tuple[int, int, int]:
    """The next face between d and e across an edge of the rim.

    Returns
    -------
    vertex : int
        Its vertex off the rim, -1 when there is no such face.
    above, below : int
        Its tets at d and at e.
    """
    rim = scratch.facets
    above = rim[i, 2]
    below = rim[i, 3]
    # The vertex of the present face that is not on the edge.
    apex = -1
    for k in range(4):
        v = mesh.cells[above, k]
        if v not in (rim[i, 0], rim[i, 1], d):
            apex = v
    one = mesh.neighbours[above, local_index(mesh.cells, above, apex)]
    other = mesh.neighbours[below, local_index(mesh.cells, below, apex)]
    if one < 0 or other < 0:
        return -1, -1, -1
    vertex = mesh.cells[one >> 2, one & 3]
    if vertex != mesh.cells[other >> 2, other & 3]:
        return -1, -1, -1
    # Both tets may have the same vertex, and yet no face between them but an interface.
    across = mesh.neighbours[one >> 2, local_index(mesh.cells, one >> 2, d)]
    if across < 0 or across >> 2 != other >> 2:
        return -1, -1, -1
    return vertex, one >> 2, other >> 2


@kernel
def simulate_face_removal(
    mesh: SimplexMesh, handle: int, rule: int, floor: float, scratch: Scratch
) -> SwapPlan:
    """Remove a face, and as many of those around it as make the worst new tet best.

    As with cavities, the faces grow across the edge of the rim whose new tet is the worst.
    The plan is one for `swap.apply_swap`.
    """
    cell = handle >> 2
    local = handle & 3
    beyond = mesh.neighbours[cell, local]
    if beyond < 0:
        return SwapPlan(FIXED, 0, 0, 0.0)
    other = beyond >> 2
    d = mesh.cells[cell, local]
    e = mesh.cells[other, beyond & 3]
    stamp = next_stamp(scratch)
    rim = scratch.facets
    created = scratch.created
    for k in range(3):
        a = mesh.cells[cell, TET_FACETS[local, k]]
        b = mesh.cells[cell, TET_FACETS[local, (k + 1) % 3]]
        scratch.vertex_mark[a] = stamp
        set_rim(mesh, k, a, b, cell, other, d, e, scratch)
    n_rim = 3
    n_faces = 1
    scratch.shell[0] = cell
    scratch.shell[1] = other
    before = min(mesh.quality[cell], mesh.quality[other])
    best_faces = 0
    best_worst = -math.inf
    best_before = before
    while True:
        worst = math.inf
        weakest = -1
        for i in range(n_rim):
            if scratch.values[i] < worst:
                worst = scratch.values[i]
                weakest = i
        if worst > best_worst:
            best_worst = worst
            best_faces = n_faces
            best_before = before
            for i in range(n_rim):
                put(created, i, e, rim[i, 0], rim[i, 1], d)
        if n_faces == MAX_FACES:
            break
        vertex, above, below = beyond_rim(mesh, weakest, d, e, scratch)
        if vertex < 0 or scratch.vertex_mark[vertex] == stamp:
            break
        a = rim[weakest, 0]
        b = rim[weakest, 1]
        if is_required(mesh, a, b):
            break
        scratch.vertex_mark[vertex] = stamp
        scratch.shell[2 * n_faces] = above
        scratch.shell[2 * n_faces + 1] = below
        n_faces += 1
        before = min(before, mesh.quality[above], mesh.quality[below])
        set_rim(mesh, weakest, a, vertex, above, below, d, e, scratch)
        set_rim(mesh, n_rim, vertex, b, above, below, d, e, scratch)
        n_rim += 1
    n_old = 2 * best_faces
    n_new = best_faces + 2
    if best_worst <= 0.0:
        return SwapPlan(INVALID, n_old, n_new, best_worst)
    if best_worst <= threshold(rule, floor, best_before) or not is_accepted(
        rule, floor, best_before, best_worst
    ):
        return SwapPlan(NOT_BETTER, n_old, n_new, best_worst)
    if not has_room(mesh, 1):
        return SwapPlan(FULL, n_old, n_new, best_worst)
    return SwapPlan(APPLIED, n_old, n_new, best_worst)
