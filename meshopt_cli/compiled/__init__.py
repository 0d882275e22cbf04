"""Functions to machine code: compiled by numba once, loaded without it after that."""
