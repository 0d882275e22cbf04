"""Damaged files of every format: one clear line, in little time and memory, or a mesh.

`MESHOPT_FUZZ=20000 pytest tests/fuzz/test_mutations.py` goes on for longer, and
`python tests/fuzz/one.py NUMBER` runs one case and keeps its file.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.fuzz import cases

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/statm").exists(), reason="how much memory is taken, as Linux tells it"
)
BATCH = 250
ONE = Path(__file__).with_name("one.py")


def batch(first, n):
    """Run cases in a process of their own; what was wrong with which."""
    child = subprocess.run(
        [sys.executable, str(ONE), "--batch", str(first), str(n)],
        capture_output=True, text=True, timeout=60 + 6 * n, check=False,
        env={**os.environ, "MESHOPT_TRACEBACK": ""},
    )  # fmt: skip
    lines = [json.loads(line) for line in child.stdout.splitlines() if line.startswith("{")]
    done = sum("status" in line for line in lines)
    wrong = [line for line in lines if line["wrong"]]
    if done < n:  # it ended the process
        wrong.append(
            {"case": first + done, "wrong": f"ended by {child.returncode}: {child.stderr[-500:]}"}
        )
        if done + 1 < n:
            wrong += batch(first + done + 1, n - done - 1)
    return wrong


def test_damaged_files():
    n = cases(400)
    wrong = [one for first in range(0, n, BATCH) for one in batch(first, min(BATCH, n - first))]
    assert not wrong, "\n".join(f"{one['case']}: {one['wrong']}" for one in wrong)
