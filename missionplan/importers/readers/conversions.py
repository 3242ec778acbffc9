"""Degrees and times as logs write them."""

import numpy as np

from missionplan.arrays import Array


def ddmm_to_degrees(value: Array) -> Array:
    """Degrees from degrees and minutes written as one number: 4839.12 is 48° 39.12′, negative south and west."""
    size = np.abs(value)
    degrees = np.floor(size / 100.0)
    return np.asarray(np.sign(value) * (degrees + (size - 100.0 * degrees) / 60.0))
