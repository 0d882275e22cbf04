"""Pictures: what is needed for them, and what is in them."""

from __future__ import annotations

import io

import numpy as np
import pytest

from meshopt_cli.pictures.library import missing
from meshopt_cli.pictures.scene import scene_of
from meshopt_cli.quality.measurable import measurable
from meshopt_cli.quality.measures import DEFAULT_MEASURE, MEASURES

needs_pictures = pytest.mark.skipif(bool(missing()), reason=missing())


def scene(one, measure=DEFAULT_MEASURE):
    """A mesh as it is looked at."""
    return scene_of(one, measurable(one), MEASURES[measure])


def pixels(png):
    """A picture as (height, width, 4) uint8."""
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(png)).convert("RGBA"))


def is_png(data):
    return data.startswith(b"\x89PNG\r\n\x1a\n")
