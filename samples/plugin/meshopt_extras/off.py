"""A format: OFF, surfaces of triangles as text."""

from pathlib import Path

import numpy as np

from meshopt_cli.plugins import Block, Encoding, Format, Mesh, UnreadableError


def read(path: Path, data: bytes, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Read triangles; other faces are refused."""
    words = b"\n".join(line.split(b"#")[0] for line in data.splitlines()).split()
    if not words or words[0] != b"OFF":
        raise UnreadableError("it does not begin with OFF")
    n, m = int(words[1]), int(words[2])
    numbers = np.array(words[4:], dtype=float)
    points, faces = numbers[: 3 * n].reshape(n, 3), numbers[3 * n : 3 * n + 4 * m]
    if len(faces) < 4 * m or (faces[::4] != 3).any():
        raise UnreadableError("its faces are not all triangles")
    return Mesh(points, [Block("triangle", faces.reshape(m, 4)[:, 1:].astype(np.int64))]), []


def fit(mesh: Mesh, encoding: Encoding) -> tuple[Mesh, list[str]]:
    """Leave out all but points and triangles."""
    kept = [Block(b.type, b.cells) for b in mesh.blocks if b.type == "triangle"]
    dropped = [f"the cells of type {b.type}" for b in mesh.blocks if b.type != "triangle"]
    dropped += [*mesh.point_data, *(name for b in mesh.blocks for name in b.data)]
    if not kept:
        raise ValueError("it holds triangles alone")
    return Mesh(mesh.points, kept), dropped


def write(path: Path, mesh: Mesh, encoding: Encoding) -> None:
    """Write points and triangles."""
    rows = np.concatenate([block.cells for block in mesh.blocks])
    points = np.pad(mesh.points, ((0, 0), (0, 3 - mesh.points.shape[1])))
    with path.open("w") as stream:
        stream.write(f"OFF\n{len(points)} {len(rows)} 0\n")
        stream.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
        stream.writelines(f"3 {a} {b} {c}\n" for a, b, c in rows.tolist())


OFF = Format(
    "off", "OFF", (".off",), Encoding("off", "", binary=False), "OFF, triangles as text",
    0, "face", "vertex", read, fit, write, by_name=True,
)  # fmt: skip
