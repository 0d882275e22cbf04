"""From options to a pipeline of passes, and its run."""
