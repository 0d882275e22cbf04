"""What is known of Gmsh's elements without meshio, beside meshio."""

import numpy as np
import pytest

from meshopt_cli.formats.gmsh import order
from meshopt_cli.formats.gmsh.types import (
    FREQUENT,
    cell_types,
    code_of,
    element_of,
    has_code,
    known_elements,
)
from support.processes import run_python


def test_what_is_frequent_is_as_meshio_has_it():
    assert {kind: code for code, kind in FREQUENT.items()}.items() <= cell_types().items()
    for code, element in known_elements().items():
        assert element_of(code) == element
        assert not element.kind or (code_of(element.kind), has_code(element.kind)) == (code, True)
    assert element_of(10**6) is None
    assert not has_code("polygon")


@pytest.mark.parametrize("kind", FREQUENT.values())
def test_nodes_are_in_the_order_that_meshio_says(kind):
    from meshio.gmsh.common import _gmsh_to_meshio_order

    row = np.arange(element_of(code_of(kind)).n_nodes)[None]
    assert np.array_equal(order.from_gmsh(kind, row), _gmsh_to_meshio_order(kind, row))
    assert np.array_equal(order.to_gmsh(kind, order.from_gmsh(kind, row)), row)


def test_a_plain_file_needs_no_meshio(tmp_path):
    code = (
        "import sys; from pathlib import Path\n"
        "from meshopt_cli import formats\n"
        "from support.files import write; from support.meshes import tet_grid\n"
        f"path = write(Path({str(tmp_path)!r}) / 'a.msh', tet_grid(2)); formats.read(path)\n"
        "print('meshio' in sys.modules)"
    )
    assert run_python(code).splitlines()[-1] == "False"
