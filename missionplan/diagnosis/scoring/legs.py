"""What a mission expects of the legs of a navigation log, by the code that moves the vehicle in `simulate`.

`GroundVelocity` is run along the legs as they were logged: with the draws of the mission and no random errors for what
is expected, and with one random error at a time for the covariance of the rest, which is linear in them.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from missionplan.arrays import Array, Scalars
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.legs.kind import check_cover
from missionplan.diagnosis.scoring.predictive import Ensemble, Noise, Part, explained
from missionplan.mission import Mission
from missionplan.phases.hooks import TransitEffect
from missionplan.phases.transit.ground_velocity import GroundVelocity
from missionplan.phases.transit.plan import Environment, TransitNormals
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current

DRAWS = 2048
"""Draws of the mission's uncertain quantities."""
NOISES, LEGS_TIMES_NOISES = (4, 64), 6400
"""Draws of the sizes of what is random, at least and at most; their number times that of the legs."""
TOGETHER = 8192
"""Trials in which several draws are run at once."""
SCALES = 32
"""Equally likely scales of errors with heavy tails."""


@dataclass(frozen=True)
class SingleLegs:
    """Standard normals of one source: zero but for one leg, one component and one trial of each draw."""

    legs: int
    """n."""
    trials: int
    """Of all sources together."""
    first: int | None
    """Trial of the first of the 2n; None: zero everywhere."""
    draws: int = 1
    """One after the other, each with all trials."""

    def leg(self, number: int) -> Array:
        """Normals of a leg, shape (2, draws * trials)."""
        normals: Array = np.zeros((2, self.draws, self.trials))
        if self.first is not None:
            here = self.first + 2 * number
            normals[0, :, here], normals[1, :, here + 1] = 1.0, 1.0
        return normals.reshape(2, -1)


def leg_errors(
    data: TransitData, scenario: Scenario, effects: Sequence[TransitEffect], normals: TransitNormals, trials: int
) -> Array:
    """Position error on surfacing of each leg by the phase, without errors of fixes, shape (n, 2, trials) [m].

    The mission's first transit along the legs of a log.
    """
    plan, environment = scenario.transit_plan(scenario.transit()), Environment(scenario.current, None, tuple(effects))
    errors = np.zeros((data.n, 2, trials))
    for run in np.unique(data.run):  # what persists begins anew with each run
        moved = GroundVelocity(plan, environment, normals, trials)
        for leg in np.flatnonzero(data.run == run).tolist():
            seconds, surface = float(data.under_way[leg]), float(data.surface[leg])
            t, duration = np.full(trials, data.t_start[leg]), np.full(trials, seconds)
            start = np.repeat(data.start[:, leg : leg + 1], trials, axis=1)
            through = np.repeat((data.dead_reckoned - data.start)[:, leg : leg + 1], trials, axis=1)
            speed, leg_normals = float(np.hypot(*through[:, 0])) / seconds, normals.velocity.leg(leg)
            error = moved.of_leg(leg, leg_normals[:, :trials], t, duration, start, through, speed) * seconds
            if surface > 0.0:
                afloat = GroundVelocity(replace(plan, surfacing_time=surface), environment, normals, trials)
                error = error + afloat.at_surface(t + duration, start + through) * surface
            errors[leg] = error
    return errors


