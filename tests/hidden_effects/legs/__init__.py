"""Navigation logs with hidden effects. Read first `draw`, then `survey`, `sailing` and `catalogue`."""

from .draw import draw, draw_sized

__all__ = ["draw", "draw_sized"]
