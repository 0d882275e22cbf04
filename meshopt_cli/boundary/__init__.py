"""What of the boundary may change, and the proof that the rest did not."""
