"""Ground, coast and sea level, as a block of trials sails over them.

Read first `place` (what a way meets), then `ground` (depths) and `zones` (polygons).
"""
