"""What missions and data sets are good for, found without running anything.

Read first `validate`; `data_sets` is imported when there is one: `validate` of a mission imports neither pandas nor
scipy's larger parts.
"""
