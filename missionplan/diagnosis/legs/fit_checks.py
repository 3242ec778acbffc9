"""Beside a fit to a navigation log: what it leaves, whether its causes hold still, wrong fixes, and aliases."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.discrepancy import differing_causes
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.designs import LATER, TRIAL_LEGS, short_trials
from missionplan.diagnosis.legs.model import TransitModel, leg_by_leg
from missionplan.diagnosis.legs.terms import unit_columns
from missionplan.effects import CATALOGUE, named_effects
from missionplan.results.learned.evidence import Alias, Causes, WrongFix

_DECLINATION, _CLOCK, _CURRENT = math.radians(1.0), 0.01, 0.1
"""By how much what a log takes as exact is put off: turn of its headings, gain of its clock, current [m/s]."""
FIRST_PREDICTED = 10
"""Legs seen before the first prediction."""
MAX_PAST_LEGS = 30
"""Legs that a prediction uses: currents keep their phase for some periods only."""
REFITS = 8
"""Times, at most, that the hyperparameters are refitted along the record."""
LEGS_OF_HALF = 10
"""Legs that either half needs."""


def put_off(model: TransitModel) -> Iterator[tuple[str, str, TransitModel]]:
    """Yield what a log takes as exact, what is put in its place, and the model then."""
    data, (cos, sin) = model.data, (math.cos(_DECLINATION), math.sin(_DECLINATION))
    reckoned = data.start + np.array([[cos, sin], [-sin, cos]]) @ (data.dead_reckoned - data.start)
    turned = replace(data, dead_reckoned=reckoned)
    yield "the log's headings have the right declination", "1° more", replace(model, data=turned)
    late = replace(data, t_start=data.t_start * (1.0 + _CLOCK), under_way=data.under_way * (1.0 + _CLOCK))
    yield "the log's clock runs right", "one that is 1 % slow", replace(model, data=late)
    if data.leg_fix_sd is not None or data.fix_sd:
        each, every = data.leg_fix_sd, data.fix_sd
        worse = replace(data, leg_fix_sd=None if each is None else 2.0 * each, fix_sd=every and 2.0 * every)
        yield "fixes err as stated", "twice as much", replace(model, data=worse)
    if np.any(model.site_current) and max(model.current_sd) < 0.1 * _CURRENT:
        for axis, name in enumerate(("east", "north")):
            more = model.base + _CURRENT * (np.arange(2) == axis)[:, None]
            words = "the current is as the mission has it", f"0.1 m/s more to the {name}"
            yield *words, replace(model, base=more)


def one_step(model: TransitModel, fit: CauseFit) -> dict[str, float]:
    """Predict every leg from the eleventh on; root mean squares of the position errors, none of a short record [m].

    By the mean of the past velocity errors, by the last leg's, and by the fitted set of causes, its hyperparameters
    refitted along the record, to past legs alone.
    """
    data = model.data
    if data.n < 2 * FIRST_PREDICTED:
        return {}
    predicted = np.arange(FIRST_PREDICTED, data.n)
    errors = []
    legs_per_refit = max(5, len(predicted) // REFITS)
    current = fit
    for k in predicted.tolist():
        if (k - FIRST_PREDICTED) % legs_per_refit == 0:
            current = model.refitted(current, np.arange(k))
        mean, _ = model.predicted(current, np.arange(max(0, k - MAX_PAST_LEGS), k), np.array([k]))
        errors.append(model.y[:, k] - mean[:, 0])
    velocity = data.velocity_error
    mean_so_far = np.cumsum(velocity, axis=1)[:, predicted - 1] / predicted
    left = {
        "next_leg_mean_so_far_rms_m": velocity[:, predicted] - mean_so_far,
        "next_leg_last_leg_rms_m": velocity[:, predicted] - velocity[:, predicted - 1],
        "next_leg_model_rms_m": np.stack(errors, axis=1),
    }
    moved = {name: error * data.under_way[predicted] for name, error in left.items()}
    return {name: float(np.sqrt(np.mean(np.sum(error**2, axis=0)))) for name, error in moved.items()}


def not_constant(model: TransitModel, fit: CauseFit) -> Causes:
    """Return the physical causes whose strengths differ between the halves of a log.

    The halves are the first and the second, and even and odd blocks of five legs; a modulated oscillation is compared
    with its modulation in the model.
    """
    count, acting = model.data.n, model.with_term(fit.state.term)
    physical = [name for name in fit.causes if CATALOGUE[name].tier == "physical" and name in acting.by_effect]
    if count < 2 * LEGS_OF_HALF:
        return ()
    columns = acting.columns_at(fit)
    by_cause = {name: leg_by_leg(columns[:, :, acting.by_effect[name]]) for name in physical}
    legs = np.arange(count)
    halves = [np.repeat(half, 2).astype(float) for half in (legs >= count // 2, legs // 5 % 2 == 1)]
    return differing_causes(
        partial(acting.residuals_along, fit), by_cause, [np.stack([1.0 - half, half], axis=1) for half in halves]
    )


OFF = 100.0
"""Usual size of the error of a wrong fix, each axis [m]: a receiver that has just surfaced, or hears reflections."""
ARE_WRONG = 0.01
"""Share of the fixes that are expected to be wrong, and of the legs that err alone."""
IS_SURE = 0.9
"""Probability from which a fix is called wrong."""
IS_LARGE = 3.0
"""Errors of both legs beside a wrong fix, of the median's size, from which it is looked at."""


