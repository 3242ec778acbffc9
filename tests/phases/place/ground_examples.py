"""Small grids of depths for the tests."""

import numpy as np

from missionplan.phases.ground import Frame, Ground

STEP = 10.0


def ground(depth):
    """A grid whose first centre is the origin, cells of 10 m."""
    rows, columns = np.shape(depth)
    low, high = np.array([-STEP, -STEP]), np.array([columns * STEP, rows * STEP])
    places = np.stack(
        [axis.ravel() for axis in np.meshgrid(*(np.linspace(a, b, 9) for a, b in zip(low, high, strict=True)))]
    )
    return Ground(np.asarray(depth, dtype=np.float32), Frame.fitted(low, high, places, places / STEP))
