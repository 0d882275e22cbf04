"""The arrays of the input on the cells and vertices of the result."""
