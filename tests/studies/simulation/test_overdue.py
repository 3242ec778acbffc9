"""The sheet for the boat, against trials that it was not made from."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.path import Path as Polygon
from numpy.typing import NDArray

import missionplan
from missionplan.mission import Mission
from missionplan.phases.currents import layers
from missionplan.rendering import render
from missionplan.report.page import Figure, draw, drawing_by, style
from missionplan.report.simulation.overdue import overdue_section
from missionplan.results.simulation import Outcome
from missionplan.results.whereabouts import SearchArea
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.drift import Drift
from missionplan.studies.simulation.simulate import simulate
from missionplan.studies.simulation.trial_block import MissionTrials, run_block

DRIFTING = """
name: Ten legs in a current
start: 2026-06-01T08:00:00
site:
  origin: {latitude: 37.25 deg, longitude: -76.38 deg}
  depth: 30 m
  current: [{down_to: 30 m, speed: {mean: 0.3 m/s, sd: 0.1 m/s}, toward: 60 deg}]
navigation:
  velocity_error: {sigma: 0.08 m/s}
  surfacing_time: 60 s
  max_legs: 10
phases:
  - transit: {from: [0 m, 0 m], to: [800 m, 0 m], depth: 2 m, speed: 1.5 m/s, d_max: 300 m, arrival_radius: 15 m}
