"""Where the climb of a set of causes starts: where fits of its parts ended, and afresh at several shapes."""

from collections.abc import Sequence

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.results.diagnosis import Causes

INITIAL_STRENGTH = 0.5
"""Strength of an effect with a shape at a fresh start, in prior standard deviations."""
SHAPE_SHIFTS = (-1.2, 0.0, 1.2)
"""Its first shape there, in prior standard deviations about its centre."""


def starts(coordinates: Sequence[Coordinate], causes: Causes, near: Sequence[CauseFit]) -> list[Array]:
    """Places to climb from.

    Causes start where fits of other sets have them. What fitted only alone is afresh besides: beside other causes it
    may be far from there.

    Parameters
    ----------
    coordinates : sequence of Coordinate, length k
    causes : tuple of str
        The set.
    near : sequence of CauseFit
        Of parts of the set: the one that it extends, then causes alone.

    Returns
    -------
    list of array, shape (k,)
    """
    start, placed = _placed(coordinates, causes, near)
    found = _spread(coordinates, [name for name in causes if name not in placed], start)
    start, extended = _placed(coordinates, causes, near[:1])
    if extended != placed:
        found += _spread(coordinates, [name for name in causes if name not in extended], start)
    return found


def _placed(coordinates: Sequence[Coordinate], causes: Causes, near: Sequence[CauseFit]) -> tuple[Array, set[str]]:
    """Where fits have the causes, the first of them first; and which causes have a place so."""
    start = np.array([coordinate.centre for coordinate in coordinates])
    placed: set[str] = set()
    for fit in (fit for fit in near if fit.possible):  # where another is, is no place to start from
        for i, coordinate in enumerate(coordinates):
            if coordinate.effect in fit.causes and coordinate.effect in causes and coordinate.effect not in placed:
                start[i] = fit.state.linear.at[i]
        placed |= set(fit.causes)
    return start, placed


def _spread(coordinates: Sequence[Coordinate], afresh: Sequence[str], start: Array) -> list[Array]:
    """Starts from one place: several if effects that are afresh have shapes."""
    found = [start]
    for name in afresh:
        own = [i for i, coordinate in enumerate(coordinates) if coordinate.effect == name]
        shapes = [i for i in own if coordinates[i].kind == "shape"]
        if shapes:
            found = [_moved(coordinates, own, shapes[0], shift, begin) for begin in found for shift in SHAPE_SHIFTS]
    return found


def _moved(coordinates: Sequence[Coordinate], own: Sequence[int], shape: int, shift: float, begin: Array) -> Array:
    """Give an effect its first strength, and a shape that is shifted."""
    moved = begin.copy()
    for i in own:
        if coordinates[i].kind != "shape":
            moved[i] = INITIAL_STRENGTH * coordinates[i].slab
    moved[shape] += shift * coordinates[shape].slab
    return moved
