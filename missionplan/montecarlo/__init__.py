"""Named random streams, distributions, parallel blocks of trials, streaming statistics and sensitivities.

Read first `streams`, `distributions` and `draws`; then `parallel`, which shares blocks and calls
among processes; then `statistics`, with `quantile_sketch`, and `sensitivity`.
"""
