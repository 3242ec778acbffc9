"""Dive logs with hidden effects. Read first `draw`, then `trials`, `dynamics` and `catalogue`."""

from .draw import draw

__all__ = ["draw"]
