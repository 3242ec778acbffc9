"""`history`: what was learned of each parameter, from mission to mission."""
