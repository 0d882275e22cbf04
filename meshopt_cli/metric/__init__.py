"""Meshes seen in a metric (18.3): sizes and directions that edges should have."""
