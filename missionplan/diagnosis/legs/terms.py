"""Columns that compete beside all sets of causes, one at a time: terms of effects, and smooth errors along axes.

An effect that acts by its terms (`effects.info.Term`) is linear in a few strengths at each value of a shape: the moment
of a change, a threshold. Every value tried is a column or two under a prior of its own. Named effects have the
catalogue's; the neutral response, and smooth random functions of one quantity or two (Kennedy & O'Hagan 2001, *J. R.
Stat. Soc. B* 63; Brynjarsdóttir & O'Hagan 2014, *Inverse Problems* 30) by their leading principal components, share
that of `UNNAMED`. A velocity fixed to the Earth that changes with time is not among the smooth ones: random effects of
the catalogue describe it.
"""

import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.inference.axes import Axis, around, pointwise, principal_components, scaled
from missionplan.diagnosis.legs.fitting import TransitFitting
from missionplan.diagnosis.legs.likelihood.mean import ActingTerm
from missionplan.effects import CATALOGUE, EffectInfo, effects_of
from missionplan.effects.info import Term
from missionplan.phases.hooks import Leg, TransitEffect, velocity_error
from missionplan.results.learned.evidence import Causes

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


UNNAMED = 0.05
"""Prior odds of all neutral terms together, beside whatever is named: as much as what is said to be so may be wrong.
By Markov's inequality they are called 95 % probable without any effect with a chance of 0.05/19 at most."""
SIZE = 0.04
"""Usual size of a neutral response [m/s]: as of the catalogue's effects in the middle of their sizes."""
LENGTHS = (0.4, 0.15)
"""Correlation lengths of a smooth one, of the record's extent along the axis."""
MOST_COLUMNS = 24
LEAST_SHARE = 0.01
"""Principal components kept at most, and least share of the first one's variance that one has."""
IS_DESCRIBED = ("time", "a velocity that changes with time")
"""What random effects of the catalogue describe."""
MOMENTS, THRESHOLDS, PERIODS = 16, 6, 24
"""Most values tried of the moment of a change, of a threshold, and of a period."""
DAY = 86400.0
LEGS_IN_TURN = 3
"""Legs in the shortest period that is tried, on average; a day is tried besides."""
MIDDLE = (0.15, 0.85)
"""Part of a log within which something may change: before and after it there must be legs that show it."""
STEP = 1e-3
"""Strength at which columns are taken, in its usual sizes: small, so that turns of the course are linear."""


@dataclass(frozen=True)
class LegTerm:
    """Columns that act together, under one prior."""

    effect: str
    """Whose term it is; empty for a smooth error."""
    axis: str
    description: str
    """What it follows."""
    columns: Array
    """Velocity errors for standard normal coefficients, on the principal axes, shape (2, n, q) [m/s]."""
    log_share: float
    """Log of its share of the prior of what it belongs to."""
    acting: ActingTerm | None = None
    """As a model fits it; None for a smooth error."""
    answers: bool = False
    """Whether it depends on the current."""
    length: float = 0.0
    """Correlation length of a smooth error, of the record's extent."""

    @property
    def is_neutral(self) -> bool:
        """Whether it names no cause."""
        return not self.effect or CATALOGUE[self.effect].tier == "neutral"

    @property
    def key(self) -> tuple[str, str, str, tuple[Scalars, ...]]:
        """What distinguishes it from all others."""
        shapes = (self.length,) if self.acting is None else tuple(self.acting.shapes.values())
        return self.effect, self.axis, self.description, shapes

    def is_alike(self, other: "LegTerm") -> bool:
        """Whether both are the same term, at whatever shape."""
        return self.key[:-1] == other.key[:-1]


def terms_of(model: TransitFitting) -> tuple[LegTerm, ...]:
    """Return all terms that a log could show, those of effects that the mission has already apart."""
    given = {each.effect for each in model.given}
    found: list[LegTerm] = []
    families = 0
    for info in effects_of("transit"):
        if not info.terms or info.id in given or info.lacking(model.record):
            continue
        terms = [term for term in info.terms if not term.lacking(model.record)]
        families += len(terms) if info.tier == "neutral" else 0
        found += [each for term in terms for each in _members(model, info, term)]
    smooth = _smooth(model)
    share = math.log(max(families + sum(math.exp(each.log_share) for each in smooth), 1.0) / UNNAMED)
    return tuple(
        replace(each, log_share=each.log_share - share) if each.is_neutral else each for each in [*found, *smooth]
    )


