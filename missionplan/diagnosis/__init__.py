"""Measured data in; what the simulation gets wrong, why, and what the extended model gains out.

Read first `diagnose` (the study), then `pipeline` and `verdict`. `inference` is the method; `legs`, `dives`,
`summaries` and `tank` are one kind of data each.
"""
