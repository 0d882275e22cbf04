"""Compile kernels ahead, in several processes at once.

numba compiles in one thread of a process. A first run would wait twice as long without this;
later runs find the machine code in the cache. Only the groups of kernels that a run needs are
compiled before it; `python -m meshopt_cli.warmup` compiles all of them by hand.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from .compiled import cache
from .kernels.audit import audit
from .kernels.operators import relocate
from .kernels.operators.collapse import Collapse, sweep_collapse
from .kernels.operators.constrained import sweep_constrained
from .kernels.operators.flip import sweep_flip
from .kernels.operators.insert import Splitting, sweep_split
from .kernels.operators.mend import Mending, sweep_mend
from .kernels.operators.relax import sweep_relax
from .kernels.operators.swap import Swap, sweep_swap
from .kernels.search.separate import depths
from .kernels.search.target import best_over_face, estimate_targets
from .kernels.search.unite import unite
from .kernels.shape import angles, simplex
from .kernels.shape.classify import TetType
from .kernels.types import N_VERDICTS, Judge
from .mesh.cast import Simplices
from .transfer.carry import find
from .work.session import Workspace

NOTHING = np.empty(0, dtype=np.int64)


def one_tet() -> Workspace:
    """The smallest working mesh: all kernels have the same types on every mesh."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    return Workspace(
        Simplices(
            points=points,
            cells=np.array([[0, 1, 2, 3]]),
            region=np.zeros(1, dtype=np.int64),
            fixed=np.zeros(4, dtype=bool),
            facets=np.empty((0, 3), np.int64),
            edges=np.empty((0, 2), np.int64),
            frame=None,
            single=False,
            turned=False,
        ),
        Judge(simplex.ASPECT_RATIO, 0.0),
    )


def compile_swap(work: Workspace) -> None:
    how = Swap(0, 0.0, False, 0)
    sweep_swap(work.mesh, NOTHING, how, work.scratch, no_counts())
    sweep_flip(work.mesh, NOTHING, how, work.scratch, no_counts())


def compile_relax(work: Workspace) -> None:
    degree = np.zeros(4)
    how = Swap(0, 0.0, False, 0)
    sweep_relax(work.mesh, NOTHING, how, degree, degree, work.scratch, no_counts())


def compile_relocation(work: Workspace) -> None:
    how = relocate.Relocation(0, 0, 0.0, 0, 0.0, 0.0)
    relocate.sweep_relocation(work.mesh, NOTHING, how, work.scratch, no_counts())


def compile_collapse(work: Workspace) -> None:
    how = Collapse(0, 0.0, 0.0, False)
    sweep_collapse(work.mesh, NOTHING.reshape(0, 2), how, 0, work.scratch, no_counts())


def compile_split(work: Workspace) -> None:
    mesh, scratch = work.mesh, work.scratch
    sweep_split(mesh, NOTHING, Splitting(0, 0.0, 0.0, 0.0), scratch, no_counts())
    sweep_constrained(mesh, NOTHING, mesh.fixed.copy(), 0.0, 0, scratch, no_counts())


def compile_mend(work: Workspace) -> None:
    how = Mending(0.0, 0.0, 0.0, 0, 0, 0, 0.0)
    remedies = np.zeros((len(TetType), 1), dtype=np.int64)
    sweep_mend(work.mesh, NOTHING, remedies, how, work.scratch, no_counts())


def compile_basic(work: Workspace) -> None:
    mesh = work.mesh
    work.changed_vertices(0, 1.0)
    audit(mesh, 0.0)
    faces = mesh.cells[:1, :3]
    estimate_targets(mesh.judge, mesh.points, np.ascontiguousarray(faces), np.empty(1))
    best_over_face(mesh.judge, mesh.points, 0, 1, 2)
    angles.angle_range(mesh.points, mesh.cells[:1])
    angles.angle_sums(mesh.points, mesh.cells[:1], np.zeros(4))
    find(work.result()[0], np.zeros((1, 3)), np.zeros(1, np.int64))


def compile_check(work: Workspace) -> None:
    cells, edges = work.mesh.cells[:1], np.zeros((1, 2), dtype=np.int64)
    depth = np.zeros(1)
    depths(work.mesh.points, cells, cells, depth, cells[:, :3].copy(), cells[:, :3].copy(),
           edges, edges, depth)  # fmt: skip
    unite(np.arange(2), NOTHING, NOTHING)


def no_counts() -> np.ndarray:
    return np.zeros(N_VERDICTS, dtype=np.int64)


@dataclass(frozen=True)
class Task:
    """A group of kernels that are compiled together, and how long that takes, in any unit."""

    compile: Callable[[Workspace], None]
    weight: float


# The longest first.
TASKS: dict[str, Task] = {
    "mend": Task(compile_mend, 25),
    "split": Task(compile_split, 11),
    "relax": Task(compile_relax, 7),
    "basic": Task(compile_basic, 5),
    "collapse": Task(compile_collapse, 5),
    "swap": Task(compile_swap, 5),
    "relocation": Task(compile_relocation, 4),
    "check": Task(compile_check, 1),
}


def shares_of(groups: Iterable[str], n_shares: int) -> list[list[str]]:
    """The groups of each process: one goes to the process that has the least to do."""
    shares: list[list[str]] = [[] for _ in range(n_shares)]
    wanted = set(groups)
    for group in TASKS:
        if group in wanted:
            min(shares, key=lambda share: sum(TASKS[g].weight for g in share)).append(group)
    return [share for share in shares if share]


def compile_here(groups: Iterable[str]) -> None:
    """Compile some groups in this process."""
    work = one_tet()
    for group in groups:
        TASKS[group].compile(work)
        cache.note(group)


def compile_groups(groups: Iterable[str]) -> None:
    """Fill the cache with what is missing of some groups, on as many cores as there are.

    A process that fails is no harm: what it did not compile is compiled when it is needed.
    """
    n_cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    shares = shares_of(cache.missing(groups), n_cores or 1)
    environment = {**os.environ, "MESHOPT_CACHE_DIR": str(cache.folder().parent)}
    helpers = [
        subprocess.Popen(
            [sys.executable, "-m", "meshopt_cli.warmup", *share],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for share in shares[1:]
    ]
    try:
        for share in shares[:1]:
            compile_here(share)
        for helper in helpers:
            helper.wait()
    finally:
        for helper in helpers:
            helper.kill()


if __name__ == "__main__":
    if len(sys.argv) > 1:
        compile_here(sys.argv[1:])
    else:
        compile_groups(TASKS)
