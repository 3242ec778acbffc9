"""How long legs take: their durations in trials of the mission."""

from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission.schema.phases import TransitPhase
from missionplan.montecarlo.streams import BlockStreams
from missionplan.phases.transit.transit import transit
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.transit_streams import deployed, transit_normals

TRIALS = 1024
"""Trials from which the 99 % durations are taken."""
SHARE = 0.99
_MOST_POINTS = 2_000_000
"""Points of tracks that are kept at once, which bounds the memory."""


@dataclass(frozen=True)
class TransitDurations:
    """Durations that 99 % of the trials keep.

    Attributes
    ----------
    legs : array, shape (m,)
        Under way, by the number of the leg, of the trials that sail it [s].
    whole : float
        Of the trials that arrive, from the first dive to the fix on arrival; nan where none does [s].
    """

    legs: Array
    whole: float

    def leg(self, number: int) -> float:
        """Duration of a leg, from 0; that of the longest leg where no trial needed so many [s]."""
        if number < len(self.legs):
            return float(self.legs[number])
        return float(self.legs.max()) if len(self.legs) else float("nan")


def transit_durations(
    means: Scenario, phase: TransitPhase[Scalars], start: Array, begins: float, seed: int, trials: int = TRIALS
) -> TransitDurations:
    """Sail a transit alone, from its nominal start.

    Parameters
    ----------
    means : Scenario
        The mission at its means.
    phase : TransitPhase
    start : array, shape (2,)
        [m]
    begins : float
        Mission time of the first dive [s].
    seed, trials : int
    """
    trials = min(trials, max(_MOST_POINTS // means.navigation.max_legs, 1))
    drawn = means.sampled(seed=seed, block=0, size=trials)
    source = BlockStreams(seed, 0)
    state = replace(deployed(drawn, phase, start, source, trials), clock=np.full(trials, begins))
    normals = transit_normals(drawn, phase, source)
    with np.errstate(all="ignore"):  # a trial that cannot be computed has no duration
        _, record = transit(drawn.transit_plan(phase), state, normals, drawn.environment(phase), tracked=trials)
    time = record.track_time if record.track_time is not None else np.empty((1, trials))
    legs = time[1::2] - time[:-1:2]
    arrived = record.duration[record.arrived & np.isfinite(record.duration)]
    return TransitDurations(
        legs=np.array([_quantile(leg[np.isfinite(leg)]) for leg in legs if np.isfinite(leg).any()]),
        whole=_quantile(arrived) if arrived.size else float("nan"),
    )


def _quantile(durations: Array) -> float:
    return float(np.quantile(durations, SHARE))
