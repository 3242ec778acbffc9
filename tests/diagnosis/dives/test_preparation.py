"""Dive logs made ready: trimmed, averaged, and doubted where they look like feet."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from missionplan.datasets.dives import read_descent
from missionplan.datasets.records import TOUCHDOWN_MARGIN
from missionplan.diagnosis.dives.preparation import (
    MAX_SAMPLES,
    _doubts_of_metres,
    binned,
    estimate_noise,
    levels_off_at,
    prepare_dives,
    slows_at,
)
from missionplan.errors import InputError

RUNS = {f"dive-{k}": {"anchor_wet_weight": f"{8 + 4 * k} N", "line_length": "5 m", "depth": "24 m"} for k in (1, 2, 3)}
KIND = {"kind": "descent", "name": "dives", "noise": {"depth": "0.05 m"}, "runs": RUNS}


def dives(rate=10.0, speed=1.3, bottom=True):
    tables = []
    for k in (1, 2, 3):
        t = np.arange(0.0, 20.0, 1.0 / rate)
        depth = np.minimum(speed * np.maximum(t - 2.0, 0.0), 19.0 if bottom else np.inf)
        tables.append(pd.DataFrame({"run": f"dive-{k}", "t_s": t, "depth_m": depth}))
    return pd.concat(tables)


def test_bottom_contact_is_cut_with_a_margin(folder, descent_mission):
    data = prepare_dives(read_descent(folder(KIND, dives()), descent_mission))
    for dive in data.dives:
        assert dive.depth.max() <= 0.88 * 19.0


def test_at_most_seventy_samples_are_kept_and_the_model_is_averaged_alike():
    t = np.linspace(0.0, 10.0, 1001)
    log = binned("dive", t, t**2, 0.05, 10.0, 5.0, 24.0)
    assert len(log.t) == MAX_SAMPLES
    assert log.bins.max() == MAX_SAMPLES - 1
    np.testing.assert_allclose(np.bincount(log.bins, log.shares * log.fine**2), log.depth, atol=1e-3)


@pytest.mark.parametrize("quantum", [0.0, 0.01])
@pytest.mark.parametrize("uneven", [0.0, 0.35])
@pytest.mark.parametrize("noise", [0.015, 0.05])
def test_noise_of_readings_on_the_way_down(quantum, uneven, noise):
    """Readings 0.2 s apart, early or late by up to a third of it, on a steady descent of 1.3 m/s."""
    rng = np.random.default_rng(1)
    t = 0.2 * (np.arange(400.0) + rng.uniform(-uneven, uneven, 400))
    depth = 1.3 * t + rng.normal(0.0, noise, 400)
    depth = np.round(depth / quantum) * quantum if quantum else depth
    assert estimate_noise(t, depth) == pytest.approx(np.hypot(noise, quantum / np.sqrt(12.0)), rel=0.2)


def test_too_few_dives_says_how_many_are_needed_for_what(folder, descent_mission):
    table = dives()
    with pytest.raises(InputError, match="2 dives are needed to hold one out"):
        prepare_dives(read_descent(folder(KIND, table[table["run"] == "dive-1"]), descent_mission))


def test_dives_that_cannot_be_used_are_refused_with_the_reason(folder, descent_mission):
    """Readings of a sensor that stands still but for its noise."""
    table = dives()
    table["depth_m"] = 7.0 + 0.03 * np.random.default_rng(1).normal(size=len(table))
    with pytest.raises(InputError, match=r"has 0 usable dives, .*; dive-1 is left out: \d samples between"):
        prepare_dives(read_descent(folder(KIND, table), descent_mission))


@pytest.mark.parametrize("factor", [1.0, 1.0 / 0.3048])
def test_feet_are_suspected_aloud_and_never_converted(folder, descent_mission, factor):
    table = dives()
    table["depth_m"] *= factor
    data = prepare_dives(read_descent(folder(KIND, table), descent_mission))
    assert any("are they in feet" in notice for notice in data.notices) == (factor > 1.0)
    assert data.dives[0].depth[-1] == pytest.approx(0.88 * 19.0, abs=1.0)


def test_many_rows_are_thinned(folder, descent_mission):
    data = prepare_dives(read_descent(folder(KIND, dives(rate=500.0)), descent_mission))
    assert all(len(dive.t) <= MAX_SAMPLES for dive in data.dives)


def test_a_sensor_that_reads_too_little_has_its_touchdown_where_it_levels_off(folder, descent_mission):
    """At 19 m; read a quarter too little the mooring is shallower than where readings are cut otherwise."""
    table = dives()
    table["depth_m"] *= 0.75
    data = prepare_dives(read_descent(folder(KIND, table), descent_mission))
    assert all(0.8 * 0.75 * 19.0 < dive.depth.max() <= 0.88 * 0.75 * 19.0 for dive in data.dives)
    assert "dive-1 levels off at 14.25 m, not at 19 m: taken for its touchdown" in data.notices


@pytest.mark.parametrize("end", [12.0, 16.0])
def test_a_log_that_ends_in_the_descent_does_not_level_off(end):
    t = np.arange(0.0, end, 0.1)
    noise = np.random.default_rng(2).normal(0.0, 0.05, t.size)
    slowing = 1.3 * np.maximum(t - 2.0, 0.0) * (1.0 - 0.02 * t)  # down to half the speed
    assert levels_off_at(t, 1.3 * np.maximum(t - 2.0, 0.0) + noise) == np.inf
    assert levels_off_at(t, slowing + noise) == np.inf
    assert levels_off_at(t, np.minimum(1.3 * np.maximum(t - 2.0, 0.0), 8.0) + noise) == pytest.approx(8.0, abs=0.2)


@pytest.mark.parametrize("lasts", [2.0, 5.0])
def test_a_log_that_ends_soon_after_touchdown_slows_there(lasts):
    """The vehicle coasts: its speed of 1.3 m/s falls as 1/(1 + v t/1.7 m), as quadratic drag has it."""
    t = np.arange(0.0, 14.0 + lasts, 0.2)
    coasting = 15.6 + 1.7 * np.log1p(1.3 * np.maximum(t - 14.0, 0.0) / 1.7) - 0.05 * np.maximum(t - 14.0, 0.0) ** 2
    depth = np.where(t < 14.0, 1.3 * np.maximum(t - 2.0, 0.0), coasting)
    noise = np.random.default_rng(3).normal(0.0, 0.03, t.size)
    cut = (1.0 - TOUCHDOWN_MARGIN) * slows_at(t, depth + noise)
    assert 0.85 * 15.6 < cut < 15.6


@pytest.mark.parametrize("seed", range(5))
def test_a_log_that_ends_in_the_descent_does_not_slow_abruptly(seed):
    t = np.arange(0.0, 16.0, 0.2)
    noise = np.random.default_rng(seed).normal(0.0, 0.05, t.size)
    for depth in (1.3 * np.maximum(t - 2.0, 0.0), 1.3 * np.maximum(t - 2.0, 0.0) * (1.0 - 0.02 * t)):
        assert slows_at(t, depth + noise) == np.inf
    assert slows_at(t[:4], t[:4]) == np.inf


def test_readings_noisier_than_stated_have_their_own_noise(folder, descent_mission):
    table = dives(rate=5.0)
    table["depth_m"] += np.random.default_rng(4).normal(0.0, 0.2, len(table))
    data = prepare_dives(read_descent(folder(KIND, table), descent_mission))
    assert [dive.sd[0] for dive in data.dives] == pytest.approx([0.2] * 3, rel=0.3)
    quiet = prepare_dives(read_descent(folder(KIND, dives(rate=5.0)), descent_mission))
    assert [dive.sd[0] for dive in quiet.dives] == pytest.approx([0.05] * 3)  # as stated


@pytest.mark.parametrize(("until", "seen"), [(9.5, True), (8.0, False)])
def test_a_gap_of_more_than_a_fifth_of_a_dive_is_told(folder, descent_mission, until, seen):
    table = dives()
    table = table[(table["t_s"] <= 6.0) | (table["t_s"] >= until)]
    data = prepare_dives(read_descent(folder(KIND, table), descent_mission))
    told = [words for words in data.notices if "a gap of" in words]
    assert told == ([f"dive-{number}: a gap of 3.5 s in the log" for number in (1, 2, 3)] if seen else [])


def test_feet_are_suspected_from_one_and_a_half_times_the_depth_or_three_metres_a_second():
    late = SimpleNamespace(t=np.arange(10.0), depth=np.concatenate([0.5 * np.arange(5.0), 4.0 + 3.1 * np.arange(5.0)]))
    slow = SimpleNamespace(t=np.arange(10.0), depth=2.9 * np.arange(10.0))
    deep, enough = (
        SimpleNamespace(depth=np.array([1.0, most]), site_depth=24.0, line_length=9.0) for most in (36.5, 35.5)
    )
    assert _doubts_of_metres([enough], [slow]) == []
    assert "depths grow by 3.1 a second" in _doubts_of_metres([enough], [late])[0]  # of its second half
    assert "depths reach 1.5 times the depth of the site" in _doubts_of_metres([deep], [slow])[0]
