"""The kinds of working meshes, which passes say that they work on."""

SIMPLICES = "simplices"
CELLS = "cells"
