"""The current of a block of trials: a recorded one or a member of an ensemble, with the error expected of it."""

import numpy as np

from missionplan.arrays import Scalars
from missionplan.mission import Mission
from missionplan.mission.views import forecast_error
from missionplan.montecarlo.streams import NormalSource
from missionplan.phases.currents import Current
from missionplan.phases.fields.ensemble import Ensemble
from missionplan.phases.fields.forecast_error import NORMALS, WAVES, ErringCurrent, ErrorWaves, Statistics

ERROR = "site.current.error"
"""Key path of the error, and name of its stream."""
MEMBER = "site.current.member"
"""Name of which member of an ensemble a trial sails in, and of its stream."""


def error_statistics(mission: Mission[Scalars]) -> Statistics | None:
    """Return the statistics of a forecast's error, as drawn; None where the mission expects none."""
    error = forecast_error(mission)
    return None if error is None else Statistics(error.sigma, error.time, error.length)


def with_member(recorded: Current, source: NormalSource, size: int) -> Current:
    """Return an ensemble with a member drawn for each trial; any other current as it is."""
    if not isinstance(recorded, Ensemble):
        return recorded
    return recorded.drawn(source.legs(MEMBER).leg(0)[0, :size])


def with_error(forecast: Current, statistics: Statistics | None, source: NormalSource, size: int) -> Current:
    """Return a forecast with an error drawn for each trial; itself where there is none."""
    if statistics is None:
        return forecast
    stream = source.legs(ERROR)
    pairs = NORMALS // 2
    normals = np.concatenate([stream.leg(number)[:, :size] for number in range(pairs * WAVES)])
    waves = normals.reshape(WAVES, NORMALS, size).transpose(1, 0, 2)
    return ErringCurrent(forecast, ErrorWaves.drawn(statistics, waves))
