"""Blocks so small that small meshes have many."""

from __future__ import annotations

import pytest

from meshopt_cli.blocks import crew, partition
from meshopt_cli.blocks.turns import Reach


@pytest.fixture
def _small_blocks(monkeypatch):
    monkeypatch.setattr(partition, "LEAST_CELLS", {2: 0, 3: 0})
    monkeypatch.setattr(partition, "BLOCK_CELLS", 400)
    for parts in Reach:
        monkeypatch.setattr(parts.value, "least_part", 0.0)
    monkeypatch.setattr(crew, "CHUNK", 40)
