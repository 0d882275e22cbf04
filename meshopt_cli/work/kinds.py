"""The kinds of working meshes, which passes say that they work on."""

SIMPLICES = "simplices"
FACES = "faces"  # triangles and quads in a plane
CELLS = "cells"  # solids
