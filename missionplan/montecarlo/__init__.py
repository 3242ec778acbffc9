"""Named random streams, distributions, parallel blocks of trials, streaming statistics and sensitivities.

Read first `streams` and `distributions`; then `parallel`, which shares blocks and calls
among processes; then `statistics`, with `quantile_sketch`, and `sensitivity`.
"""
