"""Probabilities of rare failures: subset simulation on the standard normals from which trials are drawn.

Read first `subset_simulation` (the method, on normals by name, drawn when first asked for), then `strata` (what plain
trials and independent repetitions say together).
"""
