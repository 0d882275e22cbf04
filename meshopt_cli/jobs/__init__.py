"""Whole jobs, from mesh to mesh or from file to verdict."""
