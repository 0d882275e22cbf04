"""How long the tests go on that try things at random: `MESHOPT_FUZZ=20000 pytest tests/fuzz`."""

from __future__ import annotations

import os


def cases(default: int) -> int:
    """How many cases to try: what the environment says, or a share that is soon done."""
    return int(os.environ.get("MESHOPT_FUZZ", default))
