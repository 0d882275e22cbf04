"""What runs in processes of its own: the meter around a command, and peers that are libraries.

`child.py meter LIMIT CORES LOG COMMAND...` prints, as a line of JSON, what a command took.
`child.py gmsh INPUT OUTPUT TIMES THRESHOLD` and `child.py netgen INPUT OUTPUT STRATEGY` optimize a
mesh, and print the seconds without reading and writing.
"""

import json
import os
import signal
import sys
import time


def meter(limit: str, cores: str, log: str, *command: str) -> dict[str, float]:
    """Run a command and measure it.

    It runs from this process, which is small, and not from the one that judges: the peak
    memory of a process is never less than that of the process it was forked from.

    Parameters
    ----------
    limit : str
        Seconds after which to end it.
    cores : str
        How many cores it may use; 0 stands for all.
    log : str
        File for what it prints.
    """
    output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
    start = time.perf_counter()
    child = os.fork()
    if not child:
        try:
            os.setsid()
            if int(cores) and hasattr(os, "sched_setaffinity"):
                os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[-int(cores) :])
            os.dup2(output, 1)
            os.dup2(output, 2)
            os.execvp(command[0], command)
        finally:
            os._exit(127)
    late = False

    def end(*_):
        nonlocal late
        late = True
        os.killpg(child, signal.SIGKILL)

    signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, float(limit))
    try:
        _, status, usage = os.wait4(child, 0)
    except BaseException:  # it has a session of its own, which no Ctrl-C reaches
        os.killpg(child, signal.SIGKILL)
        raise
    seconds = time.perf_counter() - start
    signal.setitimer(signal.ITIMER_REAL, 0)
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return {
        "seconds": seconds,
        "cpu": usage.ru_utime + usage.ru_stime,
        "peak": usage.ru_maxrss / unit,
        "status": os.waitstatus_to_exitcode(status),
        "late": late,
    }


def gmsh(source: str, target: str, times: str, threshold: str) -> dict[str, float]:
    """Optimize the discrete volumes of a model, whose surfaces hold the nodes of the boundary."""
    import gmsh

    gmsh.initialize(readConfigFiles=False)
    for option, value in (
        ("General.Terminal", 0),
        ("Mesh.Binary", 1),
        ("Mesh.SaveAll", 1),
        ("Mesh.OptimizeThreshold", float(threshold)),
    ):
        gmsh.option.setNumber(option, value)
    gmsh.open(source)
    start = time.perf_counter()
    for _ in range(int(times)):
        gmsh.model.mesh.optimize("", force=True)  # does nothing unless forced
    seconds = time.perf_counter() - start
    gmsh.write(target)
    gmsh.finalize()
    return {"optimize": seconds}


def netgen(source: str, target: str, strategy: str) -> dict[str, float]:
    """Run a strategy of Netgen's optimizer in the three steps that are its default.

    It heeds the number of threads only inside a task manager. Outside it starts more threads than
    it may use cores, and they wait for each other most of the time.
    """
    import pyngcore
    from netgen.meshing import Mesh, MeshingParameters

    cores = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(os.cpu_count())
    pyngcore.SetNumThreads(len(cores))
    mesh = Mesh()
    mesh.Load(source)
    start = time.perf_counter()
    with pyngcore.TaskManager():
        mesh.OptimizeVolumeMesh(MeshingParameters(optimize3d=strategy, optsteps3d=3))
    seconds = time.perf_counter() - start
    mesh.Save(target)
    return {"optimize": seconds}


if __name__ == "__main__":
    print(json.dumps({"meter": meter, "gmsh": gmsh, "netgen": netgen}[sys.argv[1]](*sys.argv[2:])))
