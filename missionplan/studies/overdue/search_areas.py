"""Where a vehicle may be that is overdue, for each way to fail: clouds of trials, carried with the surface current."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.phases.currents import Current, LayeredCurrent
from missionplan.phases.hooks import TransitEffect, surface_velocity
from missionplan.phases.state import select_trials
from missionplan.results.overdue import SHARE, SearchArea
from missionplan.scenario.scenario import STILL_WATER

HOURS = (0.0, 1.0, 3.0, 6.0, 12.0, 24.0)
"""Hours overdue for which areas are given."""
STEP = 900.0
"""Longest step of a drift in a current that changes [s]."""
Way = Literal["not released", "adrift at the surface", "on the seafloor", "still under way"]
DRIFTS: Way = "adrift at the surface"


@dataclass(frozen=True)
class Cloud:
    """Places where trials failed in one way.

    Attributes
    ----------
    way : str
    trials : array of int, shape (n,)
        Of the block.
    position : array, shape (2, n)
        [m]
    clock : array, shape (n,)
        When [s].
    assumed : bool
        Whether they are assumed to fail so.
    """

    way: Way
    trials: NDArray[np.intp]
    position: Array
    clock: Array
    assumed: bool


@dataclass(frozen=True)
class FloatingVehicle:
    """What carries a vehicle that floats.

    Attributes
    ----------
    current : Current or None
    effects : tuple of TransitEffect
        With their parameters for all trials of the block.
    trials : int
        Of the block.
    """

    current: Current | None
    effects: tuple[TransitEffect, ...]
    trials: int

    def carried(self, cloud: Cloud, until: float) -> Array:
        """Return where a cloud is at a time, if it floats from its clock on; shape (2, n) [m].

        A trial that failed later than that is where it failed.
        """
        whole = np.zeros((2, self.trials))
        clock, place = np.zeros(self.trials), whole
        clock[cloud.trials], place[:, cloud.trials] = cloud.clock, cloud.position
        time = np.zeros(self.trials)
        time[cloud.trials] = np.maximum(until - cloud.clock, 0.0)
        current = self.current or STILL_WATER
        steady = isinstance(current, LayeredCurrent) and not self.effects
        steps = 1 if steady else max(1, int(np.ceil(time.max() / STEP)))
        for _ in range(steps):
            part = time / steps
            velocity = current.velocity(clock + 0.5 * part, 0.0, place)
            if self.effects:
                velocity = velocity + surface_velocity(self.effects, clock, part, place)
            place, clock = place + velocity * part, clock + part
        return np.asarray(select_trials(place, cloud.trials))


def search_areas(clouds: list[Cloud], drift: FloatingVehicle, worry: float, reach: float) -> Iterator[SearchArea]:
    """Yield the areas of each way to fail, by hours overdue.

    Parameters
    ----------
    clouds : list of Cloud
    drift : FloatingVehicle
    worry : float
        When the vehicle is overdue [s].
    reach : float
        How far from its anchor a held vehicle is [m].
    """
    for cloud in clouds:
        moves = cloud.way == DRIFTS
        for hours in HOURS if moves else HOURS[:1]:
            overdue = 3600.0 * hours
            places = drift.carried(cloud, worry + overdue) if moves else cloud.position
            centre, axes, line = circle_of(places, reach) if cloud.way == "not released" else ellipse_of(places)
            yield SearchArea(cloud.way, overdue, line, *centre, *axes, trials=places.shape[1], assumed=cloud.assumed)


def circle_of(points: Array, more: float) -> tuple[tuple[float, float], tuple[float, float], Array]:
    """Return centre, radius (twice) and line of the circle about the points' mean that holds `SHARE`, and a rim [m]."""
    middle = points.mean(axis=1, keepdims=True)
    radius = float(np.quantile(np.hypot(*(points - middle)), SHARE)) + more
    return (float(middle[0, 0]), float(middle[1, 0])), (radius, radius), middle + radius * _unit_circle()


def ellipse_of(points: Array) -> tuple[tuple[float, float], tuple[float, float], Array]:
    """Return centre, half axes and line of the ellipse shaped as the points' covariance that holds `SHARE` of them."""
    middle = points.mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(np.cov(points))
    sds = np.sqrt(np.maximum(values, 1.0))  # an ellipse at least metres wide, where all drift alike
    scaled = (vectors.T @ (points - middle)) / sds[:, None]
    scale = float(np.quantile(np.hypot(*scaled), SHARE))
    width, length = (float(scale * sd) for sd in sds)
    line = middle + vectors @ (scale * sds[:, None] * _unit_circle())
    return (float(middle[0, 0]), float(middle[1, 0])), (length, width), np.asarray(line)


def _unit_circle() -> Array:
    angles = np.linspace(0.0, 2.0 * np.pi, 73)
    return np.stack((np.cos(angles), np.sin(angles)))