def wrong_fixes(model: TransitModel, fit: CauseFit) -> tuple[WrongFix, ...]:
    """Return fixes that are probably wrong under a fit: what one leg errs by, the next errs the other way.

    Each fix within a run, its two legs predicted from all others, is weighed against one of the legs erring alone: all
    by an unknown displacement, normal with `OFF` each axis. Legs with others left out between them share no fix: the
    second begins away from where the first ends.
    """
    data, fixes = model.data, []
    size = np.hypot(*(model.y - np.median(model.y, axis=1, keepdims=True)))
    large = size > IS_LARGE * np.median(size)
    pairs = large[:-1] & large[1:] & (data.run[:-1] == data.run[1:])
    for k in np.flatnonzero(pairs).tolist():
        pair = np.array([k, k + 1])
        mean, covariance = model.predicted(fit, np.setdiff1d(np.arange(data.n), pair), pair)
        error = leg_by_leg(model.y[:, pair] - mean)
        one, other = (OFF * np.kron(side, np.eye(2)) for side in np.diag(1.0 / data.under_way[pair])[:, :, None])
        weights = [_log_evidence(error, covariance, columns) for columns in (one - other, one, other)]
        odds = np.exp(np.array([*weights, -math.log(ARE_WRONG)]) - max(weights))
        east, north = model.axes @ _displacement(error, covariance, one - other)
        if np.hypot(*(data.start[:, k + 1] - data.end[:, k])) < 0.5 * np.hypot(east, north):  # else it is another fix
            fixes.append(WrongFix(str(data.labels[k]), float(east), float(north), float(odds[0] / odds.sum())))
    return tuple(fix for fix in fixes if fix.probability >= IS_SURE)


def _displacement(error: Array, covariance: Array, columns: Array) -> Array:
    """Posterior mean of an unknown displacement with these columns for one of `OFF`, shape (2,) [m]."""
    weighted = np.linalg.solve(covariance, columns)
    return np.asarray(OFF * np.linalg.solve(np.eye(2) + columns.T @ weighted, weighted.T @ error))


def _log_evidence(error: Array, covariance: Array, columns: Array) -> float:
    """Log Bayes factor of errors with an unknown displacement over those without."""
    weighted = np.linalg.solve(covariance, columns)
    precision, along = np.eye(2) + columns.T @ weighted, weighted.T @ error
    return 0.5 * float(along @ np.linalg.solve(precision, along) - np.linalg.slogdet(precision)[1])


UNTOLD, TOLD = 3.0, 5.0
"""Expected nats below which these legs do not tell two effects apart, and from which legs do."""


