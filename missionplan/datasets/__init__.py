"""Measured data: a folder with `dataset.yaml` and CSV files, read and checked.

Read first `table` (a CSV) and `reading` (the folder), which all kinds share, then a kind: `legs`,
`dives`, `summaries` or `tank`; `records` are what was measured.
"""
