"""Columns that compete beside all sets of causes, one at a time: terms of effects, and smooth errors along axes.

An effect that acts by its terms (`effects.info.Term`) is linear in a few strengths at each value of a shape: the moment
of a change, a threshold. Every value tried is a column or two under a prior of its own. Named effects have the
catalogue's; the neutral response, and smooth random functions of one quantity or two (Kennedy & O'Hagan 2001, *J. R.
Stat. Soc. B* 63; Brynjarsdóttir & O'Hagan 2014, *Inverse Problems* 30) by their leading principal components, share
that of `UNNAMED`. A velocity fixed to the Earth that changes with time is not among the smooth ones, but where it comes
and goes: random effects of the catalogue describe it.
"""

import itertools
import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.inference.axes import Axis, principal_components
from missionplan.diagnosis.legs.fitting import TransitFitting
from missionplan.diagnosis.legs.likelihood.mean import ActingTerm
from missionplan.diagnosis.legs.smooth_axes import (
    FLOW_LENGTH,
    LEGS_IN_TURN,
    across_lines,
    along_one_line,
    flow_columns,
    paired_axes,
    transit_axes,
    waves_of_water,
)
from missionplan.effects import CATALOGUE, EffectInfo, effects_of
from missionplan.effects.info import Term
from missionplan.phases.hooks import TransitEffect, velocity_error
from missionplan.results.learned.evidence import Causes

UNNAMED = 0.05
"""Prior odds of all neutral terms together, beside whatever is named: as much as what is said to be so may be wrong.
By Markov's inequality they are called 95 % probable without any effect with a chance of 0.05/19 at most."""
SIZE = 0.04
"""Usual size of a neutral response [m/s]: as of the catalogue's effects in the middle of their sizes."""
SMOOTH_SIZE = 0.025
"""Usual size of a smooth one, whose many columns have all the size of their slab: one column is as often smaller."""
LENGTHS = (0.4, 0.15)
"""Correlation lengths of a smooth one, of the record's extent along the axis."""
MOST_COLUMNS, LEAST_SHARE = 24, 0.01
"""Principal components kept at most, and least share of the first one's variance that one has."""
MOMENTS = {1: 16, 2: 12}
"""Most values tried of the moment of a change, and of each of two."""
THRESHOLDS, MOST_TIMES = 6, 8
"""Values tried of a threshold, and of how often something comes and goes in a circle of courses."""
TURNS = 2.0
"""Periods tried for each turn in the record: between two of them they differ by half a turn."""
DAY = 86400.0
MIDDLE = (0.15, 0.85)
"""Part of a log within which something may change: before and after it there must be legs that show it."""
TOGETHER = 65536
"""Numbers of columns at many values of a shape that are computed together, and lie side by side."""
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
    shape: tuple[Scalars, ...] = ()
    """Of one without a name: correlation length, of the record's extent, and direction, or the shape that is tried."""

    @property
    def is_neutral(self) -> bool:
        """Whether it names no cause."""
        return not self.effect or CATALOGUE[self.effect].tier == "neutral"

    @property
    def key(self) -> tuple[str, str, str, tuple[Scalars, ...]]:
        """What distinguishes it from all others."""
        shapes = self.shape if self.acting is None else tuple(self.acting.shapes.values())
        return self.effect, self.axis, self.description, shapes

    def is_alike(self, other: "LegTerm") -> bool:
        """Whether both are the same term, at whatever shape."""
        return self.key[:-1] == other.key[:-1]


def terms_of(model: TransitFitting) -> tuple[LegTerm, ...]:
    """Return all terms that a log could show, those of effects that the mission has already apart."""
    mission_effects = {prior.effect for prior in model.given}
    members: list[LegTerm] = []
    families = 0
    for info in effects_of("transit"):
        if not info.terms or info.id in mission_effects or info.lacking(model.record):
            continue
        terms = [term for term in info.terms if not term.lacking(model.record)]
        families += len(terms) if info.tier == "neutral" else 0
        members += [member for term in terms for member in _members(model, info, term)]
    smooth = _smooth(model)
    share = math.log(max(families + sum(math.exp(term.log_share) for term in smooth), 1.0) / UNNAMED)
    return tuple(
        replace(term, log_share=term.log_share - share) if term.is_neutral else term for term in [*members, *smooth]
    )


