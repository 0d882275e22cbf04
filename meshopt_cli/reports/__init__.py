"""What a run or a mesh is said to be like, in one file an output format."""