monte_carlo: {trials: 4096, seed: 1}
"""
STARTER = Path(missionplan.__file__).parent / "starter" / "mission.yaml"


def inside(area: SearchArea, places: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.any([within(rings, places) for rings in area.polygons], axis=0)


def within(rings: tuple[NDArray[np.float64], ...], places: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.logical_xor.reduce([Polygon(ring.T).contains_points(places.T) for ring in rings])


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Mission:
    path = tmp_path_factory.mktemp("overdue") / "drifting.yaml"
    path.write_text(DRIFTING, encoding="utf-8")
    return missionplan.load(path)


@pytest.fixture(scope="module")
def outcome(mission: Mission) -> Outcome:
    return simulate(mission)


@pytest.fixture(scope="module")
def others(mission: Mission) -> MissionTrials:
    """Trials of another seed, tracks and all."""
    scenario = Scenario.at_means(mission).sampled(seed=2, block=0)
    return run_block(scenario, 2, 0, 4096, tracked=4096)


def test_other_missions_are_back_by_the_times_of_the_sheet(outcome: Outcome, others: MissionTrials) -> None:
    assert outcome.overdue is not None
    duration = others.total["duration_s"][others.success]
    back = outcome.overdue.times[-1]
    assert np.isnan(back.p999)  # of some thousand that come back
    for share, time in ((0.5, back.p50), (0.95, back.p95), (0.99, back.p99)):
        assert np.mean(duration <= time) == pytest.approx(
            share, abs=5.0 * np.sqrt(share * (1.0 - share) / duration.size)
        )
    first = outcome.overdue.times[0]
    assert first.name == "transit, surfacing 1"
    assert first.p50 == pytest.approx(300.0 / 1.5)


def test_the_drift_ellipses_hold_other_trials_that_failed(outcome: Outcome, others: MissionTrials) -> None:
    assert outcome.overdue is not None
    adrift = [area for area in outcome.overdue.areas if area.way == "adrift at the surface"]
    failed = ~others.success
    assert np.count_nonzero(failed) > 200
    track, time = others.phases[0].track[-1], others.phases[0].track_time[-1]  # the last fix of those that never arrive
    east, north = np.sin(np.radians(60.0)), np.cos(np.radians(60.0))
    for area in adrift:
        assert not area.is_assumed
        elapsed = outcome.overdue.worry_after + area.overdue - time[failed]
        gone = others.draws["site.current[0].speed"][failed] * np.maximum(elapsed, 0.0)
        places = track[:, failed] + np.stack((east * gone, north * gone))
        assert np.mean(inside(area, places)) == pytest.approx(area.share, abs=0.04)
    assert [area.overdue / 3600.0 for area in adrift[::3]] == [0.0, 1.0, 3.0, 6.0]  # the layers are not held for longer


def test_the_share_that_never_ends_is_that_of_the_trials(outcome: Outcome) -> None:
    assert outcome.overdue is not None
    assert sum(outcome.overdue.missing.values()) == pytest.approx(1.0 - outcome.total.events["success"].value)


def test_the_circle_of_a_vehicle_not_released_holds_the_anchors_of_a_mooring() -> None:
    mission = missionplan.load(STARTER)
    found = simulate(mission, trials=512)
    assert found.overdue is not None
    areas = {area.way: area for area in found.overdue.areas}
    anchors = run_block(Scenario.at_means(mission).sampled(seed=9, block=0, size=512), 9, 0, 512).phases[1].anchor
    anchors = anchors[:, np.isfinite(anchors[0])]
    held = areas["not released"]
    inside = np.hypot(anchors[0] - held.centre_east, anchors[1] - held.centre_north) <= held.half_length
    assert np.mean(inside) >= 0.92
    assert set(areas) == {"not released", "adrift at the surface", "on the seafloor", "still under way"}
    names = [time.name for time in found.overdue.times]
    assert names[-1] == "back"
    assert "moor, up from the seafloor" in names
    times = [time.p50 for time in found.overdue.times if time.share > 0.95]
    assert times == sorted(times)
    left = [time.energy_left for time in found.overdue.times if time.share > 0.95]
    assert left == sorted(left, reverse=True)


def test_a_vehicle_adrift_goes_with_the_surface_layer() -> None:
    current = layers([10.0, 30.0], [np.array([0.5, 0.2]), 9.0], [np.pi / 2.0, 0.0])
    begin, clock = np.array([[0.0, 5.0], [0.0, 7.0]]), np.array([1000.0, 100.0])
    before, then = Drift(current, ()).places(begin, clock, (50.0, 1100.0))
    assert before == pytest.approx(begin)
    assert then == pytest.approx(np.array([[50.0, 205.0], [0.0, 7.0]]))


def test_the_sheet_is_in_the_report_as_words_table_map_and_geojson(outcome: Outcome) -> None:
    rendered = render(outcome)
    assert 'class="sheet"' in rendered.html
    assert "If it does not come back: worry after" in rendered.html
    assert "search-areas" in rendered.figures
    collection = json.loads(rendered.files["search-areas.geojson"])
    ring = collection["features"][0]["geometry"]["coordinates"][0][0]
    assert ring[0] == pytest.approx(ring[-1])
    assert -76.5 < ring[0][0] < -75.5
    assert "search-areas.csv" in outcome.files()


def test_the_sheet_and_its_files_call_a_phase_what_the_mission_does() -> None:
    """A name that is not made of words is a place in key paths, ``phases[1]``, which tells the boat nothing."""
    named = missionplan.load(STARTER)
    raw = [{kind: {**phase} for kind, phase in each.items()} for each in named.raw["phases"]]
    raw[1]["moor"]["name"] = "A, deep"
    outcome = simulate(named.with_({"phases": raw, "requirements": []}), trials=256)
    assert outcome.overdue is not None
    assert "A, deep, up from the seafloor" in [time.name for time in outcome.overdue.times]
    assert {area.after for area in outcome.overdue.areas} == {"A, deep", ""}
    files = render(outcome).files
    said = [files[name] for name in ("search-areas.geojson", "track.geojson", "track.kml", "plan.json")]
    assert not any("phases[" in str(each) for each in said)
    assert "A, deep.release_time" in str(said[-1])


def test_the_hours_on_the_map_do_not_lie_on_each_other(outcome: Outcome) -> None:
    found = outcome.overdue
    assert found is not None
    adrift = [area for area in found.areas if area.overdue == 3600.0]
    at_once = [replace(area, overdue=3600.0 * hours) for hours in (1, 3, 6) for area in adrift]
    with style(), drawing_by(draw):
        (block,) = overdue_section(replace(outcome, overdue=replace(found, areas=tuple(at_once))))
    (map_of_them,) = [each for each in block.blocks if isinstance(each, Figure)]
    tops = sorted(map(float, re.findall(r' y="([\d.]+)"[^>]*>\+\d+\u00a0h', map_of_them.svg)))
    assert len(tops) == 3
    assert np.diff(tops).min() > 10.9


def test_a_mission_that_never_comes_back_has_no_sheet(mission: Mission) -> None:
    short = simulate(mission, trials=40)
    assert short.overdue is None
    assert "If it does not come back" not in render(replace(short)).html


def test_the_sheet_tells_no_share_that_its_trials_cannot() -> None:
    found = simulate(missionplan.load(STARTER), trials=400).overdue
    assert found is not None
    back = found.times[-1]
    assert 230 <= 400 * back.share < 2302
    assert np.isnan(back.p999)
    assert found.worry_share == 0.99
    assert found.worry_after == back.p99
    assert found.summary()["worry_share"] == 0.99
