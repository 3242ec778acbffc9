"""A mission at its means or with the draws of a block of trials, as the parameters that its phases take.

Read first `scenario` (on `drawn_mission`, `transits`), then `phases` with `anchors`. `site_current` reads the current
where it is in a file, `place` ground, coast and tide. Studies and diagnosis both build on this package.
"""
