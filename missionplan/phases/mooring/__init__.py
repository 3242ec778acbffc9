"""Mooring: descent, hold and ascent of a vehicle pulled down by its anchor (Briggs et al., section III).

Read first `mooring` (the phase), then `descent`, `forces` and `vertical_motion`. `tied_pull_down` has the
descent of two bodies whose drift the line ties, `hold` the vehicle on its line. `depth_sensor` simulates the
log of a descent, `profile` follows one descent for figures, `subset_effect` applies an effect to some of the trials.
"""
