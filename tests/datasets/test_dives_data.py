"""Dive logs: read with their settings, and every problem of a file at once."""

import numpy as np
import pandas as pd
import pytest

from missionplan.datasets.dives import read_descent
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


@pytest.mark.parametrize(
    ("depth", "words"),
    [
        (lambda t: 0.0 * t, "all 200 depths are 0 m: the sensor did not measure, or did not move"),
        (lambda t: 0.0 * t + 7.5, "all 200 depths are 7.5 m"),
        (lambda t: -1.99 * t / t.max(), "no depth is below the water, the lowest is -1.99 m: expected depths positive"),
        (lambda t: 18.9 + 0.1 * np.sin(t), r"the log begins when the dive is over: .* moored at 19 m \(a site of 24 m"),
    ],
)
def test_impossible_dives_are_refused_each_at_its_first_line(folder, descent_mission, depth, words):
    """The second and the third dive are impossible; the first is as it should be."""
    table = dives().reset_index(drop=True)
    wrong = table["run"] != "dive-1"
    table.loc[wrong, "depth_m"] = np.round(depth(table.loc[wrong, "t_s"].to_numpy()), 6)
    with pytest.raises(InputError, match=words) as excinfo:
        read_descent(folder(KIND, table), descent_mission)
    places = [(problem.line, str(problem)) for problem in excinfo.value.problems]
    assert [line for line, _ in places] == [202, 402]
    assert [name in text for name, (_, text) in zip(("dive-2", "dive-3"), places, strict=True)] == [True, True]


def test_times_of_the_day_count_from_the_separation(folder, descent_mission):
    plain = read_descent(folder(KIND, dives()), descent_mission)
    table = dives().reset_index(drop=True)
    moments = pd.to_datetime(table["t_s"] + 1.7e9, unit="s")
    dated = table.assign(t_s=moments.dt.strftime("%Y-%m-%dT%H:%M:%S.%f") + "Z")
    separation = {"separation": "2023-11-14T22:13:20Z"}
    runs = {name: {**keys, **separation} for name, keys in RUNS.items()}
    data = read_descent(folder({**KIND, "runs": runs}, dated), descent_mission)
    for ours, wanted in zip(data.dives, plain.dives, strict=True):
        np.testing.assert_allclose(ours.t, wanted.t, atol=1e-5)
    mixed = table["t_s"].astype(str).where(table["run"] == "dive-1", dated["t_s"])
    data = read_descent(folder({**KIND, "runs": runs}, table.assign(t_s=mixed)), descent_mission)
    for ours, wanted in zip(data.dives, plain.dives, strict=True):
        np.testing.assert_allclose(ours.t, wanted.t, atol=1e-5)  # one dive in seconds already
    del runs["dive-2"]["separation"]
    with pytest.raises(InputError, match="dive-2: its times are of the day; say in runs: when its anchor separated"):
        read_descent(folder({**KIND, "runs": runs}, dated), descent_mission)


def test_dives_are_of_the_data_sets_date_or_of_their_own(folder, descent_mission):
    """Two dives on 1 May and one on 4 May, by `start` and by its separation; without a date of one there is none."""
    assert np.isnan(read_descent(folder(KIND, dives()), descent_mission).date)
    first, last = (pd.Timestamp(f"2026-05-{day:02}T12:00:00Z") for day in (1, 4))
    wanted = (2 * first.timestamp() + last.timestamp()) / 3
    for key in ("start", "separation"):
        runs = {**RUNS, "dive-3": {**RUNS["dive-3"], key: last.isoformat()}}
        dated = {**KIND, "start": first.isoformat(), "runs": runs}
        assert read_descent(folder(dated, dives()), descent_mission).date == pytest.approx(wanted)
        del dated["start"]
        assert np.isnan(read_descent(folder(dated, dives()), descent_mission).date)


def test_a_dive_that_stands_twice_counts_once_unless_its_anchor_differed(folder, descent_mission):
    table = dives()
    table.loc[table["run"] == "dive-2", "depth_m"] += 0.5
    same = {**RUNS, "dive-3": RUNS["dive-1"]}
    data = read_descent(folder({**KIND, "runs": same}, table), descent_mission)
    assert [dive.name for dive in data.dives] == ["dive-1", "dive-2"]
    (notice,) = (each for each in data.notices if "count once" in each)
    assert notice.startswith("1 dive of 3 stand in the file before, and count once: ")
    assert "dive-3" in notice
    for dive, first in zip(data.dives, (0.0, 0.5), strict=True):
        assert (dive.t[0], dive.depth[0], len(dive.t)) == (0.0, first, 200)
    apart = read_descent(folder(KIND, table), descent_mission)
    assert [dive.name for dive in apart.dives] == list(RUNS)
    assert not any("count once" in notice for notice in apart.notices)


@pytest.mark.parametrize(
    ("change", "words", "line"),
    [
        (
            lambda t: t["t_s"].mask(t.index.isin([5, 9]), t["t_s"] - 0.1),
            "dive-1: a time stands twice; 1 more like it",
            7,
        ),
        (lambda t: t["t_s"].mask(t.index == 5, 0.05), "dive-1: a time stands after a later one", 7),
    ],
)
def test_times_that_do_not_go_on_are_named_once_a_dive(folder, descent_mission, change, words, line):
    table = dives().reset_index(drop=True)
    with pytest.raises(InputError, match=words) as refused:
        read_descent(folder(KIND, table.assign(t_s=change(table).round(6))), descent_mission)
    assert [problem.line for problem in refused.value.problems] == [line]


@pytest.mark.parametrize(("depth", "words"), [(99.0, "reaches 99 m, below the seafloor at 24 m"), (-2.1, "more than 2 m above"), (11_001.0, "deepest sea"), (97.9, ""), (-999.0, ""), (-1.9, "")])  # fmt: skip
def test_depths_that_no_dive_has_are_refused_and_those_of_waves_and_feet_are_not(folder, descent_mission, depth, words):
    table = dives().reset_index(drop=True)
    table.loc[7, "depth_m"] = depth
    place = folder(KIND, table)
    if not words:
        assert len(read_descent(place, descent_mission).dives) == 3
        return
    with pytest.raises(InputError, match=words):
        read_descent(place, descent_mission)


@pytest.mark.parametrize(("unit", "rate"), [(1e3, "0.00"), (1.0 / 60.0, "")])
def test_times_in_another_unit_than_seconds_are_told_by_the_rate_of_sinking(folder, descent_mission, unit, rate):
    table = dives().reset_index(drop=True)
    with pytest.raises(InputError, match=rf"dive-1: sinks at {rate}\S* m/s; .*are its times in seconds"):
        read_descent(folder(KIND, table.assign(t_s=unit * table["t_s"])), descent_mission)
