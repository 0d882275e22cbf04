"""Compiled kernels: flat loops over arrays, importing numpy, numba and each other only."""
