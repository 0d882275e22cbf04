"""Formulas of one cell: measures, angles, types."""
