"""If the vehicle does not come back: when it is expected, when to worry, and where to search.

Read first `overdue` (times, and areas of highest density), then `losses` (where trials end) and `drift` (afloat).
"""
