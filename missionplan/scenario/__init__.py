"""A mission at its means or with the draws of a block of trials, as the parameters that its phases take.

Read first `scenario`, then `mooring` and `transition`; the other modules supply what these need. Studies and diagnosis
both stand on it.
"""
