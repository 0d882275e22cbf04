"""Files and pipes that something is written to, whatever it is."""
