"""The trials of a block in one phase, and what all kinds of phase need to run them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.montecarlo.streams import NormalSource
from missionplan.phases.currents import Current
from missionplan.phases.place.place import Cause, Contact
from missionplan.phases.state import TrialState
from missionplan.scenario.scenario import Scenario

Flags = NDArray[np.bool_]

OUT_OF_ENERGY = "out of energy"
"""Failure of every kind of phase."""
LEFT_RECORD = "left the record of the current"
OUTRUN = "current faster than the vehicle"
AGROUND = "aground"
ON_LAND = "on-land"
KEEP_OUT = "keep-out"
UNCHARTED = "left the grid of depths"
TOO_SHALLOW = "line and vehicle longer than the water is deep"
TOO_LIGHT = "anchor too light to sink the vehicle"
FLOODED_EARLY = "anchor flooded before its release"
LINE_PARTED = "line parted"
LIMIT_FAILURES = (LEFT_RECORD, OUTRUN, AGROUND, ON_LAND, KEEP_OUT, UNCHARTED, TOO_SHALLOW, TOO_LIGHT)
"""Failures where the world sets a limit: reported where some trial met it."""


MET = {
    Cause.AGROUND: AGROUND,
    Cause.ON_LAND: ON_LAND,
    Cause.KEEP_OUT: KEEP_OUT,
    Cause.UNCHARTED: UNCHARTED,
}
"""Failures by what a trial has met."""


@dataclass(frozen=True)
class TrialBlock:
    """A block of trials to run.

    Attributes
    ----------
    scenario : Scenario
        With the block's draws.
    source : NormalSource
        Of what is drawn each leg or fix.
    tracked : int
        Trials whose tracks are kept.
    inputs : bool
        Whether to sum up what was drawn each leg.
    """

    scenario: Scenario
    source: NormalSource
    tracked: int
    inputs: bool


@dataclass(frozen=True)
class PhaseTrials:
    """Trials of one phase. nan: the trial never reached it.

    Attributes
    ----------
    name, kind : str
    quantities : mapping of str to array, shape (n,)
        By the names of `summary.json`.
    events : mapping of str to array of bool, shape (n,)
    limits : mapping of str to array of bool, shape (n,)
        Which trials met a current faster than the vehicle (``current_faster``), or left the record of it
        (``left_record``), whether or not they failed; empty where neither can be.
    start, end : array, shape (n,)
        Since the mission's start [s].
    failures : mapping of str to array of bool, shape (n,)
        Trials of which the mission fails here, by the reason, in the order in which they happen.
    miss : array, shape (2, n)
        From the phase's goal to where it ended, of the vehicle or its anchor [m].
    track : array, shape (points, 2, k)
        Of the first trials, nan after the phase has ended for them [m].
    track_time : array, shape (points, k)
        Since the mission's start, at the points of the track [s].
    anchor : array, shape (2, n) or (2, 0)
        On the seafloor; none in a transit [m].
    goal : array, shape (2, 1) or (2, n)
        [m]
    radius : float or array, shape (n,)
        Of arrival or of the mooring [m].
    inputs : mapping of str to array, shape (n,)
        Draws of each leg or fix, summed up in one number a trial; empty where not requested.
    contact : Contact or None
        What of ground, coast and zones each trial met here, on which leg and where; None where the phase meets none.
    """

    name: str
    kind: str
    quantities: Mapping[str, Array]
    events: Mapping[str, Flags]
    limits: Mapping[str, Flags]
    start: Array
    end: Array
    failures: Mapping[str, Flags]
    miss: Array
    track: Array
    track_time: Array
    anchor: Array
    goal: Array
    radius: Scalars
    inputs: Mapping[str, Array]
    contact: Contact | None = None


def failures_met(contact: Contact) -> dict[str, Flags]:
    """Failures by what was met."""
    return {reason: contact.of(cause) for cause, reason in MET.items()}


def limit_events(current: Current | None, **happened: Flags) -> dict[str, Flags]:
    """Events of the limits of the current; `left_record` only where the current is a record."""
    return {
        name: values
        for name, values in happened.items()
        if name != "left_record" or (current is not None and current.is_record)
    }


def end_exhausted(state: TrialState, capacity: Scalars) -> tuple[TrialState, Flags]:
    """End the trials that have used more energy than the battery holds [J].

    Returns
    -------
    state, exhausted : TrialState, array of bool of shape (n,)

    Raises
    ------
    FloatingPointError
        When the position or the time of a trial under way is not finite.
    """
    for values in (state.position, state.fix, state.clock):
        if not np.isfinite(values).all() and not np.isfinite(values[..., state.alive]).all():
            raise FloatingPointError("the position or the time of a trial under way is not finite")
    exhausted = state.alive & (state.energy > capacity)
    return replace(state, alive=state.alive & ~exhausted), exhausted


def where_reached(reached: Flags, values: Array) -> Array:
    """Values of the trials that reached something, nan for the others."""
    return values if reached.all() else np.where(reached, values, np.nan)


def quantities_reached(reached: Mapping[str, tuple[Flags, Array]]) -> dict[str, Array]:
    """Quantities by name, nan for the trials that did not reach them."""
    return {name: where_reached(mask, values) for name, (mask, values) in reached.items()}
