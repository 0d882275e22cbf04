"""meshopt: optimize, check and report on triangle and tetrahedral meshes."""

__version__ = "0.1.0"
