"""Named random streams, distributions, parallel blocks of trials, streaming statistics and sensitivities.

Read first `streams`, `distributions` and `draws`; then `parallel_blocks` and `parallel_map`, which share the process
`pool`; then `statistics`, with `quantile_sketch` and `running_statistics`, and `sensitivity`.
"""
