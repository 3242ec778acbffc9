"""Starting points for the fit of a set of causes: where fits of its parts ended, and afresh at several shapes."""

from collections.abc import Iterator, Sequence

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, is_approximate
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.effects import CATALOGUE
from missionplan.phases.hooks import DescentEffect
from missionplan.results.learned.evidence import Causes

INITIAL_STRENGTH = 0.5
"""Strength at a fresh start of an effect of approximate form, in prior standard deviations."""
SHAPE_SHIFTS = (-1.2, 0.0, 1.2)
"""Its first shape parameter there, in prior standard deviations about its prior mean."""
LATE_STARTS = (-8.0, -4.0, 4.0, 8.0)
"""Further starts of an effect that delays the dive or its readings, in prior standard deviations: to a search from no
delay a vehicle that starts seconds late looks like one that sinks slowly."""


def starting_points(
    coordinates: Sequence[Coordinate], expected: Array, given: Sequence[str], causes: Causes, near: Sequence[CauseFit]
) -> list[Array]:
    """Points from which to search for the best coordinates of a set.

    Causes start where fits of other sets have them. A cause that was fitted only alone also starts afresh: beside
    other causes its best coordinates may be far from there. So does an effect of the mission that may have changed,
    besides the start where the mission has it.

    Parameters
    ----------
    coordinates : sequence of Coordinate, length k
        Of all causes.
    expected : array, shape (k,)
        Coordinates that the mission expects.
    given : sequence of str
        The mission's own effects.
    causes : tuple of str
        The set.
    near : sequence of CauseFit
        Of parts of the set: the one that it extends, then causes alone.

    Returns
    -------
    list of array, shape (k,)
    """
    start, fitted = _from_fits(coordinates, expected, given, causes, near)
    fresh = [name for name in causes if name not in fitted]
    found = _spread_over_shapes(coordinates, fresh, start)
    found += [moved for name in fresh for moved in _late(coordinates, name, start)]
    if {*given} & {*causes} - fitted and len(found) > 1:
        found.append(start)
    start, extended = _from_fits(coordinates, expected, given, causes, near[:1])
    if extended != fitted:
        found += _spread_over_shapes(coordinates, [name for name in causes if name not in extended], start)
    return found


def _late(coordinates: Sequence[Coordinate], name: str, start: Array) -> Iterator[Array]:
    """Points about one at which an effect that delays the dive or its readings is strong, inside its physical range."""
    info = CATALOGUE[name]
    delays = getattr(info.effect, "delay", DescentEffect.delay) is not DescentEffect.delay
    for i, coordinate in enumerate(coordinates):
        parameter = info.parameters.get(coordinate.name)
        if (
            coordinate.effect == name
            and coordinate.kind == "strength"
            and parameter
            and (delays or parameter.unit == "s")
        ):
            for shift in LATE_STARTS:
                if parameter.low < shift * coordinate.slab < parameter.high:
                    moved = start.copy()
                    moved[i] = shift * coordinate.slab
                    yield moved


def _from_fits(
    coordinates: Sequence[Coordinate], expected: Array, given: Sequence[str], causes: Causes, near: Sequence[CauseFit]
) -> tuple[Array, set[str]]:
    """Coordinates of causes from fits, the first that has a cause first; and the causes that were found so."""
    start = expected.copy()
    fitted: set[str] = set()
    possible = [fit for fit in near if fit.possible]  # skip infeasible fits as starting points
    for fit in possible:
        for i, coordinate in enumerate(coordinates):
            if coordinate.effect in fit.causes and coordinate.effect in causes and coordinate.effect not in fitted:
                start[i] = fit.state.linear.at[i]
        fitted |= set(fit.causes)
    if possible:
        own = [
            i
            for i, coordinate in enumerate(coordinates)
            if coordinate.effect in given and coordinate.effect not in fitted
        ]
        start[own] = possible[0].state.linear.at[own]
    return start, fitted


def _spread_over_shapes(coordinates: Sequence[Coordinate], fresh: Sequence[str], start: Array) -> list[Array]:
    """Points about one, several for each of the fresh effects of approximate form."""
    found = [start]
    for name in fresh:
        own = [i for i, coordinate in enumerate(coordinates) if coordinate.effect == name]
        shapes = [i for i in own if coordinates[i].kind == "shape"]
        if is_approximate(name):
            found = [_shifted(coordinates, own, shapes[0], shift, point) for point in found for shift in SHAPE_SHIFTS]
    return found


def _shifted(coordinates: Sequence[Coordinate], own: Sequence[int], shape: int, shift: float, point: Array) -> Array:
    """A point with an effect at its initial strength and one shape parameter shifted."""
    moved = point.copy()
    for i in own:
        if coordinates[i].kind != "shape":
            moved[i] = INITIAL_STRENGTH * coordinates[i].slab
    moved[shape] += shift * coordinates[shape].slab
    return moved
