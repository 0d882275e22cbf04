"""Blocks of a large mesh, in which sweeps go on at once, with the same result on any machine.

Which blocks there are depends on the mesh alone, and not on how many threads work on them. A sweep
visits what lies inside of blocks, whose threads share the arrays of the mesh and never meet; then
what is left on their rims, in other blocks; and at last what is left then, in one thread.
"""
