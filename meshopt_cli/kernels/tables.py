"""Local numbering of triangles and tetrahedra.

A cell of dimension d has the vertices 0..d and is positive when the last one lies to
the left of (above) the others. Facet i is the one opposite vertex i. A handle packs a
cell and a local number: `4 * cell + local`, in both dimensions.
"""

import numpy as np

# Facet i of a tetrahedron, turned so that (facet, i) is a positive cell.
TET_FACETS = np.array([[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]], dtype=np.int64)

# Facet i of a triangle, turned so that (facet, i) is a positive cell.
TRI_FACETS = np.array([[1, 2], [2, 0], [0, 1]], dtype=np.int64)

# Edge i j of a tetrahedron with its opposite edge k l, turned so that (i, j, k, l) is positive.
TET_EDGES = np.array(
    [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]],
    dtype=np.int64,
)

# Edges of a triangle: the ends of each, and the vertex opposite.
TRI_EDGES = np.array([[1, 2, 0], [2, 0, 1], [0, 1, 2]], dtype=np.int64)
