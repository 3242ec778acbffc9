"""Strength of effects on a log, in standard errors under the nuisances' covariance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from .catalogue import CATALOGUE, Array, LegEffect
from .outside import OUTSIDE
from .sailing import Log, displacement, simulate_log
from .survey import COMPASS_SD, CURRENT_SD, RANDOM, SPEED_SD, Survey

MINIMUM_STRENGTH = 12.0
"""Smallest strength of a systematic effect [standard errors]; a weaker one is made larger."""
MAXIMUM_STRENGTH = 40.0
"""Largest strength, approximately: beyond it the shape of an effect is measured rather than its kind."""
MINIMUM_STRENGTH_RANDOM = 5.0
"""Smallest strength of a random effect: the root of twice its log-likelihood ratio."""
MINIMUM_MISFIT = 5.0
"""Misfit left by the nearest systematic effect of the catalogue for an effect outside it [standard errors]."""


def covariance(survey: Survey, log: Log) -> Array:
    """Return the legs' position error covariance under the nuisances, east then north, shape (2 legs, 2 legs)."""
    variance = survey.sigma**2 * log.under_way**2 + 2.0 * survey.fix**2
    time, way = log.under_way, log.reckoned - log.fix_start
    zero = np.zeros_like(time)
    columns = [
        CURRENT_SD * np.concatenate([time, zero]),
        CURRENT_SD * np.concatenate([zero, time]),
        COMPASS_SD * np.concatenate([way[:, 1], -way[:, 0]]),
        SPEED_SD * np.concatenate([way[:, 0], way[:, 1]]),
    ]
    spikes = np.array(columns)
    return np.diag(np.concatenate([variance, variance])) + spikes.T @ spikes


def whiten(survey: Survey, log: Log, displacement: Array) -> Array:
    """Return displacements of the legs in standard errors, decorrelated."""
    factor = np.linalg.cholesky(covariance(survey, log))
    return np.linalg.solve(factor, displacement.T.ravel())


def random_strength(survey: Survey, log: Log, effect: LegEffect) -> float:
    """Root of twice the log-likelihood ratio of a random effect over the best independent errors."""
    assert effect.statistic is not None
    kind, first, second = effect.statistic
    error = (log.signal + log.noise) / log.under_way[:, None]
    middle = 0.5 * (log.t_start + log.t_end)
    fix = 2.0 * survey.fix**2 / log.under_way**2

    def gauss(sigma: float, extra: Array) -> float:
        matrix = np.diag(sigma**2 + fix) + extra
        logdet = np.linalg.slogdet(matrix).logabsdet
        return -0.5 * float(2.0 * logdet + np.sum(error * np.linalg.solve(matrix, error)))

    nothing = np.zeros((middle.size, middle.size))
    low = survey.sigma * np.exp(minimize(lambda x: -gauss(survey.sigma * np.exp(x[0]), nothing), [0.2]).x[0])
    base = gauss(low, nothing)
    if kind == "persistent-error":
        extra = first**2 * np.exp(-np.abs(middle[:, None] - middle) / second)
    elif kind == "random-walk":
        extra = first**2 * np.minimum.outer(middle, middle)
    elif kind == "fix-error":
        extra = np.diag(2.0 * first**2 / log.under_way**2)
    else:
        norm = np.sqrt(survey.sigma**2 + fix)
        density = _tail_log_density(kind, first, second, np.hypot(*(error.T / norm)))
        return float(np.sqrt(max(0.0, 2.0 * (np.sum(density - 2.0 * np.log(norm)) - base))))
    return float(np.sqrt(max(0.0, 2.0 * (gauss(survey.sigma, extra) - base))))


def _tail_log_density(kind: str, first: float, second: float, radius: Array) -> Array:
    """Log density of a scaled error: Student's t, or a mixture of good and bad legs."""
    if kind == "student":
        return -(first + 2.0) / 2.0 * np.log1p(radius**2 / first)
    wide = second**2
    return np.log((1.0 - first) * np.exp(-(radius**2) / 2.0) + first / wide * np.exp(-(radius**2) / 2 / wide))


@dataclass(frozen=True)
class BuiltEffect:
    """An effect with its comparable parameters and its size."""

    effect: LegEffect
    parameters: dict[str, float]
    size: float


@dataclass(frozen=True)
class HiddenEffects:
    """Effects as drawn: comparable parameters, sizes, strength, and the log with them."""

    parameters: dict[str, float]
    sizes: dict[str, float]
    strength: float
    log: Log


