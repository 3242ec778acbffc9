"""Reports of what was learned from mission to mission."""
