"""Structured grids as cells: lines, quads or hexahedra, by how many directions they extend in."""

from __future__ import annotations

import math

import numpy as np

from ...mesh.model import Array
from ..sniff import UnreadableError
from .cells import NUMBERS, Cells

# A few numbers can describe a grid of any size: without arrays it has at most so many points.
MOST_POINTS = 1 << 22
_CELLS = ("vertex", "line", "quad", "hexahedron")
# Where the vertices of a cell stand, in steps along each of its directions.
_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))

# Number of points in each of three directions.
Dimensions = tuple[int, int, int]


def n_points(dimensions: Dimensions) -> int:
    """The number of points of a grid, the first direction running fastest."""
    return math.prod(dimensions)


def n_cells(dimensions: Dimensions) -> int:
    """The number of cells of a grid; a direction with one point only is none."""
    return math.prod(n - 1 for n in dimensions if n > 1) if min(dimensions) > 0 else 0


def require_bounded(dimensions: Dimensions, has_arrays: bool) -> None:
    """Refuse a grid that is larger than anything in its file speaks for.

    Raises
    ------
    UnreadableError
        It has no arrays and more than `MOST_POINTS` points, or a direction without any.
    """
    if min(dimensions) < 0:
        raise UnreadableError(f"its grid cannot have {dimensions} points")
    if not has_arrays and n_points(dimensions) > MOST_POINTS:
        raise UnreadableError(
            f"its grid has {n_points(dimensions)} points, and no values at them: "
            f"such a grid is read up to {MOST_POINTS} points"
        )


def cells_of(dimensions: Dimensions) -> Cells:
    """The cells of a grid, the first direction running fastest."""
    count = n_cells(dimensions)
    directions = [axis for axis in range(3) if dimensions[axis] > 1]
    step = np.cumprod([1, *dimensions[:2]])[directions]
    origin = np.zeros(1 if count else 0, np.int64)
    for axis in reversed(directions):
        along = np.arange(dimensions[axis] - 1) * step[directions.index(axis)]
        origin = (origin[:, None] + along).ravel()
    corners = np.array(_CORNERS[: 2 ** len(directions)])[:, : len(directions)] @ step
    width = len(corners)
    vertices = (origin[:, None] + corners).ravel()
    types = np.full(count, NUMBERS[_CELLS[len(directions)]], np.uint8)
    return Cells(vertices, np.arange(count + 1) * width, types)


def product(axes: list[Array]) -> Array:
    """The points whose coordinates are taken from three arrays, the first running fastest."""
    kind = np.result_type(*axes, np.float32) if axes[0].dtype.kind == "f" else np.float64
    z, y, x = np.meshgrid(*(axis.astype(kind) for axis in reversed(axes)), indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()])


def image(
    first: tuple[int, int, int],
    dimensions: Dimensions,
    origin: Array,
    spacing: Array,
    direction: Array,
) -> Array:
    """The points of an image, which lie in equal steps.

    Parameters
    ----------
    first : (int, int, int)
        The steps from the origin to the first point.
    origin, spacing : (3,) float64
    direction : (3, 3) float64
        The direction of each axis is a column.
    """
    axes = [(first[i] + np.arange(dimensions[i])) * spacing[i] for i in range(3)]
    if np.array_equal(direction, np.eye(3)):
        return product([axis + origin[i] for i, axis in enumerate(axes)])
    return origin + product(axes) @ direction.T
