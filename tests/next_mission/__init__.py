"""The planner's loop from end to end: a log, its diagnosis, the next mission planned with it, and that mission at sea."""
