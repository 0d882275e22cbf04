"""Drivers for the operators: what only kernels can call, made callable."""

from __future__ import annotations

from meshopt_cli.compiled.decorators import entry
from meshopt_cli.kernels.gather import ball, star
from meshopt_cli.kernels.operators import (
    clear,
    collapse,
    face_removal,
    flip,
    foldover,
    insert,
    nonobtuse,
    odt,
    relocate,
    ring,
    swap,
)
from meshopt_cli.kernels.shape import classify, lack
from meshopt_cli.kernels.vectors import at


@entry
def plan_relocation(mesh, vertex, how, scratch):
    """`simulate_relocation` for Python."""
    return relocate.simulate_relocation(mesh, vertex, how, scratch)


@entry
def do_relocation(mesh, vertex, plan, scratch):
    """`apply_relocation` for Python."""
    relocate.apply_relocation(mesh, vertex, plan, scratch)


@entry
def plan_pull(mesh, vertex, how, density, scratch):
    """`simulate_pull` for Python."""
    return odt.simulate_pull(mesh, vertex, how, density, scratch)


@entry
def centre_of(mesh, cell):
    """`circumcentre` for Python."""
    return odt.circumcentre(mesh, cell)


@entry
def plan_flip(mesh, handle, rule, floor):
    """`simulate_flip` for Python."""
    return flip.simulate_flip(mesh, handle, rule, floor)


@entry
def do_flip(mesh, plan, scratch):
    """`apply_flip` for Python."""
    flip.apply_flip(mesh, plan, scratch)


@entry
def plan_face_swap(mesh, handle, rule, floor, scratch):
    """`simulate_face_swap` for Python."""
    return swap.simulate_face_swap(mesh, handle, rule, floor, scratch)


@entry
def plan_edge_swap(mesh, handle, rule, floor, scratch):
    """`simulate_edge_swap` for Python."""
    return swap.simulate_edge_swap(mesh, handle, rule, floor, scratch)


@entry
def plan_face_removal(mesh, handle, rule, floor, scratch):
    """`simulate_face_removal` for Python."""
    return face_removal.simulate_face_removal(mesh, handle, rule, floor, scratch)


@entry
def type_of(points, cell_vertices):
    """`cell_type` for Python."""
    return classify.cell_type(points, cell_vertices)


@entry
def best_of_ring(mesh, a, b, n, stop, scratch):
    """`triangulate_ring` for Python."""
    return ring.triangulate_ring(mesh, a, b, n, stop, scratch)


@entry
def do_swap(mesh, plan, scratch):
    """`apply_swap` for Python."""
    swap.apply_swap(mesh, plan, scratch)


@entry
def plan_any_swap(mesh, cell, handle, how, scratch):
    """`simulate_swap` for Python."""
    return swap.simulate_swap(mesh, cell, handle, how, scratch)


@entry
def plan_collapse(mesh, vertex, onto, how, scratch):
    """`simulate_midpoint_collapse` for Python, or `simulate_collapse` without `how.midpoint`."""
    if how.midpoint:
        return collapse.simulate_midpoint_collapse(mesh, vertex, onto, how, scratch)
    return collapse.simulate_collapse(mesh, vertex, onto, how, scratch)


@entry
def do_collapse(mesh, plan, scratch):
    """`apply_collapse` for Python."""
    collapse.apply_collapse(mesh, plan, scratch)


@entry
def plan_insertion(mesh, cell, urgent, scratch):
    """`simulate_insertion` for Python."""
    how = insert.Splitting(mesh.points.shape[0], 0.0, urgent, 0.0)
    return insert.simulate_insertion(mesh, cell, how, scratch)


@entry
def measured_star(mesh, vertex, p, scratch):
    """`measure_star` of the ball of a vertex: number of cells and worst q."""
    n, _ = ball.gather_ball(mesh, vertex, scratch.ball, scratch)
    star.load_star(mesh, scratch.ball, n, scratch)
    return n, star.measure_star(mesh, n, p, scratch)


@entry
def do_insertion(mesh, plan, scratch):
    """`apply_insertion` for Python."""
    insert.apply_insertion(mesh, plan, scratch)


@entry
def energy_of(body, points, how, gradient):
    """`energy_at` for Python."""
    return foldover.energy_at(body, points, how, gradient)


@entry
def extreme_angles(points, a, b, c):
    """`extremes` of three points for Python."""
    return lack.extremes(at(points, a), at(points, b), at(points, c))


@entry
def plan_placing(mesh, vertex, wants, scratch):
    """`simulate_placing` for Python."""
    return nonobtuse.simulate_placing(mesh, vertex, wants, scratch)


@entry
def do_turn(mesh, cell, local, wants, scratch):
    """`turn` for Python."""
    return nonobtuse.turn(mesh, cell, local, wants, scratch)


@entry
def do_split_vertex(mesh, cell, local, behind, n, scratch):
    """`split_vertex` for Python."""
    return clear.split_vertex(mesh, cell, local, behind, n, scratch)


@entry
def do_clear(mesh, cell, how, scratch):
    """`clear` for Python; whether anything paid."""
    return clear.clear(mesh, cell, how, 0, scratch) >= 0
