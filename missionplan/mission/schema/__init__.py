"""Sections of a mission file, in SI once validated.

Read first `section` and `quantities` (on `quantity_parser`), then `phases`, `site`, `navigation` and `vehicle`.
"""
