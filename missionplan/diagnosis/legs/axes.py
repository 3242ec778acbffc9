"""Axes along which a navigation log's discrepancy may be smooth."""

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.inference.adequacy.axes import Axis, around, pointwise, scaled
from missionplan.phases.hooks import Leg

VARIES = 0.1
"""Range over the median from which a quantity is an axis."""


def transit_axes(data: TransitData, leg: Leg, principal: Array) -> list[Axis]:
    """Time, place, heading, and where they vary a leg's duration, depth, speed and its time at the surface.

    Along each a velocity fixed to the Earth, one ahead and one abeam. Values are ordered leg by leg, first principal
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
    surge = (principal.T @ leg.along).T
    sway = np.stack([-surge[:, 1], surge[:, 0]], axis=1)
    frames = {"": np.tile(np.eye(2), (data.n, 1)), " ahead": surge.reshape(-1, 1), " abeam": sway.reshape(-1, 1)}
    return [
        (around if name == "heading" else pointwise)(
            name, f"a velocity{frame} that changes with {what}", np.repeat(inputs, 2, axis=0), directions
        )
        for name, what, inputs in _inputs(data, leg)
        for frame, directions in frames.items()
    ]


def _inputs(data: TransitData, leg: Leg) -> list[tuple[str, str, Array]]:
    """Name, words and values of what the legs differ in, each scaled so that it spans about one, shape (n, d).

    Headings are angles [rad].
    """
    place = data.start + 0.5 * (data.dead_reckoned - data.start)
    extent = max(float(np.ptp(place, axis=1).max()), 1.0)
    found = [
        ("time", "time", scaled(data.middle)),
        ("place", "place", (place / extent).T),
        ("heading", "heading", np.arctan2(*leg.along)[:, None]),
    ]
    quantities = [
        ("duration", "a leg's duration", data.under_way),
        ("depth", "depth", np.broadcast_to(leg.depth, data.n)),
        ("speed", "speed", np.broadcast_to(leg.speed, data.n)),
        ("duration", "time at the surface", data.surface),
    ]
    for name, what, values in quantities:
        if np.ptp(values) > VARIES * max(float(np.median(values)), 1.0):
            found.append((name, what, scaled(values)))
    return found
