"""The shell of an edge of a tet mesh: the tets that share it (Definition 18.6)."""

from __future__ import annotations

from ...compiled.decorators import kernel
from ..types import MAX_SHELL
from .ball import local_index

# What `gather_shell` and `gather_open_shell` return in place of a number of tets.
SHELL_OPEN = 0
SHELL_OVERFLOW = -1
SHELL_ELSEWHERE = -2


@kernel
def is_required(mesh, a, b):
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


@kernel
def gather_shell(mesh, cell, a, b, c, d, scratch):
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
        if n > 0 and (
            mesh.quality[cell] < mesh.quality[first]
            or (mesh.quality[cell] == mesh.quality[first] and cell < first)
        ):
            return SHELL_ELSEWHERE
        scratch.shell[n] = cell
        scratch.ring[n] = c
        n += 1
        beyond = mesh.neighbours[cell, local_index(mesh.cells, cell, c)]
        if beyond < 0:
            return SHELL_OPEN
        cell = beyond >> 2
        if cell == first:
            return n
        c = d
        d = mesh.cells[cell, beyond & 3]


@kernel
def gather_open_shell(mesh, cell, a, b, c, d, scratch):
    """Collect the tets around an edge on the boundary or an interface, from one side to the other.

    As `gather_shell`, but there is one vertex more around the edge than tets.

    Returns
    -------
    n : int
        Number of tets, or SHELL_OVERFLOW or SHELL_ELSEWHERE.
    """
    worst = cell
    # Back to the side where the shell begins.
    for _ in range(MAX_SHELL):
        beyond = mesh.neighbours[cell, local_index(mesh.cells, cell, d)]
        if beyond < 0:
            break
        cell = beyond >> 2
        d = c
        c = mesh.cells[cell, beyond & 3]
    n = 0
    while True:
        if n == MAX_SHELL - 1:
            return SHELL_OVERFLOW
        if mesh.quality[cell] < mesh.quality[worst] or (
            mesh.quality[cell] == mesh.quality[worst] and cell < worst
        ):
            return SHELL_ELSEWHERE
        scratch.shell[n] = cell
        scratch.ring[n] = c
        scratch.ring[n + 1] = d
        n += 1
        beyond = mesh.neighbours[cell, local_index(mesh.cells, cell, c)]
        if beyond < 0:
            return n
        cell = beyond >> 2
        c = d
        d = mesh.cells[cell, beyond & 3]
