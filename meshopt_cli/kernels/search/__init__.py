"""Searches over many cells or points at once."""
