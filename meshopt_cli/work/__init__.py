"""The working state of an optimization."""
