"""The files that each tool reads and writes without a detour."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from judge import Array, Part, volumes, walls
from meshopt_cli import formats
from meshopt_cli.mesh.model import main_blocks, main_type
from meshopt_cli.mesh.tags import regions_of


class UnusableError(Exception):
    """A mesh that cannot be compared, with one line that says why."""


class Plane:
    """The plane of a mesh of triangles, in which every result of it is judged.

    Parameters
    ----------
    points : (np, 2) or (np, 3) float64
    """

    def __init__(self, points: Array) -> None:
        self.origin, self.axes = np.zeros(points.shape[1]), np.eye(points.shape[1])[:2]
        if points.shape[1] == 3 and np.ptp(points[:, 2]) > 0:
            self.origin = points.mean(axis=0)
            spread = np.linalg.svd(points - self.origin, full_matrices=False)
            self.axes = spread.Vh[:2]
            if spread.S[2] > 1e-6 * spread.S[1]:
                raise UnusableError("the triangles do not lie in one plane")

    def flatten(self, points: Array) -> Array:
        return (points - self.origin) @ self.axes.T


def oriented(points: Array, cells: Array, region: Array) -> Part:
    """Drop unused points, and turn all cells when most of them have the other orientation."""
    used, place = np.unique(cells, return_inverse=True)
    part = Part(points[used].astype(float), place.reshape(cells.shape), region)
    if np.sum(volumes(part)) < 0:
        part.cells = part.cells[:, [*range(part.dimension - 1), -1, -2]]
    return part


def read_any(path: Path, plane: Plane | None = None) -> tuple[Part, Plane | None]:
    """Read a mesh as this project does.

    Parameters
    ----------
    plane : Plane, optional
        Where triangles are to be judged, instead of in a plane of their own.
    """
    mesh, _ = formats.read(path)
    blocks = main_blocks(mesh, main_type(mesh))
    cells = np.concatenate([b.cells for b in blocks])
    points = mesh.points.astype(float)
    if cells.shape[1] == 3:
        plane = plane or Plane(points[np.unique(cells)])
        points = plane.flatten(points)
    return oriented(points, cells, regions_of(blocks, mesh.regions) + 1), plane


def labels(part: Part) -> tuple[Array, Array, Array]:
    """Facets of the boundary and between regions, and which two regions they part.

    Returns
    -------
    facets : (n, d) int64
    label : (n,) int64
        Number of the pair of regions, counted from 1.
    pairs : (m, 2) int64
        The regions of each label; 0 is the outside.
    """
    facets, inside, outside = walls(part)
    pairs, label = np.unique(np.stack([inside, outside], axis=1), axis=0, return_inverse=True)
    return facets, label.reshape(-1) + 1, pairs


def write_gmsh(path: Path, part: Part) -> None:
    """Write a model of discrete volumes, one a region, and of discrete surfaces between them.

    Nodes of the boundary lie on the surfaces: what lies in a volume may be moved.
    """
    import gmsh

    gmsh.initialize(readConfigFiles=False)
    try:
        for option, value in (("General.Terminal", 0), ("Mesh.Binary", 1), ("Mesh.SaveAll", 1)):
            gmsh.option.setNumber(option, value)
        _build(gmsh.model, part)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def _build(model, part: Part) -> None:
    facets, label, pairs = labels(part)
    surface = np.zeros(len(part.points), np.int64)
    surface[facets.reshape(-1)] = np.repeat(label, 3)
    volume = np.zeros(len(part.points), np.int64)
    volume[part.cells.reshape(-1)] = np.repeat(part.region, 4)
    model.add("mesh")
    entities = []
    for number in range(1, len(pairs) + 1):
        model.addDiscreteEntity(2, number)
        entities.append((2, number, surface == number, facets[label == number]))
    for region in np.unique(part.region).tolist():
        model.addDiscreteEntity(3, region, (1 + np.nonzero(pairs == region)[0]).tolist())
        own = (surface == 0) & (volume == region)
        entities.append((3, region, own, part.cells[part.region == region]))
    # Cells may have nodes of any entity: all nodes must be there first.
    for dimension, tag, nodes, _ in entities:
        numbers, coordinates = 1 + np.flatnonzero(nodes), part.points[nodes].reshape(-1)
        model.mesh.addNodes(dimension, tag, numbers, coordinates)
    for dimension, tag, _, cells in entities:
        kind = {2: 2, 3: 4}[dimension]
        model.mesh.addElementsByType(tag, kind, [], 1 + cells.reshape(-1))


def write_medit(path: Path, part: Part) -> None:
    """Write cells with their regions, and the facets between these with labels."""
    facets, label, _ = labels(part)
    sections = {
        "Vertices": (part.points, np.zeros(len(part.points), int)),
        ("Edges", "Triangles")[part.dimension - 2]: (facets + 1, label),
        ("Triangles", "Tetrahedra")[part.dimension - 2]: (part.cells + 1, part.region),
    }
    with path.open("w", encoding="ascii") as file:
        file.write(f"MeshVersionFormatted 2\nDimension {part.dimension}\n")
        for name, (rows, refs) in sections.items():
            file.write(f"{name}\n{len(rows)}\n")
            _rows(file, rows, refs)
        file.write("End\n")


def read_medit(path: Path, dimension: int) -> Part:
    """Read what Mmg wrote."""
    words = path.read_text(encoding="ascii").split()

    def section(name: str, width: int) -> Array:
        start = words.index(name) + 2
        count = int(words[start - 1])
        return np.array(words[start : start + count * width], float).reshape(count, width)

    points = section("Vertices", dimension + 1)[:, :-1]
    cells = section(("Triangles", "Tetrahedra")[dimension - 2], dimension + 2).astype(np.int64)
    return oriented(points, cells[:, :-1] - 1, cells[:, -1])


def write_netgen(path: Path, part: Part) -> None:
    """Write a .vol file, whose facets say which regions they part."""
    facets, label, pairs = labels(part)
    rows = np.column_stack([label, label, pairs[label - 1], np.full(len(label), 3), facets + 1])
    cells = np.column_stack([part.region, np.full(len(part.cells), 4), part.cells + 1])
    with path.open("w", encoding="ascii") as file:
        file.write(f"mesh3d\ndimension\n3\ngeomtype\n0\n\nsurfaceelements\n{len(rows)}\n")
        _rows(file, rows)
        file.write(f"\nvolumeelements\n{len(cells)}\n")
        _rows(file, cells[:, [0, 1, 2, 3, 5, 4]])
        file.write(f"\npoints\n{len(part.points)}\n")
        _rows(file, part.points)
        file.write("\nendmesh\n")


def read_netgen(path: Path) -> Part:
    """Read the points and the tetrahedra of a .vol file."""
    lines = path.read_text(encoding="ascii").splitlines()

    def section(name: str) -> Array:
        start = lines.index(name) + 2
        count = int(lines[start - 1])
        return np.array([line.split() for line in lines[start : start + count]], float)

    cells = section("volumeelements").astype(np.int64)
    return oriented(section("points"), cells[:, [2, 3, 5, 4]] - 1, cells[:, 0])


def write_tetgen(path: Path, part: Part) -> None:
    """Write a .node file, and beside it .ele and .face."""
    facets, label, _ = labels(part)
    files = {
        ".node": (f"{len(part.points)} 3 0 0", part.points, None),
        ".ele": (f"{len(part.cells)} 4 1", part.cells + 1, part.region),
        ".face": (f"{len(facets)} 1", facets + 1, label),
    }
    for suffix, (head, rows, last) in files.items():
        number = np.arange(1, len(rows) + 1)
        with path.with_suffix(suffix).open("w", encoding="ascii") as file:
            file.write(head + "\n")
            _rows(file, rows, last, number)


def read_tetgen(path: Path) -> Part:
    """Read a .node file and the .ele file beside it."""
    points = np.loadtxt(path, skiprows=1)[:, 1:4]
    cells = np.loadtxt(path.with_suffix(".ele"), skiprows=1, dtype=np.int64)
    return oriented(points, cells[:, 1:5] - 1, cells[:, 5])


def _rows(file, rows: Array, last: Array | None = None, number: Array | None = None) -> None:
    form = " ".join(["%d" if rows.dtype.kind == "i" else "%.17g"] * rows.shape[1])
    columns = [rows]
    if number is not None:
        form, columns = f"%d {form}", [number, *columns]
    if last is not None:
        form, columns = f"{form} %d", [*columns, last]
    np.savetxt(file, np.column_stack(columns), fmt=form)
