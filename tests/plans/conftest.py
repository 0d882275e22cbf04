"""Pipeline files, and what becomes of them."""

import pytest

from meshopt_cli.plans.config import Request, plan_for
from support.options import refused


@pytest.fixture
def pipeline_file(tmp_path):
    """Write a pipeline file."""

    def write(text):
        path = tmp_path / "pipeline.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def planned(pipeline_file):
    """The pipeline of a file, and of options beside it."""

    def plan(text, **options):
        return plan_for(Request(config=pipeline_file(text), **options))

    return plan


@pytest.fixture
def refusal(pipeline_file):
    """What is said about a pipeline file: one line."""
    return lambda text, **options: refused(config=pipeline_file(text), **options)
