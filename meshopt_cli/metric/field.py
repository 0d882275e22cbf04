"""A metric at the vertices of a mesh: sizes, or symmetric positive definite tensors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import ConfigError
from ..mesh.model import Array

# Where the components of a tensor stand in its matrix, by how many there are: the lower triangle
# row by row, (xx, xy, yy, xz, yz, zz), as files of Medit have them.
ROWS = {3: np.array([0, 1, 1]), 6: np.array([0, 1, 1, 2, 2, 2])}
COLUMNS = {3: np.array([0, 0, 1]), 6: np.array([0, 0, 1, 0, 1, 2])}

# The components of a symmetric tensor in other orders, and from where ours are taken.
MEDIT, VTK = "medit", "vtk"
ORDERS = {
    MEDIT: {3: ("xx, xy, yy", [0, 1, 2]), 6: ("xx, xy, yy, xz, yz, zz", [0, 1, 2, 3, 4, 5])},
    VTK: {3: ("xx, yy, xy", [0, 2, 1]), 6: ("xx, yy, zz, xy, yz, xz", [0, 3, 1, 5, 4, 2])},
}
FULL = {4: 2, 9: 3}  # all components of a matrix, row by row

# A matrix is symmetric if it differs from its transpose by no more than this part of its greatest
# entry: what single precision leaves.
ASYMMETRY = 1e-5
# Eigenvalues have these limits, so that no determinant leaves the range of numbers, and are at
# least this part of the greatest, below which their sign is rounding.
LEAST, GREATEST, FLAT = 1e-90, 1e90, 1e-15
N_NAMED = 3  # vertices that a message names


@dataclass(frozen=True)
class Metric:
    """A metric at each vertex.

    Attributes
    ----------
    values : (np, 1), (np, 3) or (np, 6) float64
        Sizes h: the length that edges should have, M = I / h^2. Or tensors M of the plane,
        (xx, xy, yy), or of space, (xx, xy, yy, xz, yz, zz), in which edges should have length 1:
        their eigenvalues are 1 / h^2 in the direction of the eigenvectors (18.15).
    source : str
        Where it comes from, in words.
    """

    values: Array
    source: str

    @property
    def is_isotropic(self) -> bool:
        """Whether it has sizes only."""
        return self.values.shape[1] == 1

    @property
    def kind(self) -> str:
        return "sizes" if self.is_isotropic else "tensors"

    @property
    def width(self) -> int:
        """Rows of the matrices of tensors: 2 in the plane, 3 in space."""
        return 2 if self.values.shape[1] == 3 else 3

    @cached_property
    def matrices(self) -> Array:
        """M as matrices, (np, 2, 2) or (np, 3, 3)."""
        if self.is_isotropic:
            return np.eye(3) / self.values[:, :, None] ** 2
        return matrices(self.values)

    @cached_property
    def maps(self) -> Array:
        """T of each vertex, (np, 3, 3), upper triangular with T^t T = M.

        It takes the space of the metric to the usual one, as H P^-1 of (18.15) does up to a turn,
        by which nothing changes. ((18.16) prints H P, whose transpose times itself is not M.)
        """
        result = np.zeros((len(self.values), 3, 3))
        result[:, 2, 2] = 1.0  # the plane of a metric with two rows is that of x and y
        d = self.width
        result[:, :d, :d] = np.linalg.cholesky(self.matrices).transpose(0, 2, 1)
        return result

    @cached_property
    def logarithms(self) -> Array:
        """Logarithms of the tensors, with the components of `values`."""
        values, axes = np.linalg.eigh(self.matrices)
        return components((axes * np.log(values)[:, None, :]) @ axes.transpose(0, 2, 1))

    def of_plane(self) -> Metric:
        """The same for vectors of the plane of x and y: what tensors say of others is left out."""
        return Metric(self.values[:, :3], self.source) if self.values.shape[1] == 6 else self


def matrices(values: Array) -> Array:
    """Components of symmetric tensors as matrices, (n, d, d)."""
    k = values.shape[1]
    d = int(ROWS[k][-1]) + 1
    result = np.empty((len(values), d, d))
    result[:, ROWS[k], COLUMNS[k]] = values
    result[:, COLUMNS[k], ROWS[k]] = values
    return result


def exponential(logarithms: Array) -> Array:
    """Components of tensors from those of their logarithms."""
    values, axes = np.linalg.eigh(matrices(logarithms))
    return components((axes * np.exp(values)[:, None, :]) @ axes.transpose(0, 2, 1))


def components(of: Array) -> Array:
    """The components of symmetric matrices, (n, 3) or (n, 6)."""
    k = 3 if of.shape[1] == 2 else 6
    return of[:, ROWS[k], COLUMNS[k]]


def from_array(
    values: Array,
    used: Array,
    source: str,
    order: str | None = None,
    name: Callable[[int], str] = "vertex {}".format,
) -> Metric:
    """A metric from an array with one row a vertex.

    Parameters
    ----------
    values : (np,) or (np, k)
        Sizes; or tensors with 3 or 4 components in the plane, 6 or 9 in space.
    used : (np,) bool
        Which vertices cells have. What stands at others does not matter.
    source : str
        What messages and reports call it; the order of components is added if one is given.
    order : str
        A key of `ORDERS`: where the 3 or 6 components of a symmetric tensor stand; without it they
        are as in `Metric`. 4 and 9 are all components row by row.
    name : function of the number of a vertex
        What messages call it.

    Raises
    ------
    ConfigError
        It does not fit the mesh, or is no metric at some vertices: the first of them are named.
    """
    table = np.asarray(values, dtype=np.float64)
    table = table.reshape(len(table), -1) if table.size else table.reshape(len(table), 1)
    if len(table) != len(used):
        raise ConfigError(
            f"the metric has {len(table):,} rows ({source}), and the mesh {len(used):,} vertices"
        )
    k = table.shape[1]
    if k != 1 and k not in ROWS and k not in FULL:
        raise ConfigError(
            f"{source} has {k} components: a metric has 1 (sizes), or as tensors 3 or 4 in the "
            "plane, 6 or 9 in space"
        )
    finite = np.asarray(np.isfinite(table).all(axis=1))
    require(used, finite, f"{source}: not finite", name)
    table = np.where(used[:, None], table, float(k == 1))
    if k == 1:
        require(used, table[:, 0] > 0.0, f"{source}: a size that is not positive", name)
        fits = (table[:, 0] > GREATEST**-0.5) & (table[:, 0] < LEAST**-0.5)
        require(used, fits, f"{source}: a size beyond all bounds", name)
        return Metric(np.ascontiguousarray(table), source)
    if k in FULL:
        whole = table.reshape(len(table), FULL[k], FULL[k])
        apart = np.abs(whole - whole.transpose(0, 2, 1)).max(axis=(1, 2))
        is_symmetric: Array = apart <= ASYMMETRY * np.abs(table).max(axis=1)
        require(used, is_symmetric, f"{source}: a tensor that is not symmetric", name)
        table = components((whole + whole.transpose(0, 2, 1)) / 2)
    elif order is not None:
        told, places = ORDERS[order][k]
        table = table[:, places]
        source = f"{source} ({told})"
    table[~used] = components(np.eye(3 if table.shape[1] == 6 else 2)[None])
    return Metric(np.ascontiguousarray(table), source)


def in_order(metric: Metric, order: str) -> Array:
    """The values of a metric as an array for a file: `from_array` takes them back.

    Parameters
    ----------
    order : str
        A key of `ORDERS`.
    """
    if metric.is_isotropic:
        return metric.values[:, 0]
    _, places = ORDERS[order][metric.values.shape[1]]
    result = np.empty_like(metric.values)
    result[:, places] = metric.values
    return result


def require_definite(
    metric: Metric, used: Array, name: Callable[[int], str] = "vertex {}".format
) -> Metric:
    """The metric, if its tensors are positive definite wherever cells have a vertex.

    Raises
    ------
    ConfigError
        They are not: the first vertices are named.
    """
    if metric.is_isotropic:
        return metric
    with np.errstate(over="ignore", invalid="ignore"):
        eigenvalues = np.linalg.eigvalsh(metric.matrices)
    least, greatest = eigenvalues[:, 0], eigenvalues[:, -1]
    is_definite = least > FLAT * np.maximum(greatest, 0.0)
    require(used, is_definite, f"{metric.source}: a tensor not positive definite", name)
    fits = (least > LEAST) & (greatest < GREATEST)
    require(used, fits, f"{metric.source}: a tensor beyond all bounds", name)
    return metric


def require(used: Array, good: Array, what: str, name: Callable[[int], str]) -> None:
    """Refuse a metric that is not good at some vertices of cells.

    Parameters
    ----------
    used, good : (np,) bool
    what : str
        What is wrong with it there.
    name : function of the number of a vertex

    Raises
    ------
    ConfigError
        The first of them are named.
    """
    bad = np.flatnonzero(used & ~good)
    if not len(bad):
        return
    named = [name(int(i)) for i in bad[:N_NAMED]]
    more = f" and {len(bad) - len(named):,} more" if len(bad) > len(named) else ""
    raise ConfigError(f"{what} at {', '.join(named)}{more}")


def fitted(metric: Metric, is_flat: bool) -> Metric:
    """A metric as the cells of a mesh see it: in the plane of x and y, tensors of the plane.

    Parameters
    ----------
    is_flat : bool
        Whether the mesh lies in a plane z = const.

    Raises
    ------
    ConfigError
        It is one of the plane, and the mesh does not lie in such.
    """
    if is_flat:
        return metric.of_plane()
    if metric.width == 2:
        raise ConfigError(
            f"{metric.source}: tensors of the plane, and the mesh does not lie in a plane z = const"
        )
    return metric
