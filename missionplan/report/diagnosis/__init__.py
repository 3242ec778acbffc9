"""Report of `diagnose`: the page, the causes in words, the plan before and after, and the figures."""
