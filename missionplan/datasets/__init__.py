"""Measured data: a folder with `dataset.yaml` and CSV files, read and checked.

Read first `table` (a CSV) and `reading` (the folder), which all kinds share, then a kind: `legs` (with `leg_checks`),
`dives` and `summaries` (with `runs`), or the folder `tank`.
"""
