"""What missions and data sets are good for, found without running anything.

Read first `validate`; `missions` and `datasets` check one file each and are imported when there is one: `validate` of a
mission imports neither pandas nor scipy's larger parts.
"""
