"""When to go and what to choose: one or two keys of a mission varied on common random numbers.

Read first `explore`, then `variation` (what `--vary` says), `cells` (one cell) and `result` (the best cells, and the
windows in which the requirements are met).
"""
