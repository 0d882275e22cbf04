"""Adapt a mesh to a function with a shock: ``python adapt.py [FOLDER] [TURNS]``.

Each turn is that of a real loop: solve (here a known function takes the place of a solver),
estimate (the Hessian of what was solved, recovered from its values at the vertices, says which
sizes in which directions give the same error everywhere), and adapt, by ``meshopt optimize
--metric``. The boundary stays as it is, and the shock does not touch it. Needs numpy and meshio.
"""

import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np

ERROR = 0.02  # of linear interpolation, wanted on every edge
LEAST, GREATEST = 0.004, 0.25  # sizes


def solve(points):
    """The function: 1 outside a circle and -1 inside, with a steep front between them."""
    return np.tanh(40.0 * (np.hypot(points[:, 0], points[:, 1]) - 0.6))


def start(n=24):
    """A square of side 2, in triangles of one size."""
    x = np.linspace(-1.0, 1.0, n + 1)
    points = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    low = np.stack([corner, corner + n + 1, corner + n + 2], axis=1)
    high = np.stack([corner, corner + n + 2, corner + 1], axis=1)
    return points, np.concatenate([low, high])


def gradients(points, cells, values):
    """Of values at the vertices, (np, k): at each vertex the mean over the triangles there."""
    a, b, c = (points[cells[:, i]] for i in range(3))
    edges = np.stack([b - a, c - a], axis=1)
    area = np.abs(np.linalg.det(edges)) / 2
    rise = np.stack([values[cells[:, i]] - values[cells[:, 0]] for i in (1, 2)], axis=1)
    slopes = np.linalg.solve(edges, rise)
    total, weight = np.zeros((len(points), 2, values.shape[1])), np.zeros(len(points))
    for i in range(3):
        np.add.at(total, cells[:, i], slopes * area[:, None, None])
        np.add.at(weight, cells[:, i], area)
    return total / weight[:, None, None]


def metric(points, cells, values):
    """Tensors (np, 2, 2) in which every edge of length 1 has the same error of interpolation."""
    slopes = gradients(points, cells, values[:, None])[:, :, 0]
    hessian = gradients(points, cells, slopes)
    hessian = (hessian + hessian.transpose(0, 2, 1)) / 2
    curvature, axes = np.linalg.eigh(hessian)
    wanted = np.clip(np.abs(curvature) / (8 * ERROR), GREATEST**-2.0, LEAST**-2.0)
    return np.einsum("nij,nj,nkj->nik", axes, wanted, axes)


def error(points, cells, values):
    """Mean error of linear interpolation, at the middles of the edges of all triangles."""
    a, b = cells[:, [0, 1, 2]].ravel(), cells[:, [1, 2, 0]].ravel()
    exact = solve((points[a] + points[b]) / 2)
    corners = points[cells]
    area = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    off = np.abs(exact - (values[a] + values[b]) / 2).reshape(-1, 3).mean(axis=1)
    return float((off * area).sum() / area.sum())


def write_sol(path, tensors):
    """A metric as Medit has it: xx, xy, yy at each vertex."""
    rows = np.stack([tensors[:, 0, 0], tensors[:, 0, 1], tensors[:, 1, 1]], axis=1)
    with path.open("w") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n{len(rows)}\n1 3\n")
        np.savetxt(file, rows)
        file.write("End\n")


def main(folder, turns):
    folder.mkdir(exist_ok=True)
    points, cells = start()
    print("turn  vertices  error of interpolation")
    for turn in range(turns + 1):
        values = solve(points)
        print(f"{turn:4}  {len(points):8,}  {error(points, cells, values):.2e}")
        mesh = folder / f"turn{turn}.mesh"
        meshio.Mesh(points, [("triangle", cells)]).write(mesh)
        if turn == turns:
            break
        write_sol(mesh.with_suffix(".sol"), metric(points, cells, values))
        adapted = folder / "adapted.mesh"
        command = ["optimize", mesh, adapted, "--metric", mesh.with_suffix(".sol"), "-q"]
        subprocess.run([sys.executable, "-m", "meshopt_cli", *map(str, command)], check=True)
        found = meshio.read(adapted)
        points, cells = found.points[:, :2], found.cells_dict["triangle"]
        adapted.unlink()


if __name__ == "__main__":
    arguments = sys.argv[1:]
    main(Path(arguments[0] if arguments else "out"), int(arguments[1]) if arguments[1:] else 6)
