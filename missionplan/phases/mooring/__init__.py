"""Mooring: descent, hold and ascent of a vehicle pulled down by its anchor (Briggs et al., section III).

Read first `mooring` (the phase), then `descent`, `forces` and `motion`. `tied_pull_down` has the
descent of two bodies whose drift the line ties, `hold` the vehicle on its line. `profile` simulates the log of a
descent, and follows one descent for figures.
"""
