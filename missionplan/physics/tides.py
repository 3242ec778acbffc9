"""Tidal constituents: their angular frequencies, and what the moon's node makes of them at a moment.

Frequencies, Greenwich arguments and nodal corrections are those of UTide [1]_ (Foreman's tables). UTide is imported
when first used, because it loads SciPy's signal processing.

References
----------
.. [1] D. L. Codiga, "Unified Tidal Analysis and Prediction Using the UTide Matlab Functions", Technical Report 2011-01,
   Graduate School of Oceanography, University of Rhode Island, 2011; Python version by W. Bowman and others.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from missionplan.arrays import Array, Scalars

EPOCH_DAY = 719163.0
"""The 1st of January 1970 in the days of Python's calendar, which UTide counts in [d]."""
DAY = 86400.0
LEAST_LATITUDE = np.radians(5.0)
"""Nearer the equator the nodal corrections of diurnal constituents are those of this latitude, as in UTide [rad]."""


@dataclass(frozen=True)
class NodalState:
    """Constituents at a moment, or at d of them.

    The tide of one is ``f·A·cos(V + u − g)`` with the Greenwich phase lag g.
    """

    factor: Array
    """f, by which the node changes the amplitude, shape (k,) or (k, d)."""
    angle: Array
    """u, by which the node changes the phase, shape (k,) or (k, d) [rad]."""
    argument: Array
    """V, the astronomical argument at Greenwich, shape (k,) or (k, d) [rad]."""


def angular_frequencies(names: Sequence[str]) -> Array:
    """Angular frequencies of constituents, shape (k,) [rad/s].

    Parameters
    ----------
    names : sequence of str
        Such as ``M2``.

    Raises
    ------
    KeyError
        When UTide has no such constituent.
    """
    from utide._ut_constants import ut_constants

    cycles_per_hour = np.asarray(ut_constants["const"].freq, dtype=float)
    return 2.0 * np.pi * cycles_per_hour[_indices(names)] / 3600.0


def nodal_state(names: Sequence[str], moment: Scalars, latitude: float) -> NodalState:
    """Nodal corrections and Greenwich arguments of constituents at a moment.

    They change by less than 1 % in a month, so that one moment serves a mission.

    Parameters
    ----------
    names : sequence of str
        Such as ``M2``.
    moment : float or array, shape (d,)
        Seconds since the start of 1970, UTC.
    latitude : float
        [rad]

    Raises
    ------
    KeyError
        When UTide has no such constituent.
    """
    from utide.harmonics import FUV

    days = EPOCH_DAY + np.atleast_1d(moment) / DAY
    south = -1.0 if latitude < 0.0 else 1.0
    north = south * max(abs(latitude), LEAST_LATITUDE)
    found = FUV(days, days[0], _indices(names), np.degrees(north), [0, 0, 0, 0])
    factor, angle, argument = (each.T if np.ndim(moment) else each[0] for each in found)
    return NodalState(factor, 2.0 * np.pi * angle, 2.0 * np.pi * argument)


@cache
def constituent_names() -> tuple[str, ...]:
    """Names of all constituents that UTide knows."""
    from utide._ut_constants import constit_index_dict

    return tuple(constit_index_dict)


def _indices(names: Sequence[str]) -> "np.ndarray[tuple[int], np.dtype[np.intp]]":
    from utide._ut_constants import constit_index_dict

    return np.array([constit_index_dict[name] for name in names], dtype=np.intp)
