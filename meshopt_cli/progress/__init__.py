"""How far a run is: what it tells while it works, and the lines that show it."""
