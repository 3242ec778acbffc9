"""What the flooding of the anchor would cost where the vehicle file takes none: time and offset of the nominal dive."""

from dataclasses import replace

import numpy as np

from missionplan.arrays import Scalars
from missionplan.mission.schema.phases import MoorPhase
from missionplan.phases.mooring.descent import descend
from missionplan.phases.mooring.forces import Dive
from missionplan.scenario.mooring import dive_of
from missionplan.scenario.scenario import STILL_WATER, Scenario

STATED = 5.0
"""Flooding time of the notice [s]."""


def flooding_notice(means: Scenario, phase: MoorPhase[Scalars], weight: float | None = None) -> str:
    """Notice that the anchor is taken as flooded when it separates; empty where the vehicle file gives a time.

    Parameters
    ----------
    means : Scenario
        At the means.
    phase : MoorPhase
    weight : float, optional
        Wet weight of the anchor, by default the mission's [N].
    """
    if means.mooring.anchor.flooding_time is not None:
        return ""
    dive = dive_of(means, phase, weight)
    at_once, flooding = (_nominal(means, phase, replace(dive, flooding_time=time)) for time in (0.0, STATED))
    if not np.isfinite([*at_once, *flooding]).all():
        return ""
    longer, further = (later - now for later, now in zip(flooding, at_once, strict=True))
    return (
        f"{phase.name}: the anchor is taken as flooded when it separates. {STATED:g} s of flooding "
        f"(anchor.flooding_time) would make the nominal descent {longer:.1f} s longer and change its offset by "
        f"{further:+.1f} m."
    )


def _nominal(means: Scenario, phase: MoorPhase[Scalars], dive: Dive) -> tuple[float, float]:
    """Time [s] and offset [m] of the dive at the means, from the origin at the mission's start; nan where it fails."""
    record = descend(
        dive,
        effects=means.descent_effects,
        release_time=np.full(1, float(phase.release_time)),
        current=means.current or STILL_WATER,
        position=np.zeros((2, 1)),
        t_start=np.zeros(1),
    )
    return float(record.descent_time[0]), float(record.offset_distance[0])
