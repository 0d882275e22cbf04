"""Vertices that are told where to stay (topologically driven node relocation, 18.4.1)."""
