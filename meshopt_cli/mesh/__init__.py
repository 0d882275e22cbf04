"""What a mesh is: what a file holds, and the simplices of it that are worked on."""