def without_a_name(terms: Sequence[LegTerm], numbers: Collection[int]) -> tuple[LegTerm, ...]:
    """Return terms of which those of some numbers, from 1, are neutral, with the share of the prior of such a one."""
    share = max(term.log_share for term in terms if term.is_neutral)

    def neutral(term: LegTerm) -> LegTerm:
        what = CATALOGUE[term.effect].parameters[term.axis].doc
        return replace(term, effect="", description=what, log_share=term.log_share + share)

    return tuple(neutral(term) if number in numbers else term for number, term in enumerate(terms, start=1))


def refined(model: TransitFitting, likeliest: LegTerm) -> list[LegTerm]:
    """Return a term at all moments near one of those tried, one leg from the next, with their share of its prior."""
    if likeliest.acting is None or not likeliest.acting.shapes:
        return []
    info, shapes = CATALOGUE[likeliest.effect], likeliest.acting.shapes
    strengths = tuple(coordinate.name for coordinate in likeliest.acting.coordinates)
    term = next(term for term in info.terms if term.strengths == strengths)
    if any(info.parameters[name].searched != "time" for name in term.searched):
        return []
    tried, moments = _tried(model, info, term), _moments(model)
    apart = math.ceil(len(moments) / MOMENTS[len(shapes)])
    places = [int(np.searchsorted(moments, float(np.asarray(shapes[name])))) for name in term.searched]
    near = [moments[max(place - apart, 0) : place + apart + 1].tolist() for place in places]
    finer = [values for values in _in_order(term, near) if values not in tried]
    share = likeliest.log_share + math.log(len(tried)) - math.log(math.comb(len(moments), len(shapes)))
    return [replace(member, log_share=share) for member in _members(model, info, term, finer)]


def at_size(model: TransitFitting, term: LegTerm, causes: Causes, values: Array, coefficients: Array) -> LegTerm:
    """Return a term that turns the course with columns from nil to a size, beside causes of these coordinates.

    `values`, (k,): coordinates of the model. `coefficients`, (q,): standard normal ones of the term.
    """
    acting = term.acting
    turns = acting is not None and cast(TransitEffect, CATALOGUE[acting.effect].make({})).changes_course
    if acting is None or not turns or abs(coefficients[0]) < STEP:
        return term
    with_term = model.with_term(acting)
    sizes = coefficients * [coordinate.slab for coordinate in acting.coordinates]
    together = np.concatenate([values, sizes])[with_term.from_last(acting)]
    names = [name for name in causes if name in model.by_effect]
    moved = with_term._error([*names, acting.effect], together) - model._error(names, values)
    return replace(term, columns=(model.axes.T @ moved / coefficients[0])[:, :, None])


def _members(
    model: TransitFitting, info: EffectInfo, term: Term, wanted: Sequence[Mapping[str, Scalars]] | None = None
) -> list[LegTerm]:
    """A term at each value of its shapes, or at some.

    A strength has the catalogue's usual size, or of a neutral response that of what errs as much as is usual.
    """
    tried = _tried(model, info, term) if wanted is None else wanted
    first, share = term.strengths[0], -math.log(max(len(tried), 1))
    parameters = [info.parameters[name] for name in term.strengths]
    what = parameters[0].doc if info.tier == "neutral" else info.what
    effect = cast(TransitEffect, info.make(dict.fromkeys(term.strengths, 1.0)))
    does_answer = bool(np.any(effect.answer_to_current(model.leg, np.ones((2, model.data.n)))))
    depths, members = max(float(np.nan_to_num(model.record.depths)), 1e-9), []
    for shapes, columns in zip(tried, unit_columns(model, info, term.strengths, tried=tried), strict=True):
        sizes = np.array([min(parameter.scale, parameter.extent_scale / depths) for parameter in parameters])
        if info.tier == "neutral" and not does_answer:
            rms = np.sqrt(np.mean(np.sum(columns**2, axis=0), axis=0))
            sizes = np.where(rms > 0.0, SIZE / np.maximum(rms, 1e-300), 0.0)
        if sizes.min() <= 0.0:
            continue
        coordinates = tuple(
            Coordinate(info.id, name, "strength", 0.0, size, parameter.spike)
            for name, parameter, size in zip(term.strengths, parameters, sizes.tolist(), strict=True)
        )
        acting = ActingTerm(info.id, coordinates, shapes)
        columns *= sizes
        members.append(LegTerm(info.id, first, what, columns, share, acting, does_answer))
    return members


