"""What legs differ in, alone and two together, along which a velocity error may be smooth."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.inference.axes import Axis, around, pointwise, scaled, smooth_functions
from missionplan.phases.hooks import Leg

VARIES = 0.1
"""Range over the median from which a quantity is an axis."""
LEGS_IN_TURN = 3
"""Legs in the shortest period that is tried, on average."""


class Tried(NamedTuple):
    """Columns tried of a velocity error at one value of its shape."""

    axis: str
    words: str
    shape: tuple[float, ...]
    columns: Array
    """Of unit size, shape (2n, p)."""


def transit_axes(data: TransitData, leg: Leg, principal: Array) -> list[Axis]:
    """Time, place, heading, and where they vary a leg's duration, depth, speed and its time at the surface.

    Along each a velocity fixed to the Earth, one ahead and one abeam. Values are ordered leg by leg, first principal
    axis then second.

    `data`: the log. `leg`: the legs in the form that effects take. `principal`, shape (2, 2): principal axes as
    columns.
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

    What goes by heading does so once in a circle, more or less as the other quantity says, ahead or abeam.
    """
    axes = []
    inputs, frames = _inputs(data, leg), _frames(data, leg, principal)
    for (first, of_first, one), (second, of_second, other) in itertools.combinations(inputs, 2):
        if "place" in (first, second):
            continue
        for frame, directions in frames.items():
            name, words = f"{first} and {second}", f"a velocity{frame} that changes with {of_first} and {of_second}"
            if "heading" not in (first, second):
                both = np.concatenate([one, other], axis=1)
                axes.append(pointwise(name, words, np.repeat(both, 2, axis=0), directions))
            elif frame:
                angles, along = (one, other) if first == "heading" else (other, one)
                by_course = np.repeat(np.concatenate([np.cos(angles), np.sin(angles)], axis=1), 2, axis=0)
                axes.append(pointwise(name, words, np.repeat(along, 2, axis=0), directions * by_course))
    return axes


LINES_TRIED = 4
"""Directions of a velocity to and fro along one line that are tried."""


def along_one_line(axis: Axis) -> list[Axis]:
    """Return an axis of velocities fixed to the Earth with one that goes to and fro along a line, one a direction.

    Most of what moves the water does; two components that know nothing of each other cost twice the freedom.
    """
    words = axis.description.replace("a velocity", "a velocity along one line", 1)
    parts = axis.response.reshape(len(axis.response), axis.functions, -1)
    angles = np.pi / LINES_TRIED * np.arange(LINES_TRIED)
    return [
        replace(axis, description=words, response=np.tensordot(parts, way, (1, 0)))
        for way in np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ]


FLOW_LENGTH = 0.25
"""Correlation length of a flow, of the record's extent: eddies of a few legs."""


def flow_columns(data: TransitData, principal: Array) -> Array:
    """Return responses to a steady flow that neither wells up nor sinks, the curl of a smooth function, (2n, r)."""
    step = 0.1 * FLOW_LENGTH
    beside = [_place(data) + step * np.array(way) for way in ((0, 1), (0, -1), (1, 0), (-1, 0))]
    north, south, east, west = smooth_functions(np.concatenate(beside), FLOW_LENGTH).reshape(4, data.n, -1)
    curl = FLOW_LENGTH / (2.0 * step) * np.stack([south - north, east - west])
    return np.asarray(np.tensordot(principal.T, curl, 1).swapaxes(0, 1).reshape(2 * data.n, -1))


BEARINGS, LINES = 6, np.linspace(0.15, 0.85, 6)
"""Directions across a line in the sea, and shares of the legs that lie before one, that are tried."""


def across_lines(data: TransitData, leg: Leg, principal: Array) -> list[Tried]:
    """Velocities on one side of a line, by its direction [rad] and distance [m]."""
    trials = []
    for bearing in (np.pi / BEARINGS * np.arange(BEARINGS)).tolist():
        first, last = (np.array([np.sin(bearing), np.cos(bearing)]) @ ends for ends in (data.start, data.dead_reckoned))
        for line in np.quantile(0.5 * (first + last), LINES).tolist():
            share = np.clip((np.maximum(first, last) - line) / np.maximum(np.abs(last - first), 1e-9), 0.0, 1.0)
            for frame, directions in _frames(data, leg, principal).items():
                columns = _of_unit_size(directions * np.repeat(share, 2)[:, None])
                trials.append(Tried("place", f"a velocity{frame} that changes across a line", (bearing, line), columns))
    return trials


MOST_TURNS = 64
"""Turns of a flow in a record that are tried at most: what comes and goes faster does so between a few legs."""
WHILE = 0.04
"""Standard deviation of the time for which something comes and goes, of the record."""
WINDOWS, FASTER = 2.0, 0.12
"""Steps from one such time to the next, in `WHILE`, and of the turns in a record, in its reciprocal: two thirds of
what lies between them are seen with the nearer (Gabor 1946, *J. IEE* 93)."""
MOST_TIDES = 3.0
"""Turns in a record of what is tried above a depth, at most."""
WAVES, WAVE_STEP = 4.0, 0.5
"""Most waves of a flow over the extent of a record, and steps from one number of them to the next."""


