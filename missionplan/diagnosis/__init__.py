"""Measured data in; what the simulation gets wrong, why, and what the extended model gains out.

Read first `diagnose` (the study), then `data_kind` (what a kind of data must offer) and
`pipeline`. `inference` is the statistical method; `legs`, `dives`, `summaries` and `tank` are one kind of data each.
"""
