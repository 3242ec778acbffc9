"""If the vehicle does not come back: when it is expected, when to worry, and where to search.

Read first `overdue` (times and what is made of the trials), then `search_areas` (where it may be).
"""
