"""Axes along which a navigation log's discrepancy may be smooth."""

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.inference.adequacy.axes import Axis, pointwise, scaled
from missionplan.phases.hooks import Leg


def transit_axes(data: TransitData, leg: Leg, principal: Array) -> list[Axis]:
    """Time, place, heading, and where they vary a leg's duration and its time at the surface.

    A velocity is fixed to the Earth or to the hull (ahead or abeam). Values are ordered leg by leg, first principal
    axis then second.

    Parameters
    ----------
    data : TransitData
        The log.
    leg : Leg
        The legs in the form that effects take.
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
        pointwise("time", "a velocity that changes with time", _for_both_axes(time), fixed),
        pointwise("place", "a velocity that changes with place", _for_both_axes((place / extent).T), fixed),
        pointwise(
            "heading", "a velocity ahead or abeam that changes with heading", _for_both_axes(0.5 * leg.along.T), hull
        ),
        pointwise("heading", "a velocity ahead or abeam that changes with time", _for_both_axes(time), hull),
    ]
    if np.ptp(data.under_way) > 0.1 * np.median(data.under_way):
        duration = _for_both_axes(scaled(data.under_way))
        axes += [
            pointwise("duration", "a velocity that changes with a leg's duration", duration, fixed),
            pointwise("duration", "a velocity ahead or abeam that changes with a leg's duration", duration, hull),
        ]
    if np.ptp(data.surface) > 0.1 * max(float(np.median(data.surface)), 1.0):
        axes.append(
            pointwise(
                "duration",
                "a velocity that changes with time at the surface",
                _for_both_axes(scaled(data.surface)),
                fixed,
            )
        )
    return axes


def _for_both_axes(inputs: Array) -> Array:
    """Repeat each leg's row for its two components."""
    return np.repeat(inputs, 2, axis=0)
