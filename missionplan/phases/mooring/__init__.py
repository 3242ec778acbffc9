"""Mooring: descent, hold and ascent of a vehicle pulled down by its anchor (Briggs et al., section III).

Read first `mooring` (the phase), then `descent`, `forces`, `vertical_motion` and `ascent`; `depth_sensor` is what a log
of the descent shows, `profile` one descent for figures, `subset_effect` effects on some of the trials.
"""
