"""What packages need that add passes, measures, formats or outputs by entry points.

| group | what a row is |
|---|---|
| `meshopt.passes` | a class: a frozen dataclass, a `Pass` with `name`, `summary` and `sweep` |
| `meshopt.measures` | a `Measure`, each `Way` of which has a `function` |
| `meshopt.formats` | a `Format` |
| `meshopt.outputs` | a `ReportOutput` |

`samples/plugin` is a package with one of each.
"""

from .errors import ConfigError, MeshoptError
from .formats import Encoding, Format
from .formats.sniff import UnreadableError
from .mesh.model import Block, Mesh
from .passes import PASSES, Operator, Pass, Work
from .passes.base import option
from .passes.run import Run
from .quality.measures import CONTENT, DEGREES, LENGTH, LESS, MORE, NUMBER, STERADIANS, Measure, Way
from .reports.model import Report
from .reports.outputs import Manner, ReportOutput

__all__ = [
    "CONTENT",
    "DEGREES",
    "LENGTH",
    "LESS",
    "MORE",
    "NUMBER",
    "PASSES",
    "STERADIANS",
    "Block",
    "ConfigError",
    "Encoding",
    "Format",
    "Manner",
    "Measure",
    "Mesh",
    "MeshoptError",
    "Operator",
    "Pass",
    "Report",
    "ReportOutput",
    "Run",
    "UnreadableError",
    "Way",
    "Work",
    "option",
]