def without_a_name(terms: Sequence[LegTerm], numbers: Collection[int]) -> tuple[LegTerm, ...]:
    """Return terms of which those of some numbers, from 1, are neutral, with the share of the prior of such a one."""
    share = max(each.log_share for each in terms if each.is_neutral)

    def neutral(term: LegTerm) -> LegTerm:
        what = CATALOGUE[term.effect].parameters[term.axis].doc
        return replace(term, effect="", description=what, log_share=term.log_share + share)

    return tuple(neutral(each) if number in numbers else each for number, each in enumerate(terms, start=1))


def refined(model: TransitFitting, likeliest: LegTerm) -> list[LegTerm]:
    """Return a term at all moments near one of those tried, one leg from the next, with their share of its prior."""
    if likeliest.acting is None or not likeliest.acting.shapes:
        return []
    info = CATALOGUE[likeliest.effect]
    strengths = tuple(each.name for each in likeliest.acting.coordinates)
    term = next(each for each in info.terms if each.strengths == strengths)
    if info.parameters[term.searched].searched != "time":
        return []
    tried, moments = _tried(model, "time"), _moments(model)
    place = int(np.searchsorted(moments, float(np.asarray(likeliest.acting.shapes[term.searched]))))
    apart = math.ceil(len(moments) / MOMENTS)
    near = moments[max(place - apart, 0) : place + apart + 1]
    share = likeliest.log_share + math.log(len(tried)) - math.log(len(moments))
    return [replace(each, log_share=share) for each in _members(model, info, term, np.setdiff1d(near, tried))]


def at_size(model: TransitFitting, term: LegTerm, causes: Causes, values: Array, coefficients: Array) -> LegTerm:
    """Return a term that turns the course with columns from nil to a size, beside causes of these coordinates.

    Parameters
    ----------
    model : TransitFitting
    term : LegTerm
    causes : tuple of str
    values : array, shape (k,)
        Coordinates of the model.
    coefficients : array, shape (q,)
        Standard normal ones of the term.
    """
    acting = term.acting
    turns = acting is not None and cast(TransitEffect, CATALOGUE[acting.effect].make({})).changes_course
    if acting is None or not turns or abs(coefficients[0]) < STEP:
        return term
    with_term = model.with_term(acting)
    sizes = coefficients * [each.slab for each in acting.coordinates]
    together = np.concatenate([values, sizes])[with_term.from_last(acting)]
    names = [name for name in causes if name in model.by_effect]
    moved = with_term._error([*names, acting.effect], together) - model._error(names, values)
    return replace(term, columns=(model.axes.T @ moved / coefficients[0])[:, :, None])


def _members(model: TransitFitting, info: EffectInfo, term: Term, wanted: Array | None = None) -> list[LegTerm]:
    """A term at each value of its shape, or at some."""
    values: list[float | None] = [None]
    if term.searched:
        tried = _tried(model, info.parameters[term.searched].searched) if wanted is None else wanted
        values = list(tried.tolist())
    found = []
    for value in values:
        shapes: dict[str, Scalars] = {} if value is None else {term.searched: value}
        does_answer = _answers(model, info, term)
        columns = _unit_columns(model, info, term, shapes)
        sizes = [
            info.parameters[name].scale if does_answer else _slab(model, info, name, columns[:, :, i])
            for i, name in enumerate(term.strengths)
        ]
        if min(sizes) <= 0.0:
            continue
        coordinates = tuple(
            Coordinate(info.id, name, "strength", 0.0, size, info.parameters[name].spike)
            for name, size in zip(term.strengths, sizes, strict=True)
        )
        found.append(
            LegTerm(
                info.id,
                term.strengths[0],
                (info.parameters[term.strengths[0]].doc if info.tier == "neutral" else info.what),
                columns * sizes,
                -math.log(len(values)),
                ActingTerm(info.id, coordinates, shapes),
                does_answer,
            )
        )
    return found


