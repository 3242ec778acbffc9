"""The tide in a record of a current: constituents with errors, a mean, what is left, and a fragment of a mission.

Read first `find_tide`, then `record` (what is read), `harmonic_analysis` (the fit, by UTide) and `residual` (its spread
and how long it lasts).
"""