def aliases(model: TransitModel, fit: CauseFit) -> tuple[Alias, ...]:
    """Return the aliases of each claimed cause in the mean.

    Another effect is as large as makes it likest to the cause on these legs (weighted least squares). Where what is
    left is worth less than `UNTOLD` nats under the fit's noise, half its squared size over the errors' covariance
    (Kass & Raftery 1995), it is an alias. It matters from the distance at which the two place the vehicle apart by two
    standard deviations of the errors of as many legs, on the same courses sailed the other way, later, at the mission's
    speed and depth. The trial that would part them is the shortest of a few legs more, all round the compass, that
    leaves `TOLD` nats between them.
    """
    model = model.with_term(fit.state.term)
    # the model of the same courses sailed the other way, at the mission's speed and depth
    data, depth, path = model.data, model.data.depth, model.data.dead_reckoned - model.data.start
    if model.planned is not None:
        path = model.leg.along * model.planned[0] * data.under_way
        depth = None if depth is None else np.full(data.n, model.planned[1])
    later = LATER + float(np.ptp(data.t_start))
    turned = data.start - path
    moved = replace(data, t_start=data.t_start + later, dead_reckoned=turned, end=turned, depth=depth)
    here, back = _Legs.of(model, fit), _Legs.of(replace(model, data=moved, only=model.with_term(None).coordinates), fit)
    trials: list[tuple[str, _Legs]] = []
    aliases = []
    for claimed in fit.causes:
        places = model.by_effect.get(claimed)
        if places is None:
            continue
        size = fit.state.mean[places]
        for other, columns in here.columns.items():
            if other in fit.causes or other not in back.columns:
                continue
            alike, left = _likest(here.columns[claimed] @ size, columns, here.noise)
            apart = back.columns[claimed] @ size - back.columns[other] @ alike
            distance = _matters_from(back.model, apart, here.noise)
            if left < UNTOLD and distance < np.inf:
                trials = trials or [(words, _Legs.of(model.of_longer(d), fit)) for words, d in short_trials(model.data)]
                trial = _cheapest(trials, claimed, other, size) or CATALOGUE[other].distinguished_by
                aliases.append(Alias(claimed, other, distance, trial))
    return tuple(sorted(aliases, key=lambda alias: alias.matters_from))


@dataclass(frozen=True)
class _Legs:
    """Legs with the columns of all effects, as a fit has them, and the standard deviation of their errors, (2, n)."""

    model: TransitModel
    columns: dict[str, Array]
    noise: Array

    @classmethod
    def of(cls, model: TransitModel, fit: CauseFit) -> "_Legs":
        noise = np.sqrt(np.stack([np.diag(covariance) for covariance in model.noise(fit.state.values)]))
        every = model.columns_at(fit)
        columns = {name: every[:, :, places] for name, places in model.by_effect.items()}
        return cls(model, columns | dict(_of_terms(model, model.water(fit.causes, fit.state.mean))), noise)


def _cheapest(trials: Sequence[tuple[str, _Legs]], claimed: str, other: str, size: Array) -> str:
    """The trial of least time under way after which the legs tell a claimed effect from another, in words, or none."""
    choices = []
    for words, legs in trials:
        total = legs.model.data.n
        for count in range(1, TRIAL_LEGS + 1):
            until = total - TRIAL_LEGS + count
            signal = legs.columns[claimed][:, :until] @ size
            if _likest(signal, legs.columns[other][:, :until], legs.noise[:, :until])[1] >= TOLD:
                time = float(legs.model.data.t_start[until - 1] + legs.model.data.under_way[until - 1])
                choices.append((time, f"{count} more {'leg' if count == 1 else 'legs'} all round the compass, {words}"))
                break
    return min(choices)[1] if choices else ""


def _of_terms(model: TransitModel, water: Array) -> Iterator[tuple[str, Array]]:
    """Named effects that act by their terms, with their columns; none that need a moment."""
    for info in named_effects("transit"):
        for term in info.terms:
            if term.searched or info.id in model.by_effect:
                continue
            (together,) = unit_columns(model, info, term.strengths, water)
            if np.isfinite(together).all() and together.any():
                yield info.id, together


def _likest(signal: Array, columns: Array, noise: Array) -> tuple[Array, float]:
    """Coefficients with which columns are likest to a signal, and the nats that tell them from it."""
    weighted = (columns / noise[:, :, None]).reshape(-1, columns.shape[2])
    wanted = (signal / noise).ravel()
    alike = np.linalg.lstsq(weighted, wanted, rcond=1e-9)[0]
    return np.asarray(alike), 0.5 * float(np.sum((wanted - weighted @ alike) ** 2))


def _matters_from(model: TransitModel, apart: Array, noise: Array) -> float:
    """Distance from which velocity errors apart displace the vehicle by two standard deviations of n legs' errors [m].

    The displacement grows as n, the errors as √n.
    """
    under_way = model.data.under_way
    displacement = float(np.sqrt(np.mean(np.sum((apart * under_way) ** 2, axis=0))))
    spread = float(np.sqrt(np.mean(np.sum((noise * under_way) ** 2, axis=0))))
    length = float(np.mean(model.leg.speed * under_way))
    return length * max((2.0 * spread / displacement) ** 2, 1.0) if displacement > 1e-3 * spread else np.inf
