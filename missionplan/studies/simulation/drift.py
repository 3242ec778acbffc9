"""The drift of a vehicle afloat: with the surface current, the tide, the effects at the surface and the wind."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array
from missionplan.mission import Mission
from missionplan.mission.views import forecast_error
from missionplan.montecarlo.distributions import sd_of
from missionplan.montecarlo.streams import BlockStreams
from missionplan.phases.currents import Current, LayeredCurrent
from missionplan.phases.ensemble import Ensemble, ErringCurrent, Statistics
from missionplan.phases.hooks import TransitEffect, surface_velocity
from missionplan.phases.place import Cause, Place, Way
from missionplan.phases.recorded_currents import RecordedCurrent
from missionplan.scenario.scenario import STILL_WATER, Scenario
from missionplan.scenario.site_current import with_error

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
            reached = state + step * sum(share * slope for share, slope in zip(shares, slopes, strict=True))
            slopes.append(rate(moment + when * step, reached))
        off = step * sum(share * slope for share, slope in zip(_ERROR, slopes, strict=True))
        error = float(np.sqrt(np.mean(np.square(off)))) / tolerance
        if error <= 1.0:
            moment = 1.0 if step >= 1.0 - moment else moment + step
            state, slope = reached, slopes[-1]
        step *= min(_MOST_FACTOR, max(_LEAST_FACTOR, _SAFETY * max(error, 1e-9) ** -0.2))
    return np.array(state)


UNSTATED_ERROR = 0.1
"""Standard deviation on each axis of a current whose error the mission does not state [m/s].

