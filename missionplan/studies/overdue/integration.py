"""Integration of the places of many vehicles at once: scipy's takes as long to import as the sheet takes to make."""

from collections.abc import Callable

import numpy as np

from missionplan.arrays import Array

_STAGES = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
_TIMES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
_ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
_SAFETY, _LEAST_FACTOR, _MOST_FACTOR = 0.9, 0.2, 10.0


def dormand_prince(
    rate: Callable[[float, Array], Array], start: Array, first: float, longest: float, tolerance: float
) -> Array:
    """Integrate from 0 to 1 by the Runge–Kutta method of Dormand and Prince (1980), with the steps that it needs.

    Parameters
    ----------
    rate : callable
        Of change of a state, at a moment and a state.
    start : array
        State at 0, of any shape.
    first, longest : float
        Steps.
    tolerance : float
        Error of a step, root of the mean square over the state, in the state's unit.

    Returns
    -------
    array
        State at 1.
    """
    moment, state, step = 0.0, start, min(first, 1.0)
    slope = rate(moment, state)
    while moment < 1.0:
        step = min(step, longest, 1.0 - moment)
        slopes, reached = [slope], state
        for when, shares in zip(_TIMES[1:], _STAGES[1:], strict=True):
            reached = state + step * sum(share * each for share, each in zip(shares, slopes, strict=True))
            slopes.append(rate(moment + when * step, reached))
        off = step * sum(share * each for share, each in zip(_ERROR, slopes, strict=True))
        error = float(np.sqrt(np.mean(np.square(off)))) / tolerance
        if error <= 1.0:
            moment = 1.0 if step >= 1.0 - moment else moment + step
            state, slope = reached, slopes[-1]
        step *= min(_MOST_FACTOR, max(_LEAST_FACTOR, _SAFETY * max(error, 1e-9) ** -0.2))
    return np.array(state)
