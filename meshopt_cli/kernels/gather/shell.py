"""The shell of an edge of a tet mesh: the tets that share it (Definition 18.6)."""

from __future__ import annotations

from ...compiled.decorators import inlined, kernel
from ...handles import DECLARED, INTERFACE, OUTER
from ..types import MAX_SHELL, Scratch, SimplexMesh
from .ball import local_index

# What `gather_shell` and `gather_open_shell` return in place of a number of tets.
SHELL_OPEN = 0
SHELL_OVERFLOW = -1
SHELL_ELSEWHERE = -2


@kernel
def is_required(mesh: SimplexMesh, a: int, b: int) -> bool:
    """Whether an internal edge was declared in the file and must stay."""
    if mesh.required.shape[0] == 0 or not (mesh.fixed[a] and mesh.fixed[b]):
        return False
    key = min(a, b) * mesh.points.shape[0] + max(a, b)
    low = 0
    high = mesh.required.shape[0]
    while low < high:
        middle = (low + high) // 2
        if mesh.required[middle] < key:
            low = middle + 1
        else:
            high = middle
    return low < mesh.required.shape[0] and mesh.required[low] == key


@inlined
def next_around(mesh: SimplexMesh, cell: int, c: int, d: int) -> tuple[int, int, int]:
    """The tet beyond the face opposite c, where an edge is turned about from its tet (a, b, c, d).

    Returns
    -------
    cell : int
        A border where there is none.
    c, d : int
        Its vertices off the edge, d being the new one.
    """
    beyond = mesh.neighbours[cell, local_index(mesh.cells, cell, c)]
    if beyond < 0:
        return beyond, c, d
    return beyond >> 2, d, mesh.cells[beyond >> 2, beyond & 3]


@kernel
def gather_shell(
    mesh: SimplexMesh, cell: int, a: int, b: int, c: int, d: int, scratch: Scratch
) -> int:
    """Collect the tets around an edge, turning about it from its tet (a, b, c, d).

    Writes the tets to `scratch.shell` and to `scratch.ring` the vertices around the edge;
    tet i is (a, b, ring[i], ring[i + 1]).

    Returns
    -------
    n : int
        Number of tets of a closed shell; SHELL_OPEN when the edge lies on the boundary or
        an interface; SHELL_OVERFLOW when the shell does not fit; SHELL_ELSEWHERE when another
        of its tets is worse than the first (or as bad, with a lower number): each shell is
        looked at from its worst tet only.
    """
    first = cell
    n = 0
    while True:
        if n == MAX_SHELL:
            return SHELL_OVERFLOW
        if is_worse(mesh, cell, first):
            return SHELL_ELSEWHERE
        scratch.shell[n] = cell
        scratch.ring[n] = c
        n += 1
        cell, c, d = next_around(mesh, cell, c, d)
        if cell < 0:
            return SHELL_OPEN
        if cell == first:
            return n


@kernel
def gather_shell_of(
    mesh: SimplexMesh, cell: int, a: int, b: int, c: int, d: int, scratch: Scratch
) -> int:
    """As `gather_shell`, whichever of the tets is the worst."""
    first = cell
    n = 0
    while True:
        if n == MAX_SHELL:
            return SHELL_OVERFLOW
        scratch.shell[n] = cell
        scratch.ring[n] = c
        n += 1
        cell, c, d = next_around(mesh, cell, c, d)
        if cell < 0:
            return SHELL_OPEN
        if cell == first:
            return n


@kernel
def gather_open_shell(
    mesh: SimplexMesh, cell: int, a: int, b: int, c: int, d: int, scratch: Scratch
) -> tuple[int, bool]:
    """Collect the tets around an edge on the boundary or an interface, from one side to the other.

    As `gather_shell`, but there is one vertex more around the edge than tets.

    Returns
    -------
    n : int
        Number of tets, or SHELL_OVERFLOW or SHELL_ELSEWHERE.
    outer : bool
        Whether both sides are the boundary of the mesh, and of the same patch where this is known.
    """
    worst = cell
    side = OUTER
    # Back to the side where the shell begins: turning the other way exchanges c and d.
    for _ in range(MAX_SHELL):
        back, e, f = next_around(mesh, cell, d, c)
        if back < 0:
            side = back
            break
        cell = back
        d = e
        c = f
    n = 0
    while True:
        if n == MAX_SHELL - 1:
            return SHELL_OVERFLOW, False
        if is_worse(mesh, cell, worst):
            return SHELL_ELSEWHERE, False
        scratch.shell[n] = cell
        scratch.ring[n] = c
        scratch.ring[n + 1] = d
        n += 1
        cell, c, d = next_around(mesh, cell, c, d)
        if cell < 0:
            return n, cell == side and cell not in (INTERFACE, DECLARED)


@inlined
def is_worse(mesh: SimplexMesh, cell: int, other: int) -> bool:
    """Whether a cell is worse than another, or as bad with a lower number; never than itself."""
    return mesh.quality[cell] < mesh.quality[other] or (
        mesh.quality[cell] == mesh.quality[other] and cell < other
    )
