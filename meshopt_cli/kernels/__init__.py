"""Compiled kernels: flat loops over arrays, importing numpy and each other only."""