def unit_columns(
    model: TransitFitting,
    info: EffectInfo,
    strengths: Sequence[str],
    water: Array | float = 0.0,
    tried: Sequence[Mapping[str, Scalars]] = ({},),
) -> Iterator[Array]:
    """Velocity errors of an effect a unit of each strength, at each of some values of its shapes, shape (2, n, q).

    Without water nothing answers to it. Columns at many values lie side by side in memory, and can be whitened as they
    are (`JointColumns`).
    """
    n, leg = model.data.n, model.leg
    fields = {name: getattr(leg, name) for name in ("t_start", "duration", "start", "along")}
    fields |= {name: np.broadcast_to(getattr(leg, name), n) for name in ("speed", "depth")}
    together = max(TOGETHER // n, 1)
    for first in range(0, len(tried), together):
        some = tried[first : first + together]
        repeated: dict[str, Any] = {name: np.tile(values, len(some)) for name, values in fields.items()}
        legs, columns = replace(leg, **repeated), np.empty((2, n, len(some), len(strengths)))
        shapes = {name: np.repeat([values[name] for values in some], n) for name in some[0]}
        moved = np.tile(np.broadcast_to(water, (2, n)), len(some))
        for place, name in enumerate(strengths):
            step = STEP * info.parameters[name].scale
            effect = cast(TransitEffect, info.make({**shapes, name: step}))
            error = model.axes.T @ velocity_error((effect,), legs, moved) / step
            columns[..., place] = error.reshape(2, len(some), n).swapaxes(1, 2)
        yield from np.moveaxis(columns, 2, 0)


def _moments(model: TransitFitting) -> Array:
    """Moments after the mission's start at which something may change: a leg of the middle begins, not the first."""
    n = model.data.n
    middle = model.data.t_start[max(int(MIDDLE[0] * n), 1) : int(MIDDLE[1] * n) + 1]
    return np.asarray(middle[middle > 0.0])


def _tried(model: TransitFitting, info: EffectInfo, term: Term) -> list[dict[str, Scalars]]:
    """Values of its shapes at which a term is tried: between legs, or between the values of a quantity."""
    values = [_values(model, info.parameters[name].searched, len(term.searched)) for name in term.searched]
    return _in_order(term, values)


def _in_order(term: Term, values: Sequence[Sequence[float]]) -> list[dict[str, Scalars]]:
    """Values of the shapes of a term, the moment until which it acts after that from which it does."""
    chosen = (combination for combination in itertools.product(*values) if all(np.diff(combination) > 0.0))
    return [dict(zip(term.searched, combination, strict=True)) for combination in chosen]


def _values(model: TransitFitting, searched: str, shapes: int) -> list[float]:
    """Values of a shape, one of so many, that are tried."""
    if searched == "time":
        moments = _moments(model)
        places = np.linspace(0, max(len(moments) - 1, 0), min(MOMENTS[shapes], len(moments)))
        return list(moments[np.unique(places.astype(int))].tolist())
    if searched == "period":
        span, most = float(np.ptp(model.data.middle)), max(model.data.n / LEGS_IN_TURN, 1.0)
        periods = span / np.linspace(1.0, most, math.ceil(TURNS * most))
        return [*periods.tolist(), *([DAY] if span > 0.5 * DAY else [])]
    if searched == "course":
        return list(range(1, MOST_TIMES + 1))
    values = np.broadcast_to(model.leg.speed if searched == "speed" else model.leg.depth, model.data.n)
    return list(np.unique(np.quantile(values, np.linspace(*MIDDLE, THRESHOLDS))).tolist())


def answers(model: TransitFitting, term: LegTerm, water: Array) -> Array:
    """Columns of a term that depends on the current, for one of these velocities, shape (2, n, q)."""
    assert term.acting is not None
    coordinates = term.acting.coordinates
    (columns,) = unit_columns(model, CATALOGUE[term.effect], [coordinate.name for coordinate in coordinates], water)
    return columns * [coordinate.slab for coordinate in coordinates]


def _smooth(model: TransitFitting) -> list[LegTerm]:
    """Smooth errors along the axes of a log, and along two of them together; others at each value of their shapes."""
    axes = transit_axes(model.data, model.leg, model.axes)
    wanted = [axis for axis in axes if axis.name != "time" or not _is_fixed_to_earth(axis)]
    pairs = paired_axes(model.data, model.leg, model.axes)
    lines = [axis for axis in wanted if _is_fixed_to_earth(axis) and axis.name != "heading"]
    terms = _along([[axis] for axis in wanted] + [along_one_line(axis) for axis in lines], LENGTHS)
    terms += _along([along_one_line(axis) if _is_fixed_to_earth(axis) else [axis] for axis in pairs], LENGTHS[:1])
    flow = SMOOTH_SIZE * principal_components(flow_columns(model.data, model.axes), MOST_COLUMNS, LEAST_SHARE)
    eddies = "a velocity that changes with place as in eddies"
    terms.append(LegTerm("", "place", eddies, _by_leg(flow), 0.0, shape=(FLOW_LENGTH,)))
    waves_tried = waves_of_water(model.data, model.leg, model.axes)
    tried = itertools.chain(across_lines(model.data, model.leg, model.axes), waves_tried)
    waves: list[LegTerm] = []
    for size, alike in itertools.groupby(tried, lambda trial: trial.columns.shape[1]):
        while some := list(itertools.islice(alike, max(TOGETHER // (model.data.n * size), 1))):
            together = np.ascontiguousarray(_by_leg(SIZE * np.stack([trial.columns for trial in some], axis=1)))
            parts = zip(some, np.moveaxis(together, 2, 0), strict=True)
            waves += [LegTerm("", trial.axis, trial.words, columns, 0.0, shape=trial.shape) for trial, columns in parts]
    counts = Counter(wave.description for wave in waves)
    return terms + [replace(wave, log_share=-math.log(counts[wave.description])) for wave in waves]


def _is_fixed_to_earth(axis: Axis) -> bool:
    return {"ahead", "abeam"}.isdisjoint(axis.description.split())


def _along(families: Sequence[Sequence[Axis]], lengths: Sequence[float]) -> list[LegTerm]:
    """Smooth errors along axes of which each family is one, over several lengths.

    One ahead or abeam has a level of its own: what is constant in it is no cause beside it.
    """
    terms = []
    for family in families:
        share = -math.log(len(family) * len(lengths))
        for (number, axis), length in itertools.product(enumerate(family), lengths):
            columns = principal_components(axis.smooth_columns(length), MOST_COLUMNS, LEAST_SHARE)
            if not _is_fixed_to_earth(axis):
                level = axis.response.reshape(len(columns), axis.functions, -1).sum(axis=2)
                columns = np.concatenate([columns, level], axis=1)
            columns = _by_leg(SMOOTH_SIZE * columns)
            terms.append(LegTerm("", axis.name, axis.description, columns, share, shape=(length, number)))
    return terms


def _by_leg(columns: Array) -> Array:
    """Columns leg by leg, shape (2n, …), as (2, n, …)."""
    return np.moveaxis(columns.reshape(len(columns) // 2, 2, *columns.shape[1:]), 1, 0)
