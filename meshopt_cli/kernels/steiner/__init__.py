"""Triangles without obtuse angles by Steiner points: a search that may split the boundary."""
