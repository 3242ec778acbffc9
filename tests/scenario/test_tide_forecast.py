"""A tide with phases at Greenwich: against UTide's own reconstruction, exact means, and what the mission needs."""

import math
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import utide
import yaml

import missionplan
from missionplan.errors import InputError
from missionplan.scenario.site_current import recorded_current

FIG8 = Path(__file__).parents[2] / "missions" / "fig8.yaml"
WAVES = [
    {"name": "M2", "major": "0.4 m/s", "minor": "0.1 m/s", "toward": "30 deg", "phase": "200 deg"},
    {"name": "K1", "major": "0.1 m/s", "minor": "-0.05 m/s", "toward": "100 deg", "phase": "20 deg"},
    {"name": "M4", "major": "0.05 m/s", "toward": "60 deg", "phase": "310 deg"},
]
DEPTHS = [
    {"depth": "5 m", "east": "0.03 m/s", "north": "-0.02 m/s", "constituents": WAVES},
    {"depth": "15 m", "east": "0.01 m/s", "constituents": [dict(WAVES[0], major="0.2 m/s", minor="0 m/s")]},
]
NOWHERE = np.zeros((2, 1))


def mission_with(tide, **others):
    data = yaml.safe_load(FIG8.read_text())
    site = {**data.get("site", {}), "origin": {"latitude": "37 deg", "longitude": "-76 deg"}}
    site["current"] = {"tide": tide, **others}
    return missionplan.Mission.from_data({**data, "start": "2026-06-01T11:30:00", "site": site})


def utides_own(moments):
    """The waves at 5 m as UTide reconstructs them."""
    epoch = datetime(2026, 6, 1, 11, 30, tzinfo=UTC).timestamp()
    days = (epoch + np.asarray(moments)) / 86400.0
    # a solution of UTide for two weeks about the start, with its numbers put in place of those found
    spring = days[0] + np.arange(-15.0, 15.0, 1.0 / 24.0)
    coef = utide.solve(
        spring, np.cos(spring), np.sin(spring), lat=37.0, epoch="1970-01-01", constit=["M2", "K1", "M4"],
        trend=False, conf_int="none", verbose=False, order_constit="frequency",
    )  # fmt: skip
    order = [str(name) for name in coef["name"]]
    for wave in WAVES:
        at = order.index(wave["name"])
        value = {key: float(wave.get(key, "0 deg").split()[0]) for key in ("major", "minor", "toward", "phase")}
        coef["Lsmaj"][at], coef["Lsmin"][at] = value["major"], value["minor"]
        coef["theta"][at], coef["g"][at] = 90.0 - value["toward"], value["phase"]
    coef["umean"], coef["vmean"] = 0.03, -0.02
    found = utide.reconstruct(days, coef, epoch="1970-01-01", verbose=False, constit=order)
    return np.stack((found["u"], found["v"]))


def test_it_is_utides_own_forecast():
    moments = np.array([0.0, 1800.0, 3.0 * 3600.0, 86400.0])
    current = recorded_current(mission_with({"depths": DEPTHS}))
    found = np.hstack([current.velocity(t, 5.0, NOWHERE) for t in moments])
    np.testing.assert_allclose(found, utides_own(moments), atol=5e-4)


def test_a_tide_at_one_date_is_not_that_of_another():
    early = recorded_current(mission_with({"depths": DEPTHS}))
    later = recorded_current(mission_with({"depths": DEPTHS}).with_(start="2026-06-01T14:30:00"))
    shifted = early.velocity(3.0 * 3600.0, 5.0, NOWHERE)
    np.testing.assert_allclose(later.velocity(0.0, 5.0, NOWHERE), shifted, atol=5e-4)
    assert not np.allclose(later.velocity(0.0, 5.0, NOWHERE), early.velocity(0.0, 5.0, NOWHERE), atol=0.1)


def test_depths_between_are_linear_and_the_mean_of_a_leg_is_exact():
    current = recorded_current(mission_with({"depths": DEPTHS}))
    upper, lower, between = (current.velocity(700.0, depth, NOWHERE) for depth in (5.0, 15.0, 7.5))
    np.testing.assert_allclose(between, 0.75 * upper + 0.25 * lower, atol=1e-12)
    start, duration, depth = np.array([0.0, 500.0]), np.array([9000.0, 40.0]), np.array([6.0, 12.0])
    found = current.mean_velocity(start, duration, depth, np.zeros((2, 2)), np.zeros((2, 2)))
    moments = start + duration * (np.arange(4000)[:, None] + 0.5) / 4000
    expected = np.mean([current.velocity(t, depth, np.zeros((2, 2))) for t in moments], axis=0)
    np.testing.assert_allclose(found, expected, atol=1e-8)
    np.testing.assert_allclose(current.mean_velocity(700.0, 0.0, 5.0, NOWHERE, NOWHERE), upper, atol=1e-12)


