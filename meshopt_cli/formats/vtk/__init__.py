"""VTK's files: without XML (`.vtk`), and with it (`.vtu` and the like)."""

from .cells import NUMBERS as CELL_TYPES
from .legacy import read as read_vtk
from .write import VTK_VERSIONS, VTU_VERSIONS, write_vtk, write_vtu
from .xml import read as read_xml

__all__ = ["CELL_TYPES", "VTK_VERSIONS", "VTU_VERSIONS", "read_vtk", "read_xml"]
__all__ += ["write_vtk", "write_vtu"]
