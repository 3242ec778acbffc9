"""Axes along which a navigation log's remainder may be smooth."""

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.legs import TransitData
from missionplan.diagnosis.inference.axes import Axis, pointwise, scaled
from missionplan.phases.hooks import Leg


def transit_axes(data: TransitData, leg: Leg, principal: Array) -> list[Axis]:
    """Time, place, heading, the hull's axes against time, leg duration with and across the hull's axes, surface time.

    Durations and times at the surface count where they vary.

    Values are ordered leg by leg, first principal axis then second.

    Parameters
    ----------
    data : TransitData
        The log.
    leg : Leg
        The legs as an effect sees them.
    principal : array, shape (2, 2)
        Principal axes as columns.
    """
    time = scaled(data.middle)
    place = data.start + 0.5 * (data.dead_reckoned - data.start)
    extent = max(float(np.ptp(place, axis=1).max()), 1.0)
    surge = (principal.T @ leg.along).T
    sway = np.stack([-surge[:, 1], surge[:, 0]], axis=1)
    hull = np.stack([surge, sway], axis=2).reshape(-1, 2)
    fixed = np.tile(np.eye(2), (data.n, 1))
    axes = [
        pointwise("time", "a velocity that changes with time", _twice(time), fixed),
        pointwise("place", "a velocity that changes with place", _twice((place / extent).T), fixed),
        pointwise("heading", "a velocity ahead or abeam that changes with heading", _twice(0.5 * leg.along.T), hull),
        pointwise("heading", "a velocity ahead or abeam that changes with time", _twice(time), hull),
    ]
    if np.ptp(data.under_way) > 0.1 * np.median(data.under_way):
        lasted = _twice(scaled(data.under_way))
        axes += [
            pointwise("duration", "a velocity that changes with a leg's duration", lasted, fixed),
            pointwise("duration", "a velocity ahead or abeam that changes with a leg's duration", lasted, hull),
        ]
    if np.ptp(data.surface) > 0.1 * max(float(np.median(data.surface)), 1.0):
        axes.append(
            pointwise(
                "duration", "a velocity that changes with time at the surface", _twice(scaled(data.surface)), fixed
            )
        )
    return axes


def _twice(inputs: Array) -> Array:
    """One row for each component of a leg."""
    return np.repeat(inputs, 2, axis=0)
