"""Gmsh's MSH files: versions 1 to 4.1 are read, 2.2 and 4.1 are written, text and binary."""
