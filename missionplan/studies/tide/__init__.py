"""The tide in a record of a current: constituents with errors, a mean, what is left, and a fragment of a mission.

Read first `find_tide`, then `result` (with the record that is read) and `harmonic_analysis` (the fit, by UTide).
"""
