"""VTK's files: without XML (`.vtk`), and with it (`.vtu` and the like)."""
