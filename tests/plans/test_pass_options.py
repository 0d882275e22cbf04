"""Options of passes: each has limits, and those that had another name say so."""

from __future__ import annotations

import math
from dataclasses import fields

import pytest

from meshopt_cli.cli.entry import status_of
from meshopt_cli.errors import EXIT_USAGE, ConfigError
from meshopt_cli.passes import PASSES
from meshopt_cli.plans.config import Request, plan_for
from meshopt_cli.plans.settings import RENAMED
from support.options import OPTIONS, field_of, over_options, refused

NUMBERS = [(k, o) for k, o in OPTIONS if not field_of(k, o).metadata["choices"]]
# In a pipeline file, which has words of its own for them.
NONSENSE = {"nan": "nan", "inf": "inf", "-inf": "-inf", f"{2**63}": f"{2**63}"}
FORMER = [
    (kind, old, new)
    for kind in PASSES.values()
    for old, new in RENAMED.items()
    if new in {f.name for f in fields(kind)}
]


@over_options(NUMBERS)
def test_every_number_has_limits(kind, option):
    f = field_of(kind, option)
    least, most = f.metadata["least"], f.metadata["most"]
    assert math.isfinite(least)
    assert math.isfinite(most)
    assert least <= f.default <= most
    for value in (least, most):
        assert getattr(kind(**{f.name: value}), f.name) == value
    for value in (least - 1, 2 * most + 1, math.nan, math.inf, -math.inf, 2.0**63):
        with pytest.raises(ConfigError, match=rf"{kind.name}\.{option}"):
            kind(**{f.name: value})


@pytest.mark.parametrize("value", NONSENSE)
@over_options(NUMBERS)
def test_no_number_is_beyond_all_limits(kind, option, value, tmp_path):
    """Neither on the command line nor in a file."""
    path = tmp_path / "pipeline.toml"
    path.write_text(f'[[pass]]\nname = "{kind.name}"\n{option} = {value}\n', encoding="utf-8")
    for message in (
        refused(passes=(kind.name,), settings=(f"{kind.name}.{option}={value}",)),
        refused(config=path),
    ):
        assert f"{kind.name}.{option}: " in message


@pytest.mark.parametrize("setting", ["smooth.worse-than=inf", f"smooth.seed={2**63}"])
def test_the_command_line_ends_with_its_status(setting, tmp_path, capsys):
    arguments = ["optimize", str(tmp_path / "in.vtk"), str(tmp_path / "out.vtk")]
    assert status_of([*arguments, "--set", setting]) == EXIT_USAGE
    assert setting.split("=")[0] in capsys.readouterr().err


@pytest.mark.parametrize(
    ("kind", "old", "new"), FORMER, ids=[f"{kind.name}.{old}" for kind, old, _ in FORMER]
)
def test_a_former_name_says_the_present_one(kind, old, new, tmp_path):
    path = tmp_path / "pipeline.toml"
    path.write_text(f'[[pass]]\nname = "{kind.name}"\n{old} = 1\n', encoding="utf-8")
    said = f"pass {kind.name} has no option '{old}': it is called '{new.replace('_', '-')}' now"
    assert said in refused(passes=(kind.name,), settings=(f"{kind.name}.{old}=1",))
    assert said in refused(config=path)


def test_a_former_name_is_none_of_today():
    today = {f.name for kind in PASSES.values() for f in fields(kind)}
    assert not today & set(RENAMED)
    assert set(RENAMED.values()) <= today


def test_a_former_name_of_another_pass_is_unknown():
    """It was never an option of this one."""
    assert "it is called" not in refused(passes=("smooth",), settings=("smooth.harm=0.5",))


def test_a_setting_changes_every_pass_of_its_kind_and_no_other():
    before = plan_for(Request(preset="best")).pipeline
    after = plan_for(Request(preset="best", settings=("swap.least-quality=0.15",))).pipeline
    pairs = list(zip(before.passes(), after.passes(), strict=True))
    assert any(one.name == "swap" for one, _ in pairs)
    for one, other in pairs:
        assert (one == other) == (one.name != "swap")
        assert getattr(other, "least_quality", 0.0) == (
            0.15 if one.name == "swap" else getattr(one, "least_quality", 0.0)
        )
