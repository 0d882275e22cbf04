"""Compile all kernels ahead, in several processes at once.

numba compiles in one thread of a process. A first run would wait twice as long without this;
later runs find the machine code in the cache. `python -m meshopt_cli.warmup` does it by hand.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable

import numpy as np

from .kernels import measures, relocate
from .kernels._jit import CACHE_ROOT, is_compiled
from .kernels.audit import audit
from .kernels.classify import TetType
from .kernels.collapse import Collapse, sweep_collapse
from .kernels.constrained import sweep_constrained
from .kernels.flip import sweep_flip
from .kernels.mend import Mending, sweep_mend
from .kernels.relax import sweep_relax
from .kernels.shell_swap import Swap, sweep_swap
from .kernels.split import sweep_split
from .kernels.target import best_over_face, estimate_targets
from .kernels.types import N_VERDICTS
from .mesh import Simplices
from .transfer import find
from .workspace import Workspace

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
        measures.ASPECT_RATIO,
    )


def compile_swap(work: Workspace) -> None:
    sweep_swap(work.mesh, NOTHING, Swap(0, 0.0, False), work.scratch, no_counts())


def compile_relax(work: Workspace) -> None:
    degree = np.zeros(4)
    how = Swap(0, 0.0, False)
    sweep_relax(work.mesh, NOTHING, how, degree, degree, work.scratch, no_counts())


def compile_relocation(work: Workspace) -> None:
    how = relocate.Relocation(0, 0, 0.0, 0, 0.0, 0.0)
    relocate.sweep_relocation(work.mesh, NOTHING, how, work.scratch, no_counts())


def compile_collapse(work: Workspace) -> None:
    how = Collapse(0, 0.0, 0.0, False)
    sweep_collapse(work.mesh, NOTHING, NOTHING, how, 0, work.scratch, no_counts())


def compile_split(work: Workspace) -> None:
    mesh, scratch = work.mesh, work.scratch
    sweep_split(mesh, NOTHING, 0, 0.0, scratch, no_counts())
    sweep_constrained(mesh, NOTHING, mesh.fixed.copy(), 0.0, 0, scratch, no_counts())


def compile_mend(work: Workspace) -> None:
    how = Mending(0.0, 0.0, 0.0, 0, 0, 0)
    remedies = np.zeros((len(TetType), 1), dtype=np.int64)
    sweep_mend(work.mesh, NOTHING, remedies, how, work.scratch, no_counts())


def compile_rest(work: Workspace) -> None:
    mesh = work.mesh
    sweep_flip(mesh, NOTHING, Swap(0, 0.0, False), work.scratch, no_counts())
    work.changed_vertices(0, 1.0)
    audit(mesh, 0.0)
    faces = mesh.cells[:1, :3]
    estimate_targets(mesh.measure, mesh.points, np.ascontiguousarray(faces), np.empty(1))
    best_over_face(mesh.measure, mesh.points, 0, 1, 2)
    measures.angle_range(mesh.points, mesh.cells[:1])
    measures.angle_sums(mesh.points, mesh.cells[:1], np.zeros(4))
    find(work.result()[0], np.zeros((1, 3)), np.zeros(1, np.int64))


def no_counts() -> np.ndarray:
    return np.zeros(N_VERDICTS, dtype=np.int64)


# What each takes by itself, in any unit; the longest first.
TASKS: dict[Callable[[Workspace], None], float] = {
    compile_mend: 22,
    compile_split: 7,
    compile_relax: 4,
    compile_collapse: 4,
    compile_swap: 3,
    compile_relocation: 3,
    compile_rest: 3,
}


def share_of(number: int, n_shares: int) -> list[Callable[[Workspace], None]]:
    """The tasks of one process: each goes to the process that has the least to do."""
    shares: list[list[Callable[[Workspace], None]]] = [[] for _ in range(n_shares)]
    for task in TASKS:
        min(shares, key=lambda tasks: sum(TASKS[t] for t in tasks)).append(task)
    return shares[number]


def compile_share(number: int, n_shares: int) -> None:
    """Compile what falls to one of so many processes."""
    work = one_tet()
    for task in share_of(number, n_shares):
        task(work)


def compile_all() -> None:
    """Fill the cache, on as many cores as there are.

    A process that fails is no harm: what it did not compile is compiled when it is needed.
    """
    if is_compiled():
        return
    n_shares = min(len(TASKS), len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity")
                   else os.cpu_count() or 1)  # fmt: skip
    environment = {**os.environ, "MESHOPT_CACHE_DIR": str(CACHE_ROOT)}
    command = [sys.executable, "-m", "meshopt_cli.warmup"]
    helpers = [
        subprocess.Popen(
            [*command, str(share), str(n_shares)],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for share in range(1, n_shares)
    ]
    try:
        compile_share(0, n_shares)
        for helper in helpers:
            helper.wait()
    finally:
        for helper in helpers:
            helper.kill()


if __name__ == "__main__":
    if len(sys.argv) > 1:
        compile_share(int(sys.argv[1]), int(sys.argv[2]))
    else:
        compile_all()
