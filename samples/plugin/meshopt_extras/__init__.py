"""A pass, a measure, a format and an output for meshopt."""