Drifters differ by about as much from maps of the surface current that radar measures there and then (Ullman et al.
2006, J. Geophys. Res. 111, C12005, whose search areas take it as a random flight).
"""
UNSTATED_TIME = 12.0 * 3600.0
"""Time over which that error is forgotten [s]: half a day, as tides and inertial motion are what a mean leaves out."""
HELD = 6.0 * 3600.0
"""Time for which a current that does not change, or has ended, is held [s]: in half its period a tide turns."""
_FIRST_STEP, _LONGEST_STEP = 300.0, 3600.0
"""Of the integration [s]: no tide and no forecast turns within less than the longest."""
_LOOKOUT = 900.0
"""Between two looks for the shore [s]."""
_PLACE_ERROR = 0.05
"""Of a step, over all trials [m]."""


@dataclass(frozen=True)
class Drift:
    """What carries each trial of a block while it is afloat."""

    current: Current
    effects: tuple[TransitEffect, ...]
    """Leeway too."""
    trials: int = 1
    """Of the block."""
    is_error_assumed: bool = False
    """Whether the current's error is not the mission's."""
    shore: Place | None = None
    """Land and ground on which a vehicle strands; None where the mission gives none."""
    is_steady: bool = False
    """Whether the current is that of layers, to which no effect adds a tide."""
    ends: float = math.inf
    """Last time of a record of the current; infinite without one [s since the mission's start]."""

    @classmethod
    def of(cls, scenario: Scenario, seed: int, size: int) -> "Drift":
        """Return the drift of a block of trials; a current without stated error has the default one."""
        current = scenario.current or STILL_WATER
        is_stated = states_error(scenario.mission, current)
        if not is_stated:
            source = BlockStreams(seed, 0)
            current = with_error(current, Statistics(UNSTATED_ERROR, UNSTATED_TIME, None), source, size)
        record = scenario.recorded
        return cls(
            current,
            scenario.effects_afloat,
            size,
            not is_stated,
            _shore(scenario.place),
            record is None and not any(effect.drift().waves for effect in scenario.transit_effects),
            float(record.time[-1]) if isinstance(record, RecordedCurrent) else math.inf,
        )

    def known_until(self, worry: float) -> float:
        """Time until which the current is known, or may be held, if the vehicle is overdue from `worry` on [s]."""
        return HELD + (worry if self.is_steady else self.ends)

    def velocity(self, t: Array, place: Array) -> Array:
        """Velocity over the ground, shape (2, n) [m/s].

        `t`, shape (n,): since the mission's start [s]. `place`, shape (2, n) [m].
        """
        beyond = surface_velocity(self.effects, t, np.zeros(t.size), place) + _tide(self.effects, t)
        return self.current.velocity(t, 0.0, place) + beyond

    def places(self, place: Array, clock: Array, times: Sequence[float]) -> Iterator[Array]:
        """Yield where trials are at some times, shape (2, n) each [m].

        Parameters
        ----------
        place : array, shape (2, n)
            Where they begin to drift [m].
        clock : array, shape (n,)
            When [s]. Until then a trial is where it begins.
        times : sequence of float
            Increasing, since the mission's start [s].
        """
        stranded = np.zeros(clock.size, dtype=bool)
        for time in times:
            while np.any(clock < time):
                lasting = np.maximum(time - clock, 0.0)
                if self.shore is not None:
                    lasting = np.minimum(lasting, _LOOKOUT)
                carried = self._carried(place, clock, np.where(stranded, 0.0, lasting))
                if self.shore is not None:
                    afloat = np.flatnonzero(~stranded & (lasting > 0.0))
                    way = Way(place, carried, clock, clock + lasting).take(afloat)
                    contact = self.shore.take(afloat).meets(way)
                    ashore = contact.of(Cause.ON_LAND) | contact.of(Cause.AGROUND)
                    carried[:, afloat[ashore]] = contact.where[:, ashore]
                    stranded[afloat[ashore]] = True
                place, clock = carried, clock + lasting
            yield place

    def _carried(self, place: Array, clock: Array, lasting: Array) -> Array:
        """Integrate each trial over its own time: exactly in a uniform current, else by `dormand_prince`."""
        longest = float(lasting.max(initial=0.0))
        if longest == 0.0:
            return place.copy()
        if self._is_uniform:
            return place + self.current.mean_velocity(clock, lasting, 0.0, place, np.zeros((2, 1))) * lasting

        def rate(share: float, at: Array) -> Array:
            return self.velocity(clock + share * lasting, at) * lasting

        return dormand_prince(rate, place, _FIRST_STEP / longest, _LONGEST_STEP / longest, _PLACE_ERROR)

    @property
    def _is_uniform(self) -> bool:
        """Whether the velocity is the same everywhere, and the current knows its mean over any time."""
        current = self.current
        if isinstance(current, ErringCurrent):
            if current.error.number is not None:
                return False
            current = current.forecast
        return isinstance(current, LayeredCurrent) and not self.effects


def _tide(effects: Sequence[TransitEffect], t: Array) -> Array | float:
    """Waves of the current that effects bring under way: a tide has them at the surface too, shape (2, n) [m/s]."""
    total: Array | float = 0.0
    for effect in effects:
        for period, (east_cosine, east_sine, north_cosine, north_sine) in effect.drift().waves.items():
            cosine, sine = np.cos(2.0 * np.pi / period * t), np.sin(2.0 * np.pi / period * t)
            total = total + np.stack(
                (east_cosine * cosine + east_sine * sine, north_cosine * cosine + north_sine * sine)
            )
    return total


def _shore(place: Place | None) -> Place | None:
    """Return what stops a drifting vehicle: land, and ground on which the hull touches; zones do not."""
    if place is None:
        return None
    land = tuple(zone for zone in place.zones if zone.is_land)
    fence = replace(place.fence, zones=land) if place.fence is not None and land else None
    return None if fence is None and place.ground is None else replace(place, fence=fence, clearance=0.0)


def states_error(mission: Mission, current: Current) -> bool:
    """Whether a mission says how far its current may be off: by an error, an ensemble, or uncertain layers."""
    written = mission.site.current if mission.site else ()
    if isinstance(written, tuple):
        return bool(written) and sd_of(written[0].speed) > 0.0
    return forecast_error(mission) is not None or isinstance(current, Ensemble)
