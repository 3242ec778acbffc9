"""Dive logs with hidden effects. Read first `draw`, then `trials`, `dynamics` and `catalogue`."""

from .draw import draw, draw_sized, draw_worth

__all__ = ["draw", "draw_sized", "draw_worth"]
