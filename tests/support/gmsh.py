"""Small Gmsh files of every version, put together section by section, in text or in binary."""

import numpy as np

POINTS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1.0, 1.0)]


class Builder:
    """Writes the sections of a version, text or binary in an order of bytes.

    Parameters
    ----------
    version : str
        As the file is to spell it.
    """

    def __init__(self, version="4.1", binary=False, order="<"):
        self.spelled, self.version = version, float(version)
        self.binary, self.order = binary, order

    def line(self, *parts, text=False):
        """Numbers on a line: ("i4" | "c" | "f8", values) each, "c" a count of version 4."""
        if self.binary and not text:
            kinds = {"c": "u8" if self.version > 4 else "i4"}
            return b"".join(
                np.ravel(values).astype(self.order + kinds.get(kind, kind)).tobytes()
                for kind, values in parts
            )
        flat = [str(v) for _, values in parts for v in np.ravel(values).tolist()]
        return (" ".join(flat) + "\n").encode()

    def section(self, name, *lines):
        """A section with some lines."""
        later = {"NOD": "END", "ELM": "END"}.get(name, "End")
        return f"${name}\n".encode() + b"".join(lines) + f"\n${later}{name}\n".encode()

    def header(self):
        """Nothing in version 1."""
        if self.version < 2:
            return b""
        one = self.line(("i4", 1)) if self.binary else b""
        return self.section("MeshFormat", f"{self.spelled} {int(self.binary)} 8\n".encode(), one)

    def names(self, *rows):
        """Lines of $PhysicalNames as they stand."""
        return self.section("PhysicalNames", f"{len(rows)}\n".encode(), "\n".join(rows).encode())

    def entities(self, *rows):
        """(dimension, tag, groups, bounds) each, by dimension."""
        counts = np.bincount([row[0] for row in rows], minlength=4)
        lines = [self.line(("c", counts), text=self.version < 4)]
        lines += [self._entity(*row) for row in rows]
        return self.section("Entities", *lines)

    def _entity(self, dimension, tag, groups, bounds):
        around = [("c", len(bounds)), ("i4", bounds)] if dimension else []
        of = [("c", len(groups)), ("i4", groups)]
        if self.version < 4:
            return self.line(("i4", tag), *around, *of, text=True)
        return self.line(("i4", tag), ("f8", self._box(dimension)), *of, *around)

    def _box(self, dimension):
        return [0.0] * (6 if dimension or self.version < 4.1 else 3)

    def partitioned(self, n, ghosts, *rows):
        """(dimension, tag, parent dimension, parent, partitions, groups) each."""
        counts = np.bincount([row[0] for row in rows], minlength=4)
        lines = [self.line(("c", n)), self.line(("c", len(ghosts)))]
        lines += [self.line(("i4", ghost)) for ghost in ghosts] + [self.line(("c", counts))]
        for dimension, tag, parent_dimension, parent, partitions, groups in rows:
            start = ("i4", (tag, parent_dimension, parent))
            parts = [("c", len(partitions)), ("i4", partitions)]
            end = [("c", len(groups)), ("i4", groups)] + [("c", 0)] * (dimension > 0)
            lines.append(self.line(start, *parts, ("f8", self._box(dimension)), *end))
        return self.section("PartitionedEntities", *lines)

    def nodes(self, points, blocks=()):
        """Nodes by number, {number: point}; blocks of version 4: (dimension, tag, numbers)."""
        if self.version < 4:
            rows = [self._node_of(number, point) for number, point in points.items()]
            name = "NOD" if self.version < 2 else "Nodes"
            return self.section(name, self._count(points), *rows)
        n = len(points)
        lines = [self._counts(len(blocks), n, min(points), max(points))]
        for dimension, tag, numbers in blocks:
            head = (dimension, tag) if self.version > 4 else (tag, dimension)
            lines.append(self.line(("i4", (*head, 0)), ("c", len(numbers))))
            if self.version > 4:
                lines += [self.line(("c", number)) for number in numbers]
                lines += [self.line(("f8", points[number])) for number in numbers]
            else:
                lines += [self.line(("i4", i), ("f8", points[i])) for i in numbers]
        return self.section("Nodes", *lines)

    def _node_of(self, number, point):
        alone = [("i4", 0)] if self.version >= 3 else []
        return self.line(("i4", number), ("f8", point), *alone)

    def _count(self, rows):
        return f"{len(rows)}\n".encode()

    def _counts(self, *four):
        return self.line(("c", four if self.version > 4 else four[:2]))

    def elements(self, *blocks):
        """(dimension, tag, code, group, {number: nodes}) each, with a partition at the end."""
        if self.version < 4:
            n = sum(len(block[4]) for block in blocks)
            rows = [
                self._element(number, nodes, *block[1:4], *block[5:])
                for block in blocks
                for number, nodes in block[4].items()
            ]
            name = "ELM" if self.version < 2 else "Elements"
            return self.section(name, f"{n}\n".encode(), *rows)
        numbers = [number for block in blocks for number in block[4]]
        lines = [self._counts(len(blocks), len(numbers), min(numbers), max(numbers))]
        for dimension, tag, code, _, rows, *_ in blocks:
            head = (dimension, tag) if self.version > 4 else (tag, dimension)
            kind = "c" if self.version > 4 else "i4"
            lines.append(self.line(("i4", (*head, code)), ("c", len(rows))))
            lines += [self.line((kind, (number, *nodes))) for number, nodes in rows.items()]
        return self.section("Elements", *lines)

    def _element(self, number, nodes, tag, code, group, partition=None):
        if self.version < 2:
            row = (number, code, group, tag, len(nodes), *nodes)
        elif self.version >= 3:
            parts = () if partition is None else (1, partition)
            row = (number, code, tag, len(nodes) + len(parts), *nodes, *parts)
        else:
            parts = () if partition is None else (1, partition)[self.version < 2.2 :]
            tags = (group, tag, *parts)
            if self.binary:
                row = (code, 1, len(tags), number, *tags, *nodes)
            else:
                row = (number, code, len(tags), *tags, *nodes)
        return self.line(("i4", row))

    def periodic(self, *links):
        """(dimension, tag, master, affine, pairs of nodes) each."""
        new = self.version > 4
        kinds = {"text": not new}
        lines = [self.line(("c", len(links)), **kinds)]
        for dimension, tag, master, affine, pairs in links:
            lines.append(self.line(("i4", (dimension, tag, master)), **kinds))
            if new:
                lines.append(self.line(("c", len(affine)), ("f8", affine)))
            elif affine:
                lines.append(b"Affine " + self.line(("f8", affine), text=True))
            lines.append(self.line(("c", len(pairs)), **kinds))
            lines += [self.line(("c", pair), **kinds) for pair in pairs]
        return self.section("Periodic", *lines)

    def view(self, section, name, values, time=0.0, step=0, partition=None):
        """Values by number of the node or element; without a name, there is no string tag."""
        width = len(np.ravel(next(iter(values.values()))))
        integers = [step, width, len(values), *([] if partition is None else [partition])]
        texts = [] if name is None else [f'"{name}"']
        head = [len(texts), *texts, 1, time, len(integers), *integers]
        lines = ["\n".join(map(str, head)).encode() + b"\n"]
        lines += [self.line(("i4", number), ("f8", value)) for number, value in values.items()]
        return self.section(section, *lines)


