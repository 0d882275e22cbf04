"""No option of a pass takes what is no number, or one that no machine word or no mesh can hold."""

import math

import pytest

from meshopt_cli.cli.entry import status_of
from support.options import every_option, field_of

IMPOSSIBLE = ["nan", "inf", "-inf", str(2**63), str(-(2**63) - 1)]
every_impossible = pytest.mark.parametrize("value", IMPOSSIBLE)


def is_meant(kind, option, value):
    """Whether the table says that an option may be infinite."""
    return value == "inf" and field_of(kind, option).metadata["most"] == math.inf


@pytest.fixture
def refused(capsys, tmp_path):
    """Whether a command line is refused in one line that names the option; nothing is read."""

    def is_refused(kind, option, *arguments):
        capsys.readouterr()
        status = status_of(["optimize", str(tmp_path / "missing.vtk"), "out.vtk", *arguments])
        out, err = capsys.readouterr()
        (line,) = err.splitlines()
        return (status, out) == (2, "") and f"{kind.name}.{option}" in line

    return is_refused


@every_option
@every_impossible
def test_no_setting_is_impossible(kind, option, value, refused):
    """By `--set`: status 2, and one line that names the option."""
    if is_meant(kind, option, value):
        pytest.skip("it may be infinite")
    setting = f"{kind.name}.{option}={value}"
    assert refused(kind, option, "--passes", kind.name, "--set", setting)


@every_option
@every_impossible
def test_no_value_in_a_file_is_impossible(kind, option, value, refused, tmp_path):
    """In a pipeline file: status 2, and one line that names the option."""
    if is_meant(kind, option, value):
        pytest.skip("it may be infinite")
    path = tmp_path / "pipeline.toml"
    path.write_text(f'[[pass]]\nname = "{kind.name}"\n{option} = {value}\n')
    assert refused(kind, option, "--config", str(path))
