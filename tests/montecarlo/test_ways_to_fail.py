"""Several ways to fail whose probabilities together are known: none is missed, what they share counts once."""

import math
from collections.abc import Callable, Iterator, Sequence
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from missionplan.montecarlo.rare_events import Key, NormalPopulation, failure_search
from missionplan.montecarlo.rare_events.failure_search import CHAINS, Batch, FailureSearch, Found, Part, find
from missionplan.montecarlo.rare_events.strata import (
    RARE,
    DiscreteValue,
    ReliabilityIndices,
    StrataView,
    TrialMargins,
    strata,
)

Inputs = Sequence[Callable[[np.ndarray], np.ndarray]]


def here(task, items) -> Iterator:
    return (task(item) for item in items)


def search(model, seed: int, values: dict[Key, list[DiscreteValue]] | None = None, variation: float = 0.1) -> Found:
    plain = model(StrataView(NormalPopulation(2048, np.random.default_rng(1_000_000 + seed))))
    wanted = FailureSearch(model, strata(values or {}), ReliabilityIndices.of(plain), seed, lambda view, weights: None)
    return find(wanted, here, variation=variation, most_trials=1_000_000)


def inputs_beyond(probabilities: Sequence[float], transforms: Inputs):
    """Fail where an input lies beyond its limit; each is a transform of a normal of its own."""
    limits = [float(each(np.array(norm.isf(p)))) for each, p in zip(transforms, probabilities, strict=True)]

    def model(view: StrataView) -> TrialMargins:
        drawn = [each(view.cell(f"input {number}")[0]) for number, each in enumerate(transforms)]
        margins = np.array([limit - value for limit, value in zip(limits, drawn, strict=True)])
        return TrialMargins(margins, (margins <= 0.0).any(axis=0))

    return model, 1.0 - math.prod(1.0 - p for p in probabilities)


def same(z: np.ndarray) -> np.ndarray:
    return z