def two_tets(builder, numbers=(1, 2, 3, 4, 5), names=('2 3 "wall"', '3 7 "steel"')):
    """A file with two tetrahedra in group 7, on volume 1, and a triangle in group 3, on face 2."""
    a, b, c, d, e = numbers
    points = dict(zip(numbers, POINTS, strict=True))
    entities = b""
    if builder.version >= 3:
        entities = builder.entities((2, 2, [3], []), (3, 1, [7], [2]))
    return b"".join(
        (
            builder.header(),
            builder.names(*names) if builder.version >= 2 else b"",
            entities,
            builder.nodes(points, [(2, 2, (a, b, c)), (3, 1, (d, e))]),
            builder.elements(
                (2, 2, 2, 3, {1: (a, b, c)}), (3, 1, 4, 7, {2: (a, b, c, d), 3: (b, c, d, e)})
            ),
        )
    )


def shaken_square(n):
    """A unit square of 2 n^2 triangles, those inside out of shape: points and cells by number.

    Also the number of each point by column and row.
    """
    place = {(i, j): 1 + i + (n + 1) * j for i in range(n + 1) for j in range(n + 1)}
    random = np.random.default_rng(1)
    points, cells = {}, {}
    for (i, j), number in place.items():
        inside = 0 < i < n and 0 < j < n
        x, y = (i, j) + inside * random.uniform(-0.3, 0.3, 2)
        points[number] = (x / n, y / n, 0.0)
    for i in range(n):
        for j in range(n):
            a, b, c, d = (place[i + k, j + m] for m in (0, 1) for k in (0, 1))
            cells |= {2 * a: (a, b, d), 2 * a + 1: (a, d, c)}
    return points, cells, place