def waves_of_water(data: TransitData, leg: Leg, principal: Array) -> Iterator[Tried]:
    """Velocities of the water that come and go, by their turns in the record, and that wind over a place.

    All the time they turn either way (Gonella 1972, *Deep-Sea Res.* 19) or go round an ellipse, for a while about a
    moment round one, or as slowly as tides above a depth; over a place they go across plane waves, by their number east
    and north in its extent.
    """
    span, origin = max(float(np.ptp(data.middle)), 1.0), data.middle.min()
    legs = tuple((t - origin) / span for t in (data.t_start, data.t_start + data.under_way))
    ways = np.array([[1.0, 1.0j], [1.0, -1.0j]])  # east and north, clockwise and the other way
    for turns in np.arange(1.0, max(min(data.n, MOST_TURNS) / LEGS_IN_TURN, 1.0) + 0.5, 0.5).tolist():
        for sense, directions in enumerate((ways[:1], ways[1:], ways)):
            columns = _wave(legs, turns, directions, principal)
            yield Tried("time", "a velocity that comes and goes with a period", (turns, sense), columns)
    for middle in np.quantile(data.middle, np.arange(0.5 * WINDOWS * WHILE, 1.0, WINDOWS * WHILE)).tolist():
        about = np.exp(-0.5 * np.square((data.middle - middle) / (WHILE * span)))
        for turns in np.arange(0.2 / WHILE, min(data.n, MOST_TURNS), FASTER / WHILE).tolist():
            columns = _wave(legs, turns, ways, principal, about)
            yield Tried("time", "a velocity that comes and goes for a while", (middle, turns), columns)
    depths = np.broadcast_to(leg.depth, data.n)
    layers = np.unique(np.quantile(depths, LINES)) if np.ptp(depths) > VARIES * np.median(depths) else np.array([])
    for depth, turns in itertools.product(layers.tolist(), np.arange(0.5, MOST_TIDES + 0.5, 0.5).tolist()):
        columns = _wave(legs, turns, ways, principal, depths < depth)
        yield Tried("depth and time", "a velocity above a depth that comes and goes", (depth, turns), columns)
    numbers = np.arange(-WAVES, WAVES + WAVE_STEP, WAVE_STEP).tolist()
    for east, north in itertools.product(numbers, numbers):
        if (north, east) > (0.0, 0.0) and np.hypot(east, north) <= WAVES:  # the opposite waves are the same
            legs = tuple(np.array([east, north]) @ ends / _extent(data) for ends in (data.start, data.dead_reckoned))
            columns = _wave(legs, 1.0, np.array([[north, -east]]), principal)
            yield Tried("place", "a velocity that winds from side to side over a place", (east, north), columns)


def _wave(
    legs: Sequence[Array], turns: float, ways: NDArray[np.number], principal: Array, about: Array | float = 1.0
) -> Array:
    """Means over legs, from one place to another on an axis, of velocities along ways that go round at either phase.

    `ways`, (w, 2), complex where they turn. `about`: size at each leg. Returns columns of unit size, (2n, 2w).
    """
    first, last = legs
    wave = about * np.sinc(turns * (last - first)) * np.exp(1j * np.pi * turns * (first + last))
    moved = wave[:, None, None] * (ways @ principal).T
    return _of_unit_size(np.concatenate([moved.real, moved.imag], axis=2).reshape(2 * len(wave), -1))


def _of_unit_size(columns: Array) -> Array:
    return columns / max(float(np.sqrt(2.0 * np.mean(columns**2))), 1e-9)


def _extent(data: TransitData) -> float:
    return max(float(np.ptp(0.5 * (data.start + data.dead_reckoned), axis=1).max()), 1.0)


def _place(data: TransitData) -> Array:
    """Middles of the legs as reckoned, scaled so that they span about one, shape (n, 2)."""
    return np.asarray((0.5 * (data.start + data.dead_reckoned) / _extent(data)).T)


def _frames(data: TransitData, leg: Leg, principal: Array) -> dict[str, Array]:
    """Directions of a velocity fixed to the Earth, of one ahead and of one abeam, by words, shape (2n, p)."""
    surge = (principal.T @ leg.along).T
    sway = np.stack([-surge[:, 1], surge[:, 0]], axis=1)
    return {"": np.tile(np.eye(2), (data.n, 1)), " ahead": surge.reshape(-1, 1), " abeam": sway.reshape(-1, 1)}


def _inputs(data: TransitData, leg: Leg) -> list[tuple[str, str, Array]]:
    """Name, words and values of what the legs differ in, each scaled so that it spans about one, shape (n, d).

    Headings are angles [rad].
    """
    inputs = [
        ("time", "time", scaled(data.middle)),
        ("place", "place", _place(data)),
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
            inputs.append((name, what, scaled(values)))
    return inputs