def leg_ensemble(data: TransitData, mission: Mission, seed: int) -> Ensemble:
    """Return a mission's distribution of the position errors of a log's legs [m].

    Raises InputError when the mission has no transit or no navigation, or the log leaves the record of its current.
    """
    recorded = recorded_current(mission)
    means = Scenario.at_means(mission, recorded)
    if means.current is not None:
        check_cover(data, means.current, float(np.mean(means.transit().depth)), mission)
    parts = []
    for share, plain_mission in explained(mission):
        drawn = Scenario.at_means(plain_mission, recorded).sampled(seed=seed, block=0, size=DRAWS)
        trials = DRAWS if drawn.draws else 1
        every = drawn.effects_under_way(drawn.transit())
        effects = [effect for effect in every if not _scales_tails(effect)]  # in whose normals the errors are linear
        still = SingleLegs(data.n, trials, None)  # no random error
        normals = TransitNormals(still, effects=(still,) * len(effects))
        expected = leg_errors(data, drawn, effects, normals, trials).reshape(-1, trials).T
        count = min(trials, int(np.clip(LEGS_TIMES_NOISES // data.n, *NOISES)))
        noises = _noises_of(data, drawn, range(min(count, 2)))
        if len(noises) == 2 and np.allclose(noises[0].covariance, noises[1].covariance, rtol=1e-9):
            noises = noises[:1]
        else:
            noises += _noises_of(data, drawn, range(2, count))
        parts.append(Part(share, expected, tuple(replace(noise, weight=1.0 / len(noises)) for noise in noises)))
    error = data.end - data.dead_reckoned
    return Ensemble(error.T.ravel(), np.repeat(np.arange(data.n), 2), tuple(parts))


def _scales_tails(effect: TransitEffect) -> bool:
    """Whether an effect has heavy tails: one of an explanation that does not hold has none."""
    return bool(np.any(np.asarray(effect.error_scale(np.full((2, 1), 2.0))) != 1.0))


def _noises_of(data: TransitData, drawn: Scenario, draws: Sequence[int]) -> list[Noise]:
    """Covariances in some of the draws, as many of them run at once as `TOGETHER` allows."""
    every = list(drawn.effects_under_way(drawn.transit()))
    linear = [index for index, effect in enumerate(every) if not _scales_tails(effect)]
    random = [index for index in linear if every[index].is_random]
    size = 2 * data.n
    trials = size * (1 + len(random)) + 1  # the last: no error at all
    most = max(1, TOGETHER // trials)
    noises = []
    for some in (draws[begin : begin + most] for begin in range(0, len(draws), most)):
        velocity, *sources = (
            SingleLegs(data.n, trials, None if first is None else size * first, len(some))
            for first in (0, *(1 + random.index(index) if index in random else None for index in linear))
        )
        together = _with_draws(drawn, np.repeat(some, trials))
        effects = list(together.effects_under_way(together.transit()))
        acting = [effects[index] for index in linear]
        normals = TransitNormals(velocity, effects=tuple(sources))
        errors = leg_errors(data, together, acting, normals, trials * len(some))
        by_draw = np.moveaxis(errors.reshape(size, len(some), trials), 1, 0)
        noises += [_noise(data, _with_draws(drawn, draw), errors) for draw, errors in zip(some, by_draw, strict=True)]
    return noises


def _with_draws(drawn: Scenario, draws: NDArray[np.intp] | int) -> Scenario:
    """Return the mission with these of its draws, one a trial, or as in one of them."""

    def chosen(_: str, value: Scalars) -> Scalars:
        return value[draws] if isinstance(value, np.ndarray) and value.ndim else value

    return replace(drawn, drawn=drawn.drawn.mapped(chosen))


def _noise(data: TransitData, scenario: Scenario, errors: Array) -> Noise:
    """Covariance of the random errors of all legs, and of their fixes, from the errors under each unit normal."""
    every = scenario.effects_under_way(scenario.transit())
    responses = errors[:, :-1] - errors[:, -1:]
    covariance = responses @ responses.T + _fix_covariance(data, scenario, every)
    tails = [effect for effect in every if _scales_tails(effect)]
    if not tails:
        return Noise(1.0, covariance, np.ones(1), np.zeros(2 * data.n))
    levels = ndtri((np.arange(SCALES) + 0.5) / SCALES)
    scales = np.ones(SCALES)
    for effect in tails:
        scales = scales * effect.error_scale(np.stack([levels, levels]))
    return Noise(1.0, covariance, scales, np.sum(responses[:, : 2 * data.n] ** 2, axis=1))


def _fix_covariance(data: TransitData, scenario: Scenario, effects: Iterable[TransitEffect]) -> Array:
    """Covariance of the legs' errors by those of the fixes; neighbours that share a fix share its error [m²].

    The log's own statement of its fixes goes before the mission's; an effect on fixes is added to either.
    """
    extra = sum(float(np.mean(effect.fix_variance())) for effect in effects)
    stated = data.typical_fix_sd
    fix_sd = float(np.mean(scenario.fix_error)) if stated is None else stated
    after = fix_sd * data.fix_scale
    shares = np.append(False, np.all(data.end[:, :-1] == data.start[:, 1:], axis=0) & (data.run[:-1] == data.run[1:]))
    before = np.where(shares, np.append(fix_sd, after[:-1]), fix_sd)
    total = np.diag(before**2 + after**2 + 2.0 * extra)
    later = np.flatnonzero(shares)
    total[later, later - 1] = total[later - 1, later] = -(before[later] ** 2 + extra)
    return np.asarray(np.kron(total, np.eye(2)), dtype=float)
