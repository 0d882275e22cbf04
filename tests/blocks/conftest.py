"""Blocks so small that small meshes have many."""

from __future__ import annotations

import pytest

from meshopt_cli.blocks import crew, partition


@pytest.fixture
def _small_blocks(monkeypatch):
    monkeypatch.setattr(partition, "LEAST_CELLS", 0)
    monkeypatch.setattr(partition, "BLOCK_CELLS", 400)
    monkeypatch.setattr(partition, "LEAST_PART", 0.0)
    monkeypatch.setattr(crew, "CHUNK", 40)