class _Trial:
    """Effects of given severities on a survey, with the same noise for every size."""

    def __init__(self, survey: Survey, shape: Mapping[str, int], noise_seed: Sequence[int]) -> None:
        self.survey, self.shape, self.noise_seed = survey, shape, noise_seed
        self.size: float | None = None  # of every effect, in the place of its severity

    def build(self, severity: Mapping[str, float], scale: float) -> dict[str, BuiltEffect]:
        """Build the effects; severities 0 to 1 span their ranges of sizes."""
        built = {}
        for name in self.shape:
            kind = (CATALOGUE | OUTSIDE)[name]
            size = scale * kind.low * (kind.high / kind.low) ** severity[name]
            size = size if self.size is None else self.size
            rng = np.random.default_rng(self.shape[name])
            built[name] = BuiltEffect(*kind.build(size, rng, self.survey.conditions), float(size))
        return built

    def log(self, *built: BuiltEffect) -> Log:
        """Simulate the log with some of the effects."""
        return simulate_log(self.survey, tuple(each.effect for each in built), np.random.default_rng(self.noise_seed))


def draw_hidden(
    survey: Survey,
    names: Sequence[str],
    rng: np.random.Generator,
    noise_seed: Sequence[int],
    scale: float,
    size: float | None = None,
) -> HiddenEffects | None:
    """Draw sizes, enlarging effects that are not clear; None if the largest is not clear. A size given is kept."""
    severity = {name: rng.uniform(0.0, 0.9 if len(names) == 1 else 0.6) for name in names}
    trial = _Trial(survey, {name: int(rng.integers(2**32)) for name in names}, noise_seed)
    trial.size = size
    if size is None and not _adjust(trial, severity):
        return None
    built = trial.build(severity, scale)
    log = trial.log(*built.values())
    parameters = {
        f"{name}.{key}": float(value) for name, each in built.items() for key, value in each.parameters.items()
    }
    sizes = {name: each.size for name, each in built.items()}
    return HiddenEffects(parameters, sizes, _strength(survey, log, built), log)


def _adjust(trial: _Trial, severity: dict[str, float]) -> bool:
    """Change the severities in place until every effect is clear and none too strong; False if that fails."""
    names, survey = list(severity), trial.survey
    enlarged = False
    while True:
        built = trial.build(severity, 1.0)
        alone = {name: trial.log(built[name]) for name in names}
        weak = [name for name in names if not _is_clear(survey, built, alone, name)]
        if not weak:
            single = len(names) == 1 and not enlarged
            strong = single and _strength(survey, alone[names[0]], built) > MAXIMUM_STRENGTH
            if strong and severity[names[0]] > -1.0:
                severity[names[0]] -= 0.25
                continue
            return True
        if any(severity[name] >= 1.0 for name in weak):
            return False
        severity |= {name: min(1.0, severity[name] + 0.34) for name in weak}
        enlarged = True  # not reduced again: an effect unlike the catalogue may have to be strong


def _strength(survey: Survey, log: Log, built: Mapping[str, BuiltEffect]) -> float:
    name = next(iter(built), None)
    if name in RANDOM and len(built) == 1:
        return random_strength(survey, log, built[name].effect)
    return float(np.linalg.norm(whiten(survey, log, log.signal)))


def _is_clear(survey: Survey, built: Mapping[str, BuiltEffect], alone: Mapping[str, Log], name: str) -> bool:
    """Whether an effect is strong enough alone and, in a pair, unlike the other one."""
    if name in RANDOM:
        return random_strength(survey, alone[name], built[name].effect) >= MINIMUM_STRENGTH_RANDOM
    own = whiten(survey, alone[name], alone[name].signal)
    if len(built) == 1:
        unlike = name in CATALOGUE or misfit_to_catalogue(survey, alone[name], own) >= MINIMUM_MISFIT
        return float(np.linalg.norm(own)) >= MINIMUM_STRENGTH and unlike
    other = next(each for each in built if each != name)
    if other in RANDOM:
        # a persistent random error masks a current: the larger of the two noises counts
        sigma = np.hypot(survey.sigma, np.std(alone[other].signal / alone[other].under_way[:, None]))
        return float(np.linalg.norm(own)) * survey.sigma / sigma >= 0.8 * MINIMUM_STRENGTH
    rival = whiten(survey, alone[other], alone[other].signal)
    return _misfit(own, rival) >= 0.6 * MINIMUM_STRENGTH


def _misfit(whitened: Array, rival: Array) -> float:
    """Norm of the displacement that a rival, scaled to fit best, does not explain [standard errors]."""
    share = float(rival @ whitened) / max(float(rival @ rival), 1e-12)
    return float(np.linalg.norm(whitened - share * rival))


def misfit_to_catalogue(survey: Survey, log: Log, whitened: Array) -> float:
    """Misfit left by the nearest systematic effect of the catalogue [standard errors]."""
    misfits = []
    for name in CATALOGUE.keys() - RANDOM:
        kind = CATALOGUE[name]
        effect, _ = kind.build(kind.low, np.random.default_rng(0), survey.conditions)
        misfits.append(_misfit(whitened, whiten(survey, log, displacement(survey, log, (effect,)))))
    return min(misfits)
