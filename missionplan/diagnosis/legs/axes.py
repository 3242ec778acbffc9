"""Axes along which a navigation log's discrepancy may be smooth."""

import itertools

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.inference.axes import Axis, around, pointwise, scaled
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
    return [
        (around if name == "heading" else pointwise)(
            name, f"a velocity{frame} that changes with {what}", np.repeat(inputs, 2, axis=0), directions
        )
        for name, what, inputs in _inputs(data, leg)
        for frame, directions in _frames(data, leg, principal).items()
    ]


def paired_axes(data: TransitData, leg: Leg, principal: Array) -> list[Axis]:
    """Return the axes of two quantities together, place apart: velocities ahead and abeam, and fixed to the Earth.

    One fixed to the Earth does not go by heading: that is one ahead and one abeam.
    """
    found = []
    for (first, of_first, one), (second, of_second, other) in itertools.combinations(_inputs(data, leg), 2):
        if "place" in (first, second):
            continue
        inputs = np.concatenate(
            [_on_circle(one) if first == "heading" else one, _on_circle(other) if second == "heading" else other],
            axis=1,
        )
        for frame, directions in _frames(data, leg, principal).items():
            if frame or "heading" not in (first, second):
                words = f"a velocity{frame} that changes with {of_first} and {of_second}"
                found.append(pointwise(f"{first} and {second}", words, np.repeat(inputs, 2, axis=0), directions))
    return found


def _on_circle(angles: Array) -> Array:
    """Angles as places on a circle of diameter one, (n, 1) → (n, 2)."""
    return 0.5 * np.concatenate([np.cos(angles), np.sin(angles)], axis=1)


def _frames(data: TransitData, leg: Leg, principal: Array) -> dict[str, Array]:
    """Directions of a velocity fixed to the Earth, of one ahead and of one abeam, by words, shape (2n, p)."""
    surge = (principal.T @ leg.along).T
    sway = np.stack([-surge[:, 1], surge[:, 0]], axis=1)
    return {"": np.tile(np.eye(2), (data.n, 1)), " ahead": surge.reshape(-1, 1), " abeam": sway.reshape(-1, 1)}


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
