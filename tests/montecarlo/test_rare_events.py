"""Subset simulation on limit states whose probability of failure is known."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import scipy

from missionplan.montecarlo.rare_events.estimate import Estimate
from missionplan.montecarlo.rare_events.population import MovedPopulation, NormalPopulation, gathered
from missionplan.montecarlo.rare_events.subset_simulation import Pilot, Repetitions, repeat, run_pilot

Margin = Callable[[NormalPopulation], np.ndarray]


def linear(beta: float, dimensions: int) -> tuple[Margin, float]:
    """Fails beyond a plane at a distance: Φ(−β) in any number of dimensions."""

    def margin(population: NormalPopulation) -> np.ndarray:
        return beta - population.cell("u", 0, dimensions).sum(axis=0) / math.sqrt(dimensions)

    return margin, float(scipy.stats.norm.sf(beta))


def sphere(probability: float, dimensions: int) -> tuple[Margin, float]:
    """Fails outside a sphere: the upper tail of chi-square."""
    radius = math.sqrt(scipy.stats.chi2.isf(probability, dimensions))

    def margin(population: NormalPopulation) -> np.ndarray:
        return radius - np.sqrt((population.cell("u", 0, dimensions) ** 2).sum(axis=0))

    return margin, probability


def series_system(beta: float, parts: int) -> tuple[Margin, float]:
    """Fails when any of several independent parts does, on either side: as many separate regions of failure."""

    def margin(population: NormalPopulation) -> np.ndarray:
        return beta - np.abs(np.concatenate([population.cell(f"part {part}") for part in range(parts)])).max(axis=0)

    return margin, 1.0 - (1.0 - 2.0 * float(scipy.stats.norm.sf(beta))) ** parts


def walk(limit: float) -> tuple[Margin, float]:
    """Steps until one is above zero, so that how many normals a trial needs is random; fails when these are many."""

    def margin(population: NormalPopulation) -> np.ndarray:
        under_way, steps, number = np.ones(population.trials, dtype=bool), np.zeros(population.trials), 0
        while under_way.any() and number < 14:
            steps += under_way
            under_way &= population.cell("step", number)[0] < 0.0
            number += 1
        return limit - steps + 0.5

    return margin, 0.5 ** math.floor(limit)


def run(margin: Margin, seed: int, *, repetitions: int, chains: int) -> tuple[Pilot, Repetitions, Estimate]:
    generator = np.random.default_rng(seed)
    pilot = run_pilot(margin, generator, 2 * chains)
    found = repeat(margin, pilot.levels, generator, repetitions=repetitions, chains=chains)
    return pilot, found, Estimate.of(found.estimates)


@pytest.mark.parametrize(
    "case",
    [linear(3.1, 3), sphere(1e-3, 6), series_system(3.5, 3), walk(9.0)],
    ids=["linear", "sphere", "series", "walk"],
)
def test_two_hundred_runs_are_unbiased_and_their_intervals_hold_the_truth(case: tuple[Margin, float]) -> None:
    margin, truth = case
    runs = [run(margin, seed, repetitions=12, chains=48)[2] for seed in range(200)]
    values = np.array([each.value for each in runs]) / truth
    assert values.mean() == pytest.approx(1.0, abs=3.0 * values.std() / math.sqrt(200))
    assert values.std() < 0.25
    assert np.mean([each.low <= truth <= each.high for each in runs]) > 0.90
    assert np.mean([each.variation for each in runs]) == pytest.approx(values.std(), rel=0.25)


@pytest.mark.parametrize("case", [linear(4.753424, 40), sphere(1e-6, 10), series_system(4.9, 2)])
def test_one_in_a_million_is_known_to_a_tenth_by_two_hundred_thousand_trials(case: tuple[Margin, float]) -> None:
    margin, truth = case
    runs = [run(margin, seed, repetitions=16, chains=256) for seed in range(6)]
    assert max(pilot.trials + found.trials for pilot, found, _ in runs) < 2.1e5
    assert np.mean([estimate.variation for _, _, estimate in runs]) < 0.10
    assert [estimate.value / truth for _, _, estimate in runs] == pytest.approx([1.0] * 6, abs=0.3)


def test_the_failing_sample_is_distributed_as_the_failures_are() -> None:
    margin, _ = linear(4.0, 4)
    _, found, _ = run(margin, 3, repetitions=16, chains=256)
    along = found.failing.cell("u", 0, 4).sum(axis=0) / 2.0
    beyond = scipy.stats.norm.pdf(4.0) / scipy.stats.norm.sf(4.0)  # mean of a normal beyond 4
    assert along.min() >= 4.0
    assert np.average(along, weights=found.weights) == pytest.approx(beyond, abs=0.02)
    across = found.failing.cell("u", 0, 4)[0] - found.failing.cell("u", 0, 4)[1]
    assert np.average(across, weights=found.weights) == pytest.approx(0.0, abs=0.25)


def test_a_moved_standard_normal_stays_one() -> None:
    generator = np.random.default_rng(1)
    parent = NormalPopulation(20_000, generator)
    before = parent.cell("u", 2, 2)
    after = MovedPopulation(parent, 0.6, generator).cell("u", 2, 2)
    assert after.std() == pytest.approx(1.0, abs=0.02)
    assert np.corrcoef(before[0], after[0])[0, 1] == pytest.approx(0.8, abs=0.02)


def test_gathered_trials_keep_their_normals() -> None:
    generator = np.random.default_rng(1)
    first, second = NormalPopulation(3, generator), NormalPopulation(3, generator)
    own, other = first.cell("a"), second.cell("a")
    second.cell("b", 4, 2)
    both = gathered([first, second], np.array([5, 0]), generator)
    assert np.array_equal(both.cell("a")[0], [other[0, 2], own[0, 0]])
    assert np.array_equal(both.cell("b", 4, 2)[:, 1], first.cell("b", 4, 2)[:, 0])


def test_a_margin_that_leads_nowhere_is_said_not_to_reach_failure() -> None:
    pilot = run_pilot(lambda population: np.full(population.trials, 2.0), np.random.default_rng(1), 64)
    assert not pilot.reached
    assert pilot.trials <= 2 * 4 * 64


def test_a_failure_that_is_not_rare_needs_no_levels() -> None:
    margin, truth = linear(0.5, 2)
    pilot, found, estimate = run(margin, 1, repetitions=16, chains=64)
    assert len(pilot.levels) == 1
    assert found.trials == 4 * 16 * 64
    assert estimate.value == pytest.approx(truth, rel=0.1)


def test_the_reference_of_another_library_agrees() -> None:
    openturns = pytest.importorskip("openturns")
    margin, truth = series_system(4.0, 2)
    reference = openturns.SymbolicFunction(["a", "b"], ["4 - max(abs(a), abs(b))"])
    vector = openturns.RandomVector(openturns.Normal(2))
    event = openturns.ThresholdEvent(openturns.CompositeRandomVector(reference, vector), openturns.LessOrEqual(), 0.0)
    openturns.RandomGenerator.SetSeed(1)
    theirs = openturns.SubsetSampling(event)
    theirs.setMaximumOuterSampling(8000)
    theirs.setBlockSize(1)
    theirs.run()
    _, _, ours = run(margin, 2, repetitions=16, chains=256)
    assert ours.value == pytest.approx(theirs.getResult().getProbabilityEstimate(), rel=0.35)
    assert ours.value == pytest.approx(truth, rel=0.25)
