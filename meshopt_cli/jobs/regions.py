"""What a user says of the regions of a mesh, and what is asked back."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np

from ..mesh.cast import Simplices
from ..mesh.model import Mesh
from ..mesh.tags import MAX_LABELS, Regions, doubtful_tags, with_regions

log = logging.getLogger("meshopt")

# Regions whose borders are more than this part of the facets inside a mesh are hardly regions.
MOST_BORDERS = 0.5


def with_asked_regions(path: Path, mesh: Mesh, names: tuple[str, ...]) -> Mesh:
    """The mesh of a file, in which some arrays make regions; without any, all tags do.

    Arrays that may be meant to, and do not because they have many values, are named in a warning.

    Raises
    ------
    ConfigError
        See `tags.with_regions`.
    """
    if names:
        return with_regions(mesh, names)
    for name, n in doubtful_tags(mesh).items():
        log.warning(
            "%s: the array %s has %d values, and makes no regions: more than %d; "
            "if it is to, say --region %s",
            path, name, n, MAX_LABELS, name,
        )  # fmt: skip
    return mesh


def doubt_regions(part: Simplices, regions: Regions) -> None:
    """Warn of regions that leave nothing to work on, as the colours of cells do."""
    within = np.count_nonzero(part.neighbours >= 0)
    if len(part.inner) > MOST_BORDERS * (within + len(part.inner)):
        log.warning(
            "the %d regions that %s makes have borders all over, and what lies between regions "
            "stays: if they are no regions, name the arrays that make them (--region)",
            regions.count, " and ".join(regions.arrays),
        )  # fmt: skip
