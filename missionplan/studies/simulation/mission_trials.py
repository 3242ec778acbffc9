"""What every trial of a block did, phase by phase: arrays over trials, before anything is reduced."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class PhaseTrials:
    """What one phase did with every trial of a block. nan: the trial never reached it.

    Attributes
    ----------
    name, kind : str
    quantities : mapping of str to array, shape (n,)
        By the names of `summary.json`.
    events : mapping of str to array of bool, shape (n,)
    start, end : array, shape (n,)
        Since the mission's start [s].
    failures : mapping of str to array of bool, shape (n,)
        What spoils the mission here, in words, in the order in which it happens.
    miss : array, shape (2, n)
        Where the phase ended (the vehicle, or its anchor) from its goal [m].
    track : array, shape (points, 2, k)
        Of the first trials, nan after the phase has ended for them [m].
    anchor : array, shape (2, n) or (2, 0)
        On the seafloor; none in a transit [m].
    goal : array, shape (2, 1) or (2, n)
        [m]
    radius : float or array, shape (n,)
        Of arrival or of the mooring [m].
    inputs : mapping of str to array, shape (n,)
        What was drawn anew each leg or fix, in one number a trial; nothing where it was not asked for.
    """

    name: str
    kind: str
    quantities: Mapping[str, Array]
    events: Mapping[str, Flags]
    start: Array
    end: Array
    failures: Mapping[str, Flags]
    miss: Array
    track: Array
    anchor: Array
    goal: Array
    radius: Scalars
    inputs: Mapping[str, Array]


@dataclass(frozen=True)
class MissionTrials:
    """A block of missions.

    Attributes
    ----------
    phases : tuple of PhaseTrials
    total : mapping of str to array, shape (n,)
        ``duration_s`` and ``energy_wh``; nan for a trial that did not come to the mission's end.
    success : array of bool, shape (n,)
        Every transit arrived, every mooring within its radius and not struck, energy within the capacity.
    draws : mapping of str to array, shape (n,)
        The uncertain quantities of the mission, by key path.
    """

    phases: tuple[PhaseTrials, ...]
    total: Mapping[str, Array]
    success: Flags
    draws: Mapping[str, Array]

    def columns(self) -> dict[str, Array | Flags]:
        """One array a column of the table of trials, shape (n,) each."""
        found: dict[str, Array | Flags] = dict(self.draws)
        for phase in self.phases:
            for values in (phase.inputs, phase.quantities, phase.events):
                found |= {f"{phase.name}.{name}": value for name, value in values.items()}
        return found | {f"total.{name}": value for name, value in self.total.items()} | {"total.success": self.success}


@dataclass(frozen=True)
class MapTracks:
    """What maps show of some trials: plain arrays, the phases one after another.

    Attributes
    ----------
    position : array, shape (points, 2, k)
        Tracks [m].
    points : integers, shape (phases,)
        Points of the tracks that are each phase's.
    anchors : array, shape (2, m)
        On the seafloor [m].
    goals : array, shape (phases, 3)
        Goal, east and north, and arrival radius or mooring radius, at the trials' mean [m].
    """

    position: Array
    points: NDArray[np.int64]
    anchors: Array
    goals: Array

    @classmethod
    def of(cls, trials: MissionTrials) -> "MapTracks":
        """Take what a block shows."""
        phases = trials.phases
        return cls(
            position=np.concatenate([phase.track for phase in phases]),
            points=np.array([len(phase.track) for phase in phases]),
            anchors=np.concatenate([phase.anchor for phase in phases], axis=1),
            goals=np.array([(*phase.goal.mean(axis=1), np.mean(phase.radius)) for phase in phases], dtype=float),
        )
