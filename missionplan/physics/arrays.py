"""The types that the core computes with."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Scalars = float | Array
"""A number, or an array over trials."""


def magnitude(value: Scalars) -> Scalars:
    """Absolute value that keeps a float a float: a stepped model runs five times faster on floats than on numpy's."""
    return np.abs(value) if isinstance(value, np.ndarray) else abs(value)