def log_normal(factor: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda z: factor**z


def uniform(z: np.ndarray) -> np.ndarray:
    return norm.cdf(z)


# The table of what one scalar for all ways missed: always on the unsafe side, by a half and more.
CASES = [
    ((1e-6, 1e-6), (same, same)),
    ((1e-6, 1e-6), (same, log_normal(1.5))),
    ((1e-6, 1e-6), (same, log_normal(2.0))),
    ((1e-7, 1e-5), (same, log_normal(3.0))),
    ((1e-5, 1e-3), (same, uniform)),
    ((1e-8, 1e-7, 1e-4, 2e-3, 1e-3), (log_normal(4.0), same, uniform, log_normal(1.2), same)),
]


def judged(found: Sequence[Found], truth: float) -> tuple[np.ndarray, float, float]:
    values = np.array([each.estimate.value for each in found]) / truth
    holds = np.mean([each.estimate.low <= truth <= each.estimate.high for each in found])
    return values, float(holds), float(np.mean([each.estimate.high < truth for each in found]))


@pytest.mark.parametrize(("probabilities", "transforms"), CASES)
def test_neither_skewed_nor_bounded_inputs_hide_a_way(probabilities, transforms) -> None:
    model, truth = inputs_beyond(probabilities, transforms)
    found = search(model, 0)
    values, _, _ = judged([found], truth)
    assert values == pytest.approx(1.0, abs=0.4)
    for way, probability in enumerate(probabilities):
        if probability > 0.1 * truth:
            assert found.probability(way) == pytest.approx(probability, rel=0.6)


@pytest.mark.slow
@pytest.mark.parametrize(("probabilities", "transforms"), CASES)
def test_two_hundred_searches_are_unbiased_and_their_intervals_hold(probabilities, transforms) -> None:
    model, truth = inputs_beyond(probabilities, transforms)
    values, holds, below = judged([search(model, seed) for seed in range(200)], truth)
    assert values.mean() == pytest.approx(1.0, abs=max(0.01, 3.0 * values.std() / math.sqrt(200)))
    assert 0.91 <= holds <= 0.99
    assert below <= 0.06


def test_a_bounded_input_near_its_limit_does_not_trap_the_search() -> None:
    """A velocity error uniform to 0.0999 of 0.1 m/s, which never fails, beside a battery that fails at 10⁻⁵."""

    def model(view: StrataView) -> TrialMargins:
        margins = np.array([0.1 - 0.0999 * norm.cdf(view.cell("speed")[0]), norm.isf(1e-5) - view.cell("battery")[0]])
        return TrialMargins(margins, (margins <= 0.0).any(axis=0))

    found = search(model, 0)
    assert found.estimate.value == pytest.approx(1e-5, rel=0.4)
    assert found.probability(0) == 0.0


def test_what_correlated_ways_share_counts_once() -> None:
    rho, p = 0.9, 1e-4
    limit = norm.isf(p)

    def model(view: StrataView) -> TrialMargins:
        a, b = view.cell("a")[0], view.cell("b")[0]
        margins = limit - np.array([a, rho * a + math.sqrt(1.0 - rho**2) * b])
        return TrialMargins(margins, (margins <= 0.0).any(axis=0))

    both = multivariate_normal.cdf([-limit, -limit], cov=[[1.0, rho], [rho, 1.0]])
    truth = 2.0 * p - both
    assert both > 0.3 * p
    found = [search(model, seed) for seed in range(6)]
    assert np.mean([each.estimate.value for each in found]) == pytest.approx(truth, rel=0.12)
    assert np.mean([each.probability(0) for each in found]) == pytest.approx(p, rel=0.15)


def test_a_failure_without_a_margin_is_met_where_the_others_lead() -> None:
    """The margin nears zero but does not cross it: what fails near its end is led to by ranks."""

    def model(view: StrataView) -> TrialMargins:
        u = view.cell("u")[0]
        return TrialMargins(np.exp(-u)[None], u >= norm.isf(1e-5))

    found = search(model, 0)
    assert found.estimate.value == pytest.approx(1e-5, rel=0.4)
    assert found.probability(0) == 0.0
    assert found.probability(1) > 0.0


def one_of(share: float):
    """A cause of known probability under which half of the trials fail, beside a tail of 10⁻⁷."""

    def model(view: StrataView) -> TrialMargins:
        holds = norm.cdf(view.cell("which")[0]) < share
        margins = np.array([norm.isf(1e-7) - view.cell("tail")[0], np.where(holds, view.cell("other")[0], 1.0)])
        return TrialMargins(margins, (margins <= 0.0).any(axis=0))

    values = [DiscreteValue("which", "yes", (0.0, share)), DiscreteValue("which", "no", (share, 1.0))]
    return model, {("which", 0): values}, 0.5 * share + 1e-7 * (1.0 - 0.5 * share)


@pytest.mark.parametrize("share", [1e-5, 1e-7, 0.03])
def test_a_discrete_cause_of_known_probability_is_not_searched_for(share: float) -> None:
    model, values, truth = one_of(share)
    assert search(model, 0, values).estimate.value == pytest.approx(truth, rel=0.35)


def test_strata_are_all_trials_once() -> None:
    values = {
        ("a", 0): [DiscreteValue("a", str(n), ends) for n, ends in enumerate([(0.0, 0.5), (0.5, 0.51), (0.51, 1.0)])],
        ("b", 0): [DiscreteValue("b", str(n), ends) for n, ends in enumerate([(0.0, 1e-6), (1e-6, 1.0)])],
    }
    parts = strata(values)
    assert [part.value.value if part.value else None for part in parts] == [None, "1", "0"]
    assert math.fsum(part.probability for part in parts) == pytest.approx(1.0, abs=1e-15)
    assert parts[2].probability == pytest.approx(0.99e-6, rel=1e-9)
    population = NormalPopulation(3000, np.random.default_rng(1))
    a, b = (norm.cdf(StrataView(population, parts).cell(name)[0]).reshape(3, -1) for name in "ab")
    assert ((a[0] < 0.5) | (a[0] > 0.51)).all()
    assert ((a[1] >= 0.5) & (a[1] <= 0.51)).all()
    assert ((a[2] < 0.5) | (a[2] > 0.51)).all()
    assert (b[2] <= 1e-6).all()
    assert (b[0] >= 1e-6).all()
    assert a[0][a[0] < 0.5].size / 1000 == pytest.approx(0.5 / 0.99, abs=0.06)


def test_likely_values_get_no_stratum() -> None:
    edges = np.linspace(0.0, 1.0, 11)
    values = {("m", 0): [DiscreteValue("m", str(n), (edges[n], edges[n + 1])) for n in range(10)]}
    assert RARE < 0.1
    (usual,) = strata(values)
    assert usual.probability == 1.0
    assert not usual.allowed


def test_a_trial_that_fails_weighs_its_stratum_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of strata of a quarter and three quarters, that fail in 0.1 and 0.01."""
    found = SimpleNamespace(failing=None, weights=np.full(2 * CHAINS, 0.5), trials=0)
    found.probabilities, found.counted = np.array([0.1, 0.01]), np.array([0.08, 0.01])
    monkeypatch.setattr(failure_search, "run_pilots", lambda *_: [])
    monkeypatch.setattr(failure_search, "run_levels", lambda *_: found)
    monkeypatch.setattr(failure_search, "StrataView", lambda failing, strata: strata)
    search = SimpleNamespace(
        **{"_drive": lambda _: None, "_stream": lambda _: None, "describe": lambda _, weights: weights},
        strata=[SimpleNamespace(probability=share) for share in (0.25, 0.75)],
    )
    run = FailureSearch.run(search, Batch((Part(0, 0), Part(1, 0)), "estimate", 0))
    assert run.described == pytest.approx(np.repeat([0.125, 0.375], CHAINS))
    assert (run.probabilities, run.counted) == (pytest.approx([0.025, 0.0075]), pytest.approx([0.02, 0.0075]))
