"""Pictures of meshes; what they are drawn by is an extra, and imported in this room only."""
