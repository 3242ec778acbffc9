"""Sections of a mission file, in SI once validated.

Read first `section` and `quantity_parser`, then `phases`, `site` and `vehicle`.
"""
