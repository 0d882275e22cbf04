"""How much is tried: the same examples each time, or more and others when asked.

With `MESHOPT_MORE_EXAMPLES=N` in the environment property tests try N times as many, at random.
"""

from __future__ import annotations

import os

from hypothesis import HealthCheck, settings

VARIABLE = "MESHOPT_MORE_EXAMPLES"
MORE = int(os.environ.get(VARIABLE, "0"))

# Kernels may have to compile first, and machines differ: no example has a deadline.
settings.register_profile(
    "meshopt",
    deadline=None,
    derandomize=not MORE,
    max_examples=100 * max(MORE, 1),
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("meshopt")


def examples(n: int) -> settings:
    """Try n examples, or so many times more as are asked for."""
    return settings(max_examples=n * max(MORE, 1))
