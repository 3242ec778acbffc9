"""Levels that drift and jump: closed forms, what cannot matter, and vehicles drawn by code that shares nothing."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from missionplan.montecarlo.levels import Ageing, Measured, in_missions, levels

STILL = Ageing(trend=0.0, walk=0.0, redrawn=0.0, jump=0.0, is_trend=0.0, is_jump=0.0)
USUAL = Ageing(trend=1.2, walk=0.8, redrawn=0.2, jump=8.0, is_trend=0.4, is_jump=0.04)
DAY = 86400.0


def measured(values, sds, times=None, first=(0.0, 8.0)):
    values = np.array(values, dtype=float)
    times = np.arange(len(values), dtype=float) if times is None else np.array(times)
    return Measured(times, values, np.broadcast_to(np.array(sds, dtype=float), values.shape), *first)


def test_a_level_that_cannot_change_is_the_mean_weighted_by_precision():
    values, sds = np.array([1.0, 2.0, 4.0]), np.array([0.5, 1.0, 2.0])
    found = levels(measured(values, sds), STILL)
    precision = np.sum(sds**-2.0) + 8.0**-2
    mean, sd = found.at(np.array([0.0, 2.0, 7.0]))
    assert mean == pytest.approx(np.full(3, np.sum(values / sds**2) / precision))
    assert sd == pytest.approx(np.full(3, precision**-0.5))


def test_a_trend_alone_is_the_line_by_least_squares():
    """With priors that are wide, slope and its error are those of the weighted regression."""
    times, sds = np.array([0.0, 1.0, 2.5, 4.0]), np.array([0.3, 0.2, 0.4, 0.3])
    values = 1.0 + 2.0 * times + np.array([0.1, -0.2, 0.3, 0.0])
    own = replace(STILL, trend=100.0, is_trend=1.0)
    slope, sd, _ = levels(measured(values, sds, times, (0.0, 100.0)), own).trend
    design = np.stack([np.ones(4), times]) / sds
    covariance = np.linalg.inv(design @ design.T)
    assert slope == pytest.approx((covariance @ design @ (values / sds))[1], rel=1e-3)
    assert sd == pytest.approx(covariance[1, 1] ** 0.5, rel=1e-3)


def test_the_density_of_two_measurements_is_that_of_the_laws_by_hand():
    """Normal laws of the difference, weighed by the probability of a jump, all else known."""
    own = replace(STILL, jump=5.0, is_jump=0.1)
    found = levels(measured([1.0], 0.5, first=(1.0, 1e-6)), own)
    still = stats.norm.logpdf(1.7, 1.0, 0.5)
    assert found.log_density(1.0, 1.7, 0.5) == pytest.approx(still, abs=1e-6)
    two = levels(measured([1.0, 2.6], 0.5, first=(1.0, 1e-6)), own)
    odds = 0.1 * stats.norm.pdf(1.6, 0.0, np.hypot(5.0, 0.5)), 0.9 * stats.norm.pdf(1.6, 0.0, 0.5)
    assert two.jumps == pytest.approx([0.0, odds[0] / sum(odds)], abs=1e-6)


def test_units_zero_and_sign_cannot_matter():
    values, sds = np.array([1.0, 3.0, 4.5, 12.0, 13.0]), np.array([0.4, 0.5, 0.4, 0.6, 0.5])
    found = levels(measured(values, sds), USUAL)
    scaled = Ageing(*(-10.0 * size for size in (1.2, 0.8, 0.2, 8.0)), 0.4, 0.04)
    other = levels(measured(7.0 - 10.0 * values, 10.0 * sds, first=(7.0, 80.0)), scaled)
    at = np.array([0.0, 2.0, 4.0, 5.0])
    assert other.at(at)[0] == pytest.approx(7.0 - 10.0 * found.at(at)[0])
    assert other.at(at)[1] == pytest.approx(10.0 * found.at(at)[1])
    assert other.jumps == pytest.approx(found.jumps)
    assert other.trend[0] == pytest.approx(-10.0 * found.trend[0])


def test_the_further_ahead_the_less_is_known():
    found = levels(measured([1.0, 1.1, 0.9, 1.0], 0.4), USUAL)
    _, sd = found.at(np.array([3.0, 4.0, 6.0, 12.0]))
    assert np.all(np.diff(sd) > 0.0)


def test_dates_are_counted_in_missions():
    times, then = in_missions([0.0, 30 * DAY, 90 * DAY], 120 * DAY)
    assert times == pytest.approx([0.0, 0.75, 2.25])
    assert then == pytest.approx(3.0)
    assert in_missions([0.0, np.nan, 5.0])[0] == pytest.approx([0.0, 1.0, 2.0])
    times, then = in_missions([0.0, 3600.0, 10 * DAY], 10.5 * DAY)  # two records of the first day, and the last one's
    assert times == pytest.approx([0.0, 0.0, 1.0])
    assert then == pytest.approx(1.0)


def test_records_of_one_mission_tell_together_what_one_of_all_does():
    own, other = measured([1.0, 1.6, 9.0], [0.4, 0.8, 0.5], [0.0, 1.0, 2.0]), [0.0, 1.0, 1.0, 2.0]
    parted = measured([1.0, 1.6 + 0.4, 1.6 - 0.4, 9.0], [0.4, 0.8 * 2**0.5, 0.8 * 2**0.5, 0.5], other)
    one, two = levels(own, USUAL), levels(parted, USUAL)
    at = np.array([0.0, 1.0, 2.0, 3.0])
    assert two.at(at)[0] == pytest.approx(one.at(at)[0], rel=1e-6)
    assert two.at(at)[1] == pytest.approx(one.at(at)[1], rel=1e-6)
    assert two.jumps[[0, 1, 3]] == pytest.approx(one.jumps, rel=1e-6)


MISSIONS = 6
KINDS = {  # standard deviations of usual sizes, of the errors, of what is drawn anew; trend and jump
    "compass": (4.6, 0.28, 0.15, 2.0, 0.6, 6.0, Ageing(0.69, 0.46, 0.15, 4.6, 0.15, 0.07)),
    "log": (8.0, 0.4, 0.2, 2.0, 2.0, 8.0, Ageing(1.2, 0.8, 0.2, 8.0, 0.4, 0.04)),
    "drag": (30.0, 1.5, 1.0, 6.0, 6.0, 25.0, Ageing(4.5, 3.0, 1.0, 30.0, 0.4, 0.04)),
}


def sailed(kind, way, rng):
    """Levels of a vehicle in its missions, what was measured of them and with which error, and where it jumped."""
    size, error, own, redrawn, trend, jump, _ = KINDS[kind]
    level, at = rng.normal(0.0, 0.6 * size), int(rng.integers(2, 5)) if way == "jumping" else None
    step = trend * rng.choice([-1.0, 1.0]) if way == "drifting" else 0.0
    truth = []
    for mission in range(MISSIONS):
        if mission:
            level += step
        if mission == at:
            level += jump * rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.0)
        anew = rng.normal(0.0, redrawn) if way == "redrawn" else 0.0
        truth.append(level + anew + rng.normal(0.0, 0.7 * own))
    sds = error * rng.uniform(0.8, 1.3, MISSIONS)
    values = np.array(truth) + sds * rng.standard_normal(MISSIONS)
    return np.array(truth), values, np.hypot(sds, own), at


def first_seen(values, sds):
    """First mission at which the slope by least squares is three of its standard deviations."""
    for n in range(3, len(values) + 1):
        times, weights = np.arange(n), sds[:n] ** -2.0
        apart = times - np.average(times, weights=weights)
        information = np.sum(weights * apart**2)
        if abs(np.sum(weights * apart * values[:n]) / information) > 3.0 * information**-0.5:
            return n
    return None


def fleet(kind, way, seed, count=25):
    """Intervals that hold, gains in log score over starting afresh, and what was named when, of some vehicles."""
    rng, size, ageing = np.random.default_rng([seed, 43]), KINDS[kind][0], KINDS[kind][-1]
    held, gains, trends, jumps = [], [], [], []
    for _ in range(count):
        truth, values, sds, at = sailed(kind, way, rng)
        after = [levels(measured(values[:n], sds[:n], first=(0.0, size)), ageing) for n in range(1, MISSIONS + 1)]
        for n, known in enumerate(after):
            mean, sd = known.at(np.array([float(n)]))
            held.append(abs(truth[n] - mean[0]) < 1.645 * sd[0])
            if n + 1 < MISSIONS and n + 1 != at:
                afresh = stats.norm.logpdf(values[n + 1], 0.0, np.hypot(size, sds[n + 1]))
                gains.append(known.log_density(n + 1.0, values[n + 1], sds[n + 1]) - afresh)
        told = [n for n, known in enumerate(after, 1) if n > 2 and named(known.trend)]
        seen = first_seen(values, sds)
        if way == "drifting" and seen is not None and seen + 3 <= MISSIONS:
            trends.append(bool(told) and told[0] <= seen + 3)
        if way != "drifting":
            trends.append(bool(told))
        if at is not None:
            jumps.append(max(known.jumps[at] for known in after[at : at + 2]) > 0.5)
    return np.mean(held), np.mean(gains), np.mean(trends) if trends else np.nan, np.mean(jumps) if jumps else np.nan


def named(trend):
    value, sd, probability = trend
    return probability >= 0.8 and abs(value) >= 3.0 * sd


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("way", ["constant", "drifting", "jumping", "redrawn"])
def test_levels_of_vehicles_of_every_kind(kind, way):
    """Seed 7; the priors were chosen on seed 1 of other draws."""
    held, gain, trends, jumps = fleet(kind, way, 7)
    assert 0.83 <= held <= 0.99
    assert gain > (-0.3 if way == "redrawn" else 1.0)
    assert trends >= 0.9 if way == "drifting" else trends <= 0.15
    assert not jumps < 0.8


if __name__ == "__main__":
    for every in KINDS:
        for each in ("constant", "drifting", "jumping", "redrawn"):
            print(every, each, *(f"{number:.2f}" for number in fleet(every, each, 1043, 40)))
