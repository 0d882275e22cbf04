"""What a user says of the regions of a mesh, and what is asked back."""

from __future__ import annotations

import logging
from pathlib import Path

from ..mesh.model import Mesh
from ..mesh.tags import MAX_LABELS, doubtful_tags, with_regions

log = logging.getLogger("meshopt")


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