@pytest.mark.parametrize(("outside", "failed"), [("error", True), ("hold", False)])
def test_a_tide_known_above_serves_no_transit_far_below(outside, failed):
    shallow = [dict(DEPTHS[0], depth="1 m")]
    mission = mission_with({"depths": shallow}, outside=outside).with_({"ingress.depth": "30 m", "site.depth": "60 m"})
    if failed:
        with pytest.raises(InputError, match="is good down to 6 m"):
            missionplan.simulate(mission, trials=20, seed=1, sheet=False)
    else:
        assert missionplan.simulate(mission, trials=20, seed=1, sheet=False).provenance.trials == 20


@pytest.mark.parametrize(
    ("tide", "message"),
    [
        ({"depths": []}, "expected at least one depth"),
        ({"depths": [DEPTHS[1], DEPTHS[0]]}, "from the surface down"),
        ({"depths": [{"depth": "5 m", "constituents": [dict(WAVES[0], name="M22")]}]}, "did you mean M2"),
        ({"depths": [{"depth": "5 m", "constituents": [WAVES[0], WAVES[0]]}]}, "a second time"),
        ({"depths": [{"depth": "5 m", "constituents": [dict(WAVES[0], major="40 m/s")]}]}, "impossible|at most 12"),
        ({"depths": [{"depth": "5 m", "constituents": [dict(WAVES[0], fase="1 deg")]}]}, "did you mean phase"),
    ],
)
def test_what_is_wrong_is_told(tide, message):
    with pytest.raises(InputError, match=message):
        mission_with(tide)


def test_it_needs_a_start():
    with pytest.raises(InputError, match="needs the mission's `start`"):
        recorded_current(mission_with({"depths": DEPTHS}).with_(start=None))


def test_the_file_that_tide_writes_is_the_current_of_a_mission(tmp_path):
    seconds = np.arange(0.0, 16.0 * 86400.0, 3600.0)
    begins = datetime(2026, 5, 10, tzinfo=UTC).timestamp()
    wave = 0.4 * np.cos(2.0 * np.pi * seconds / 44714.16) + 0.1 * np.cos(2.0 * np.pi * seconds / 43200.0)
    rows = [
        f"{datetime.fromtimestamp(begins + t, UTC).isoformat()},6,{0.8 * u:.5f},{0.6 * u:.5f}"
        for t, u in zip(seconds, wave, strict=True)
    ]
    (tmp_path / "record.csv").write_text("\n".join(["t_s,depth_m,east_m_s,north_m_s", *rows]))
    missionplan.tide(tmp_path / "record.csv", latitude=math.radians(37.0)).save(tmp_path / "tide")
    error = yaml.safe_load((tmp_path / "tide" / "tide.yaml").read_text().splitlines()[1].lstrip("# "))["site"][
        "current"
    ]["error"]
    assert float(error["sigma"].split()[0]) < 0.02
    data = yaml.safe_load(FIG8.read_text())
    data["vehicle"] = (
        str(FIG8.parent / data["vehicle"]) if isinstance(data.get("vehicle"), str) else data.get("vehicle")
    )
    site = {**data.get("site", {}), "origin": {"latitude": "37 deg", "longitude": "-76 deg"}}
    data |= {
        "start": "2026-05-20T00:00:00",
        "site": {**site, "current": {"tide": "tide/tide.yaml", "error": error, "outside": "hold"}},
    }
    (tmp_path / "mission.yaml").write_text(yaml.safe_dump({key: value for key, value in data.items() if value}))
    mission = missionplan.load(tmp_path / "mission.yaml", allow_outside=True)
    current = recorded_current(mission)
    at = 10 * 24
    found = np.hstack([current.velocity(3600.0 * k, 6.0, NOWHERE) for k in range(24)])
    np.testing.assert_allclose(found[0], 0.8 * wave[at : at + 24], atol=0.02)
    deep = mission.with_({"ingress.depth": "6 m", "site.depth": "40 m"})
    known = missionplan.simulate(deep, trials=40, seed=1, sheet=False)
    doubted = missionplan.simulate(deep.with_({"site.current.error.sigma": "0.15 m/s"}), trials=40, seed=1, sheet=False)
    assert doubted.total.quantities["duration_s"].sd > 1.2 * known.total.quantities["duration_s"].sd
