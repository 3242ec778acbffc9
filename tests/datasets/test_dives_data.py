"""Dive logs: trimmed, thinned, doubted, and every problem of a file at once."""

import numpy as np
import pandas as pd
import pytest

from missionplan.datasets.dives import MOST_SAMPLES, binned, estimate_noise, read_descent
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


def test_reads_dives_with_their_settings(folder, descent_mission):
    data = read_descent(folder(KIND, dives()), descent_mission)
    assert [dive.name for dive in data.dives] == list(RUNS)
    assert [dive.wet_weight for dive in data.dives] == [12.0, 16.0, 20.0]


def test_bottom_contact_is_cut_with_a_margin(folder, descent_mission):
    data = read_descent(folder(KIND, dives()), descent_mission)
    for dive in data.dives:
        assert dive.depth.max() <= 0.88 * 19.0


def test_at_most_seventy_samples_are_kept_and_the_model_is_averaged_alike():
    t = np.linspace(0.0, 10.0, 1001)
    log = binned("dive", t, t**2, 0.05, 10.0, 5.0, 24.0)
    assert len(log.t) == MOST_SAMPLES
    assert log.bins.max() == MOST_SAMPLES - 1
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


def test_runs_not_described_times_repeated_and_too_few(folder, descent_mission):
    table = dives().reset_index(drop=True).astype(object)
    table.loc[table["run"] == "dive-3", "run"] = "dive-4"
    table.loc[5, "t_s"] = table.loc[4, "t_s"]
    table.loc[9, "depth_m"] = "deep"
    with pytest.raises(InputError) as excinfo:
        read_descent(folder(KIND, table), descent_mission)
    words = "\n".join(str(problem) for problem in excinfo.value.problems)
    assert "run 'dive-4' is not among runs" in words
    assert "rows.csv:7: t_s: dive-1: a time stands twice" in words
    assert "rows.csv:11: depth_m: given 'deep'" in words


def test_too_few_dives_says_how_many_are_needed_for_what(folder, descent_mission):
    table = dives()
    with pytest.raises(InputError, match="2 dives are needed to hold one out"):
        read_descent(folder(KIND, table[table["run"] == "dive-1"]), descent_mission)


@pytest.mark.parametrize("factor", [1.0, 1.0 / 0.3048])
def test_feet_are_suspected_aloud_and_never_converted(folder, descent_mission, factor):
    table = dives()
    table["depth_m"] *= factor
    data = read_descent(folder(KIND, table), descent_mission)
    assert any("are they in feet" in notice for notice in data.notices) == (factor > 1.0)
    assert data.dives[0].depth[-1] == pytest.approx(0.88 * 19.0, abs=1.0)


@pytest.mark.parametrize(
    ("runs", "words"),
    [
        ({"dive-1": {"anchor_weight": "9 N"}}, "unknown key"),
        ({"dive-1": {"anchor_wet_weight": 9}}, "expected a unit too"),
        ({"dive-1": {"anchor_wet_weight": "-9 N"}}, "expected more than 0"),
        ({"dive-1": {"line_length": "30 m"}}, "never pulled down"),
        (["dive-1"], "expected a mapping"),
    ],
)
def test_bad_runs(folder, descent_mission, runs, words):
    with pytest.raises(InputError, match=words):
        read_descent(folder({**KIND, "runs": runs}, dives()), descent_mission)


def test_many_rows_are_thinned(folder, descent_mission):
    data = read_descent(folder(KIND, dives(rate=5000.0)), descent_mission)
    assert all(len(dive.t) <= MOST_SAMPLES for dive in data.dives)
