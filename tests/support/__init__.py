"""What the tests share: meshes, changes to them, drivers, and what must hold."""
