"""Measured data: a folder with `dataset.yaml` and CSV files, read and checked; one module a kind.

Read first `reading` (what all kinds share), then `legs`, `dives`, `summaries` or `tank`.
"""
