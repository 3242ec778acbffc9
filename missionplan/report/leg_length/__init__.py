"""Reports of `sweep-dmax` and `plan-legs`."""
