"""Navigation logs with hidden effects. Read first `draw`, then `survey`, `sailing` and `catalogue`."""

from .draw import draw

__all__ = ["draw"]
