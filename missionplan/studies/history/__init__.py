"""`history`: what was learned of each parameter from mission to mission, read from the reports of `diagnose`."""
