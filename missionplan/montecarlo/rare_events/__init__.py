"""Probabilities of rare failures: subset simulation on the standard normals from which trials are drawn.

Read first `subset_simulation` (the method), then `population` (normals by name, drawn when first asked for) and
`estimate` (what independent repetitions say together).
"""
