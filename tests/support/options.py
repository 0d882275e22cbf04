"""Every option of every pass, and what is said about wrong ones."""

from dataclasses import fields

import pytest

from meshopt_cli.errors import ConfigError
from meshopt_cli.passes import PASSES
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.plans.pipeline import Pipeline
from meshopt_cli.plans.presets import PRESETS
from meshopt_cli.plans.stages import Repeat

DIMENSIONS = (2, 3)

# Presets for meshes without a metric.
PLAIN = [
    name
    for name, preset in PRESETS.items()
    if not Pipeline(name, preset.build(preset.stops[2], 2)).needs_metric
]

every_preset = pytest.mark.parametrize("preset", PRESETS)
every_dimension = pytest.mark.parametrize("dimension", DIMENSIONS)

OPTIONS = [(p, f.name.replace("_", "-")) for p in PASSES.values() for f in fields(p)]


def over_options(options):
    ids = [f"{kind.name}.{name}" for kind, name in options]
    return pytest.mark.parametrize(("kind", "option"), options, ids=ids)


every_option = over_options(OPTIONS)


def refused(**options):
    """What is said about options: one line."""
    with pytest.raises(ConfigError) as caught:
        plan_for(Request(**options))
    assert "\n" not in str(caught.value)
    return str(caught.value)


def names(pipeline):
    return [step.name for step in pipeline.passes()]


def rounds_of(pipeline):
    """The part that runs in rounds; there must be one."""
    (found,) = [stage for stage in pipeline.stages if isinstance(stage, Repeat)]
    return found


def field_of(kind, option):
    return next(f for f in fields(kind) if f.name == option.replace("-", "_"))


def another(kind, option):
    """A value of the option that is allowed and not the default."""
    f = field_of(kind, option)
    if f.metadata["choices"]:
        return next(c for c in f.metadata["choices"] if c != f.default)
    if f.metadata["most"] is None:
        return f.default + 1
    other = f.metadata["least"] if f.default == f.metadata["most"] else f.metadata["most"]
    return type(f.default)((f.default + other) / 2)
