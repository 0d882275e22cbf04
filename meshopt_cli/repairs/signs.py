"""Which cells could be valid as they are listed, or turned."""

from __future__ import annotations

import numpy as np

from ..cells import FAMILIES
from ..mesh.model import Array
from ..mesh.quads import corner_areas
from ..validity.examination import Examination
from ..validity.geometry import corner_volumes


def has_one_sign(study: Examination, cells: Array, family: str) -> Array:
    """Which cells have volumes, or areas in the plane, of one sign at all corners, (n,) bool.

    Parameters
    ----------
    cells : (n, k) int64
        By their corners; faces are those of a plane.
    """
    if FAMILIES[family].dimension == 3:
        size, flat = corner_volumes(study.points, study.noise, cells, family)
    else:
        assert study.plane is not None
        size, flat = corner_areas(*study.plane[:2], cells, family)
    alike = (np.sign(size) == np.sign(size[:, :1])).all(axis=1)
    return alike & ~flat.any(axis=1)
