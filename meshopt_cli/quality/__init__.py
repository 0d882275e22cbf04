"""How good a mesh is: measures, Table 18.3, what the boundary allows."""
