"""What lies around a vertex or an edge: balls, shells, stars."""
