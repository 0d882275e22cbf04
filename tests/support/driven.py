"""Working meshes with a metric."""

from __future__ import annotations

import numpy as np

from meshopt_cli.kernels.types import MAPPED
from meshopt_cli.mesh.cast import cast
from meshopt_cli.metric.field import Metric, components
from meshopt_cli.quality.measures import QUALITIES
from meshopt_cli.transfer.background import MetricOfInput
from meshopt_cli.work.session import Workspace


def workspace_in(patch, matrices, measure="aspect-ratio", in_order=True):
    """A mesh as the kernels see it, in a metric of tensors at its points, (np, d, d)."""
    part = cast(patch)
    background = MetricOfInput(part, Metric(components(np.asarray(matrices)), "a test"))
    judge = QUALITIES[measure].judge._replace(form=MAPPED)
    return Workspace(part, judge, in_order=in_order, background=background)


def layered(points, least=0.03):
    """Tensors of the d columns of points: 0.3 wide along x, and up to ten times less across."""
    n, d = points.shape
    sizes = np.full((n, d), 0.3)
    sizes[:, 1] = least + 0.27 * np.abs(points[:, 1])
    turn = np.eye(d)
    turn[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    return np.einsum("ij,nj,kj->nik", turn, sizes**-2.0, turn)
