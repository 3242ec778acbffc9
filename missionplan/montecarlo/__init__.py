"""Named random streams, distributions, parallel blocks of trials, streaming statistics and sensitivities.

Read first `streams` and `distributions`; then `blocks`, which shares blocks and calls
among processes of the `pool` or a Dask cluster's workers; then `statistics`, with `quantile_sketch`, and `sensitivity`.
"""
