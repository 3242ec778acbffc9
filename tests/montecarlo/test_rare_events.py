"""Subset simulation on limit states whose probability of failure is known."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import scipy
from scipy.stats import norm

from missionplan.montecarlo.rare_events import (
    STEPS,
    Drive,
    Levels,
    MovedPopulation,
    NormalPopulation,
    Run,
    _next_threshold,
    gathered,
    run_levels,
    run_pilots,
)
from missionplan.montecarlo.rare_events.strata import FIRST_WEIGHT, Estimate, TwoStages, runs_needed

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


def driven(margin: Margin) -> Drive:
    """Drive every group towards one failure, which counts one."""

    def drive(population: NormalPopulation, groups: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values = margin(population)
        return values, np.ones_like(values)

    return drive


def run(margin: Margin, seed: int, *, groups: int, chains: int) -> tuple[tuple[Levels, ...], Run, Estimate]:
    generator = np.random.default_rng(seed)
    pilots = run_pilots(driven(margin), groups, generator, chains=chains)
    found = run_levels(driven(margin), pilots, generator, chains=chains)
    return pilots, found, Estimate.of([TwoStages(found.probabilities, np.empty(0))])


def trials(pilots: tuple[Levels, ...], found: Run, chains: int) -> int:
    return sum(pilot.count for pilot in pilots) * STEPS * chains + found.trials


@pytest.mark.parametrize(
    ("case", "count"),
    [
        (linear(3.1, 3), 50),
        *(
            pytest.param(each, 50, marks=pytest.mark.slow)
            for each in (sphere(1e-3, 6), series_system(3.5, 3), walk(9.0))
        ),
        (walk(9.0), 10),
    ],
    ids=["linear", "sphere", "series", "walk", "few walks"],
)
def test_runs_are_unbiased_and_their_intervals_hold_the_truth(case: tuple[Margin, float], count: int) -> None:
    margin, truth = case
    runs = [run(margin, seed, groups=12, chains=48)[2] for seed in range(count)]
    values = np.array([each.value for each in runs]) / truth
    assert values.mean() == pytest.approx(1.0, abs=3.0 * values.std() / math.sqrt(count))
    assert values.std() < 0.25
    missed = sum(not each.low <= truth <= each.high for each in runs)
    assert missed <= scipy.stats.binom.ppf(0.9, count, 0.05)
    within = 2.5 / math.sqrt(2.0 * count)  # of the scatter of so many
    assert np.mean([each.variation for each in runs]) == pytest.approx(values.std(), rel=within)


@pytest.mark.parametrize("case", [linear(4.753424, 40), sphere(1e-6, 10), series_system(4.9, 2)])
def test_one_in_a_million_is_known_to_a_tenth_by_two_hundred_thousand_trials(case: tuple[Margin, float]) -> None:
    margin, truth = case
    runs = [run(margin, seed, groups=10, chains=256) for seed in range(2)]
    assert max(trials(pilots, found, 256) for pilots, found, _ in runs) < 2.3e5
    assert np.mean([estimate.variation for _, _, estimate in runs]) < 0.12
    assert [estimate.value / truth for _, _, estimate in runs] == pytest.approx([1.0] * 2, abs=0.36)


def test_the_failing_sample_is_distributed_as_the_failures_are() -> None:
    margin, _ = linear(4.0, 4)
    _, found, _ = run(margin, 3, groups=16, chains=256)
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


@pytest.mark.parametrize(
    ("margins", "last", "threshold"),
    [
        ([8.0, 1.0, 7.0, 2.0, 6.0, 3.0, 5.0, 4.0], 9.0, 2.0),  # a quarter of the eight do not exceed it
        ([8.0, -1.0, 7.0, -2.0, 6.0, 3.0, 5.0, 4.0], 9.0, 0.0),
        ([2.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0], 2.0, 1.0),  # less than the last
        ([2.0, -1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0], 2.0, 0.0),
        ([2.0] * 8, 2.0, -1.0),
    ],
)
def test_a_threshold_is_the_margin_that_a_quarter_does_not_exceed_and_less_than_the_last(
    margins: list[float], last: float, threshold: float
) -> None:
    assert _next_threshold(np.array(margins), last) == threshold


def test_gathered_trials_keep_their_normals() -> None:
    generator = np.random.default_rng(1)
    first, second = NormalPopulation(3, generator), NormalPopulation(3, generator)
    own, other = first.cell("a"), second.cell("a")
    second.cell("b", 4, 2)
    both = gathered([first, second], np.array([5, 0]), generator)
    assert np.array_equal(both.cell("a")[0], [other[0, 2], own[0, 0]])
    assert np.array_equal(both.cell("b", 4, 2)[:, 1], first.cell("b", 4, 2)[:, 0])


def test_a_margin_that_leads_nowhere_is_said_not_to_reach_failure() -> None:
    drive = driven(lambda population: np.full(population.trials, 2.0))
    (pilot,) = run_pilots(drive, 1, np.random.default_rng(1), chains=64)
    assert not pilot.reached
    assert pilot.count <= 2


def test_a_failure_that_is_not_rare_needs_no_levels() -> None:
    margin, truth = linear(0.5, 2)
    pilots, found, estimate = run(margin, 1, groups=16, chains=64)
    assert {pilot.count for pilot in pilots} == {1}
    assert found.trials == 4 * 16 * 64
    assert estimate.value == pytest.approx(truth, rel=0.1)


def test_groups_side_by_side_do_not_enter_each_other() -> None:
    """One group walks to a failure in a million, its neighbours to one in three and to none."""

    def drive(population: NormalPopulation, groups: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values = np.split(population.cell("u")[0], groups.size)
        margins = {0: lambda u: norm.isf(1e-6) - u, 1: lambda u: norm.isf(1.0 / 3.0) - u, 2: lambda u: 1.0 + 0.0 * u}
        found = np.concatenate([margins[group % 3](u) for group, u in zip(groups, values, strict=True)])
        return found, np.ones_like(found)

    generator = np.random.default_rng(5)
    pilots = run_pilots(drive, 24, generator, chains=128)
    assert [pilot.reached for pilot in pilots] == [True, True, False] * 8
    found = run_levels(drive, pilots, generator, chains=256)
    assert found.probabilities[0::3].mean() == pytest.approx(1e-6, rel=0.35)
    assert found.probabilities[1::3].mean() == pytest.approx(1.0 / 3.0, rel=0.1)
    assert not found.probabilities[2::3].any()
    failing = np.split(found.failing.cell("u")[0], 24)
    assert min(failing[0]) >= norm.isf(1e-6)
    assert min(failing[1]) >= norm.isf(1.0 / 3.0)
    weights = found.weights.reshape(24, -1).sum(axis=1)
    assert weights == pytest.approx(found.counted, rel=1e-9)


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
    _, _, ours = run(margin, 2, groups=16, chains=256)
    assert ours.value == pytest.approx(theirs.getResult().getProbabilityEstimate(), rel=0.35)
    assert ours.value == pytest.approx(truth, rel=0.25)


def test_a_stage_that_ends_when_it_scatters_little_does_not_bias_the_sum() -> None:
    """Skewed runs: a mean over all of them, stopped by their own scatter, is low; fixed weights of two stages are not."""
    generator, weighted, pooled = np.random.default_rng(11), [], []
    for _ in range(4000):
        first = generator.lognormal(-0.5, 1.0, 4)
        (count,), _ = runs_needed([first], [1], variation=0.2, most_cost=200, least=2)
        second = generator.lognormal(-0.5, 1.0, count)
        weighted.append(TwoStages(first, second).value)
        pooled.append(np.mean([*first, *second]))
    error = np.std(weighted) / math.sqrt(4000)
    assert np.mean(weighted) == pytest.approx(1.0, abs=3.0 * error)
    assert np.mean(pooled) < 1.0 - 3.0 * error


def test_runs_go_where_scatter_is_and_cost_is_not() -> None:
    first = [np.array([1.0, 1.2, 0.8, 1.0]), np.array([4.0, 8.0, 2.0, 6.0]), np.array([4.0, 8.0, 2.0, 6.0])]
    runs, cut = runs_needed(first, [1, 1, 4], variation=0.05, most_cost=1e6, least=2)
    assert not cut
    assert runs[1] == pytest.approx(2.0 * runs[2], abs=2.0)  # the root of what a run costs
    assert runs[0] < 0.2 * runs[1]
    spread = [np.std(each, ddof=1) for each in first]
    variance = sum(
        sd**2 * (FIRST_WEIGHT**2 / 4 + (1.0 - FIRST_WEIGHT) ** 2 / n) for sd, n in zip(spread, runs, strict=True)
    )
    assert math.sqrt(variance) / sum(each.mean() for each in first) <= max(0.05, FIRST_WEIGHT * 0.2)
    assert runs_needed(first, [1, 1, 4], variation=0.05, most_cost=20.0, least=2)[1]
