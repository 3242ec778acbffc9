"""Every trial of a block, phase by phase: arrays over trials, before anything is reduced."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.studies.simulation.phase_trials import Flags, PhaseTrials


@dataclass(frozen=True)
class MissionTrials:
    """A block of missions.

    Attributes
    ----------
    phases : tuple of PhaseTrials
    total : mapping of str to array, shape (n,)
        ``duration_s`` and ``energy_wh``; nan for a trial that did not reach the mission's end.
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
    """Some trials for maps: plain arrays, the phases one after another.

    Attributes
    ----------
    position : array, shape (points, 2, k)
        Tracks [m].
    time : array, shape (points, k)
        Since the mission's start, at the points of the tracks [s].
    points : integers, shape (phases,)
        Points of the tracks that are each phase's.
    anchors : array, shape (2, m)
        On the seafloor [m].
    goals : array, shape (phases, 3)
        Goal, east and north, and arrival radius or mooring radius, at the trials' mean [m].
    """

    position: Array
    time: Array
    points: NDArray[np.int64]
    anchors: Array
    goals: Array

    @classmethod
    def from_arrays(cls, flat: Mapping[str, NDArray[np.generic]]) -> "MapTracks":
        """Read the fields from arrays of their names."""
        return cls(
            position=np.asarray(flat["position"], dtype=float),
            time=np.asarray(flat["time"], dtype=float),
            points=np.asarray(flat["points"], dtype=np.int64),
            anchors=np.asarray(flat["anchors"], dtype=float),
            goals=np.asarray(flat["goals"], dtype=float),
        )

    @classmethod
    def of(cls, trials: MissionTrials) -> "MapTracks":
        """Collect them from a block."""
        phases = trials.phases
        return cls(
            position=np.concatenate([phase.track for phase in phases]),
            time=np.concatenate([phase.track_time for phase in phases]),
            points=np.array([len(phase.track) for phase in phases]),
            anchors=np.concatenate([phase.anchor for phase in phases], axis=1),
            goals=np.array([(*phase.goal.mean(axis=1), np.mean(phase.radius)) for phase in phases], dtype=float),
        )