def _unit_columns(model: TransitFitting, info: EffectInfo, term: Term, shapes: Mapping[str, Scalars]) -> Array:
    """Velocity errors a unit of each strength without what the current does, shape (2, n, q)."""
    found = []
    for name in term.strengths:
        step = STEP * info.parameters[name].scale
        effect = cast(TransitEffect, info.make({**shapes, name: step}))
        found.append(model.axes.T @ velocity_error((effect,), model.leg) / step)
    return np.stack(found, axis=2)


def _answers(model: TransitFitting, info: EffectInfo, term: Term) -> bool:
    """Whether a term depends on the current."""
    effect = cast(TransitEffect, info.make(dict.fromkeys(term.strengths, 1.0)))
    return bool(np.any(effect.answer_to_current(model.leg, np.ones((2, model.data.n)))))


def _slab(model: TransitFitting, info: EffectInfo, name: str, column: Array) -> float:
    """Usual size of a strength: the catalogue's, or of a neutral response what errs as much as is usual."""
    parameter = info.parameters[name]
    rms = float(np.sqrt(np.mean(np.sum(column**2, axis=0))))
    if info.tier != "neutral":
        depths = model.record.depths
        return min(parameter.scale, parameter.extent_scale / depths) if depths > 0.0 else parameter.scale
    return SIZE / rms if rms > 0.0 else 0.0


def _moments(model: TransitFitting) -> Array:
    """Moments after the mission's start at which something may change: a leg of the middle begins, not the first."""
    n = model.data.n
    middle = model.data.t_start[max(int(MIDDLE[0] * n), 1) : int(MIDDLE[1] * n) + 1]
    return np.asarray(middle[middle > 0.0])


def _tried(model: TransitFitting, searched: str) -> Array:
    """Values of a shape that are tried: between legs, or between the values of a quantity."""
    if searched == "time":
        moments = _moments(model)
        places = np.linspace(0, max(len(moments) - 1, 0), min(MOMENTS, len(moments)))
        return np.asarray(moments[np.unique(places.astype(int))])
    if searched == "period":
        span, most = float(np.ptp(model.data.middle)), max(model.data.n / LEGS_IN_TURN, 1.0)
        return np.append(span / np.linspace(1.0, most, PERIODS), [DAY] if span > 0.5 * DAY else [])
    values = np.asarray(model.leg.speed if searched == "speed" else model.leg.depth)
    return np.asarray(np.quantile(values, np.linspace(*MIDDLE, THRESHOLDS)))


def answers(model: TransitFitting, term: LegTerm, water: Array) -> Array:
    """Columns of a term that depends on the current, for one of these velocities, shape (2, n, q)."""
    info = CATALOGUE[term.effect]
    assert term.acting is not None
    found = []
    for each in term.acting.coordinates:
        effect = cast(TransitEffect, info.make({each.name: 1.0}))
        found.append(model.axes.T @ effect.answer_to_current(model.leg, water) * each.slab)
    return np.stack(found, axis=2)


def _smooth(model: TransitFitting) -> list[LegTerm]:
    """Smooth errors along the axes of a log, and along two of them together."""
    axes = transit_axes(model.data, model.leg, model.axes)
    wanted = [axis for axis in axes if (axis.name, axis.description) != IS_DESCRIBED]
    found = [replace(_along(axis, length), log_share=-math.log(len(LENGTHS))) for axis in wanted for length in LENGTHS]
    return found + [_along(axis, LENGTHS[0]) for axis in paired_axes(model.data, model.leg, model.axes)]


def _along(axis: Axis, length: float) -> LegTerm:
    """A smooth error; one ahead or abeam has a level of its own: what is constant in it is no cause beside it."""
    smooth = principal_components(axis.smooth_columns(length), MOST_COLUMNS, LEAST_SHARE)
    level = axis.response.sum(axis=1, keepdims=True)[:, : 2 - axis.functions]
    columns = SIZE * np.concatenate([smooth, level], axis=1)
    by_leg = np.moveaxis(columns.reshape(len(columns) // 2, 2, -1), 1, 0)
    return LegTerm("", axis.name, axis.description, by_leg, 0.0, length=length)
