"""Every form of the site's current, on every phase that it carries."""

import math
import re
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from simulate_missions import EXACT, chesapeake

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.montecarlo.statistics import Count
from missionplan.report.simulation.page import answer
from missionplan.scenario.phases import dive_of
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation import check_trials
from missionplan.studies.simulation.simulate import simulate, simulate_block
from missionplan.studies.simulation.trial_block import run_block

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")

EAST, NORTH = 0.12, -0.05
STEADY = {
    **{key: value for key, value in EXACT.items() if key != "site.current"},
    "navigation.drift_compensation": "forecast",
}
SPEED, TOWARD = math.hypot(EAST, NORTH), math.degrees(math.atan2(EAST, NORTH))


def one_layer(speed=SPEED):
    return [{"down_to": "40 ft", "speed": f"{speed} m/s", "toward": f"{TOWARD} deg"}]


def csv(folder, velocity, times=range(0, 21601, 600), depths=(0.0, 4.0, 8.0, 12.2)):
    rows = [(t, d, *velocity(t, d)) for t in times for d in depths]
    text = "\n".join(",".join(repr(float(value)) for value in row) for row in rows)
    (folder / "current.csv").write_text("t_s,depth_m,east_m_s,north_m_s\n" + text + "\n")
    return {"site.current": {"file": "current.csv"}}


def netcdf(folder, velocity, hours=7, latitudes=(37.18, 37.32), longitudes=(-76.45, -76.30)):
    """A file as NOAA's operational forecast systems regrid them: time, depth, lat, lon, u, v, fill values on land."""
    netCDF4 = pytest.importorskip("netCDF4")
    depths, lat, lon = np.array([0.0, 2.0, 6.0, 10.0, 20.0]), np.linspace(*latitudes, 9), np.linspace(*longitudes, 11)
    with netCDF4.Dataset(folder / "cbofs.nc", "w") as file:
        for name, size in (("time", None), ("depth", depths.size), ("lat", lat.size), ("lon", lon.size)):
            file.createDimension(name, size)
        time = file.createVariable("time", "f8", ("time",))
        time.setncatts({"units": "hours since 2026-05-01 00:00:00", "calendar": "standard", "standard_name": "time"})
        time[:] = np.arange(hours) + 11.0
        for name, values, units in (
            ("depth", depths, "meters"),
            ("lat", lat, "degrees_north"),
            ("lon", lon % 360.0, "degrees_east"),
        ):
            axis = file.createVariable(name, "f8", (name,))
            axis.units = units
            axis[:] = values
        for name, part in (("u", 0), ("v", 1)):
            field = file.createVariable(name, "f4", ("time", "depth", "lat", "lon"), fill_value=np.float32(-99999.0))
            field.units = "meter second-1"
            for hour in range(hours):
                for index, depth in enumerate(depths):
                    field[hour, index] = velocity((hour - 1) * 3600.0, depth)[part]
            field[:, :, :2, :] = -99999.0  # land to the south
            field[:, 4, :, :] = -99999.0  # below the bottom
    return {"site.current": {"file": "cbofs.nc"}, "start": "2026-05-01T12:00:00Z"}


@pytest.mark.parametrize("cell", ["9999", "-1e300", "13"])
def test_a_current_that_no_sea_has_is_refused(tmp_path, cell):
    changes = csv(tmp_path, steady)
    text = (tmp_path / "current.csv").read_text().splitlines()
    text[4] = text[4].rsplit(",", 2)[0] + f",{cell},0"
    (tmp_path / "current.csv").write_text("\n".join(text) + "\n")
    with pytest.raises(InputError, match=r"current.csv:5: is impossible; expected .*east_m_s at most 12"):
        recorded_current(chesapeake(tmp_path, STEADY | changes))


def test_a_record_of_dated_times_meets_a_later_start_later(tmp_path):
    changes = csv(tmp_path, lambda t, depth: (1e-5 * t, 0.0))
    text = (tmp_path / "current.csv").read_text().splitlines()
    begin = datetime(2026, 5, 1, 11, 30, tzinfo=UTC)
    dated = [
        (begin + timedelta(seconds=float(row.split(",")[0]))).isoformat() + row[row.index(",") :] for row in text[1:]
    ]
    (tmp_path / "current.csv").write_text("\n".join([text[0], *dated]) + "\n")
    found = recorded_current(chesapeake(tmp_path, STEADY | changes | {"start": "2026-05-01T12:00:00Z"}))
    assert found.velocity(0.0, 2.0, np.zeros((2, 1)))[0] == pytest.approx(1e-5 * 1800.0)
    with pytest.raises(InputError, match="its times are of the day: the mission needs its `start`"):
        recorded_current(chesapeake(tmp_path, STEADY | changes))


def ramp(folder, **start):
    changes = csv(folder, lambda t, depth: (1e-5 * t, 0.0))
    changes["site.current"] |= {"start": "2026-05-01T11:00:00Z"}
    return changes | start


@pytest.mark.parametrize(("start", "elapsed"), [("2026-05-01T12:30:00Z", 5400.0), ("2026-05-01T10:00:00Z", -3600.0)])
def test_a_record_with_a_start_meets_a_later_mission_later(tmp_path, start, elapsed):
    found = recorded_current(chesapeake(tmp_path, STEADY | ramp(tmp_path, start=start)))
    assert found.time[0] == -elapsed
    at = max(elapsed, 0.0)  # before the record its first value is held
    assert found.velocity(0.0, 2.0, np.zeros((2, 1)))[0] == pytest.approx(1e-5 * at)


def test_a_later_start_changes_the_mission(tmp_path):
    early, late = (
        figures(chesapeake(tmp_path, STEADY | ramp(tmp_path, start=f"2026-05-01T{hour}:00:00Z"))) for hour in (11, 13)
    )
    assert late["ingress.duration_s"] < early["ingress.duration_s"], "the course is east, with a current that grows"


@pytest.mark.parametrize(
    ("start", "outside", "message"),
    [
        (
            "2026-05-01T10:00:00Z",
            "error",
            "2026-05-01 17:00 UTC: it does not hold the mission's start, 2026-05-01 10:00",
        ),
        ("2026-05-02T11:00:00Z", "error", "it does not hold the mission's start"),
        ("2026-05-02T11:00:00Z", "hold", "it ends before the mission starts"),
        (None, "hold", "the record has a start: the mission needs its `start`"),
    ],
)
def test_a_record_beside_the_mission_in_time_is_refused(tmp_path, start, outside, message):
    changes = ramp(tmp_path, **({"start": start} if start else {}))
    changes["site.current"]["outside"] = outside
    with pytest.raises(InputError, match=message):
        simulate(chesapeake(tmp_path, STEADY | changes), trials=2, sheet=False)


def test_dates_in_the_record_need_no_start_beside_them(tmp_path):
    changes = ramp(tmp_path, start="2026-05-01T12:00:00Z")
    text = (tmp_path / "current.csv").read_text().replace("\n0.0,", "\n2026-05-01T12:00:00Z,")
    (tmp_path / "current.csv").write_text(text)
    with pytest.raises(InputError, match=r"its times are dates, which site.current.start does not shift"):
        recorded_current(chesapeake(tmp_path, STEADY | changes))


def test_a_field_has_dates_of_its_own(tmp_path):
    changes = netcdf(tmp_path, steady)
    changes["site.current"] |= {"start": "2026-05-01T11:00:00Z"}
    with pytest.raises(InputError, match=r"site.current.start: a NetCDF current has dates of its own"):
        recorded_current(chesapeake(tmp_path, STEADY | changes))


def test_times_that_are_no_dates_are_refused(tmp_path):
    netCDF4 = pytest.importorskip("netCDF4")
    changes = netcdf(tmp_path, lambda t, depth: (EAST, NORTH))
    with netCDF4.Dataset(tmp_path / "cbofs.nc", "a") as file:
        file["time"].units = "hours"
    with pytest.raises(InputError, match=r"cbofs.nc: its times are no dates.*`units`"):
        recorded_current(chesapeake(tmp_path, STEADY | changes))


def steady(t, depth):
    return EAST, NORTH


def figures(mission, trials=20):
    block = simulate_block(mission, seed=1, block=0, trials=trials)
    assert block.success.all()
    return {name: float(np.mean(values)) for name, values in block.columns().items()}


@pytest.mark.parametrize("form", ["csv", "netcdf"])
def test_a_steady_current_is_the_same_in_every_form(tmp_path, form):
    changes = {"csv": csv, "netcdf": netcdf}[form](tmp_path, steady)
    layered = figures(chesapeake(tmp_path, {**STEADY, "site.current": one_layer()}))
    recorded = figures(chesapeake(tmp_path, STEADY | changes))
    for name, value in layered.items():
        if name in recorded:
            assert recorded[name] == pytest.approx(value, rel=2e-6, abs=1e-4), name


def test_the_current_carries_every_phase(tmp_path):
    mission = chesapeake(tmp_path, {**STEADY, "site.current": one_layer()})
    found = figures(mission)
    # the forecast is exact; what is left is that Eq. 22 aims off for the nominal leg's time, not the adjusted one's
    assert found["ingress.arrival_error_m"] < 3.0
    sinking = found["moor.release_time_s"] + found["moor.descent_time_s"]
    assert found["moor.offset_m"] == pytest.approx(SPEED * sinking, rel=1e-9)
    block = simulate_block(mission, seed=1, block=0, trials=1)
    moor, egress = block.phases[1], block.phases[2]
    arrival = np.array([1600.0, 0.0]) + block.phases[0].miss[:, 0]
    assert moor.anchor[:, 0] == pytest.approx(arrival + np.array([EAST, NORTH]) * sinking)
    rising = found["moor.ascent_time_s"] + 90.0
    assert egress.start[0] == moor.end[0]
    expected = moor.anchor[:, 0] + np.array([EAST, NORTH]) * rising
    away = math.hypot(*expected)
    assert found["egress.distance_m"] > 0.9 * away


def test_layers_act_at_their_depths(tmp_path):
    surface_only = [
        {"down_to": "1 m", "speed": "0.3 m/s", "toward": "90 deg"},
        {"down_to": "40 ft", "speed": "0 m/s", "toward": "90 deg"},
    ]
    changes = {**STEADY, "site.current": surface_only, "phases.0.transit.depth": "2 m"}
    changes["phases.1.moor.lateral"] = "uncoupled"  # tied, the anchor keeps some of the surface's velocity
    found = figures(chesapeake(tmp_path, changes))
    # under way there is none; at the surface it carries 27 m a surfacing, which the forecast aims off
    assert found["ingress.distance_m"] == pytest.approx(1600.0 - 27.0 * found["ingress.surfacings"], rel=1e-9)
    drifted = found["moor.offset_m"] / 0.3
    assert found["moor.release_time_s"] < drifted < found["moor.release_time_s"] + 1.5


def test_a_tide_turns_during_the_mission(tmp_path):
    def tide(t, depth):
        return 0.2 * math.cos(2 * math.pi * t / 14400.0), 0.0

    times = range(0, 28801, 60)
    mission = chesapeake(tmp_path, STEADY | csv(tmp_path, tide, times=times))
    block = run_block(
        Scenario.at_means(mission, recorded_current(mission)).sampled(seed=1, block=0, size=1), 1, 0, 1, tracked=1
    )
    ingress, moor = block.phases[:2]
    egress = block.phases[2]

    def travel(phase):
        begin, end = (math.sin(2 * math.pi * float(t[0]) / 14400.0) for t in (phase.start, phase.end))
        return 0.2 * 14400.0 / (2 * math.pi) * (end - begin)

    out, back = (float(phase.quantities["distance_m"][0]) for phase in (ingress, egress))
    assert travel(ingress) > 200.0  # the flood carries it in, and for a while against it out
    assert out == pytest.approx(1600.0 - travel(ingress), abs=16.0)  # to the arrival radius
    began = 1600.0 + float(moor.miss[0, 0] + moor.track[-1, 0, 0] - moor.anchor[0, 0])
    assert back == pytest.approx(began + travel(egress), abs=16.0)
    at = float(moor.start[0]) + 0.5 * float(moor.quantities["release_time_s"][0])
    drift = float(moor.quantities["offset_m"][0])
    sinking = float(moor.quantities["release_time_s"][0] + moor.quantities["descent_time_s"][0])
    assert drift == pytest.approx(abs(0.2 * math.cos(2 * math.pi * (at + 5.0) / 14400.0)) * sinking, rel=0.05)


def test_what_the_forecast_lacks_is_the_trials_own_draw(tmp_path):
    uncertain = [{"down_to": "40 ft", "speed": {"mean": "0.2 m/s", "sd": "0.1 m/s"}, "toward": "0 deg"}]
    block = simulate_block(chesapeake(tmp_path, {**STEADY, "site.current": uncertain}), seed=1, block=0)
    arrived = block.phases[0].events["arrived"]
    miss, speed = block.phases[0].miss[:, arrived], block.draws["site.current[0].speed"][arrived]
    assert np.corrcoef(speed, miss[1])[0, 1] > 0.5
    known = np.abs(speed - 0.2) < 0.001
    assert np.abs(miss[:, known]).max() < 4.0


def test_a_field_fills_land_and_places_itself(tmp_path):
    mission = chesapeake(tmp_path, STEADY | netcdf(tmp_path, lambda t, d: (0.1 + 0.01 * d, t / 36000.0)))
    current = recorded_current(mission)
    assert np.isfinite(current.values).all()
    east, north = current.velocity(np.array([5400.0]), np.array([4.0]), np.array([[800.0], [-20.0]]))[:, 0]
    assert east == pytest.approx(0.14, abs=1e-6)
    assert north == pytest.approx(0.15, abs=1e-6)
    metres = np.diff(current.grid.north_axis)
    assert metres == pytest.approx(np.full(metres.size, 0.0175 * 110_990.0), rel=2e-3)
    assert current.grid.east_axis[0] == pytest.approx(-0.07 * 111_320.0 * math.cos(math.radians(37.25)), rel=3e-3)


def test_a_field_that_does_not_reach_the_mission_is_refused(tmp_path):
    away = chesapeake(tmp_path, STEADY | netcdf(tmp_path, steady, longitudes=(-76.45, -76.37)))
    with pytest.raises(InputError, match=r"ingress\.to.*the field reaches"):
        simulate(away, trials=10, sheet=False)
    late = chesapeake(tmp_path, STEADY | netcdf(tmp_path, steady) | {"start": "2026-05-03T00:00:00Z"})
    with pytest.raises(InputError, match="does not hold the mission's start"):
        simulate(late, trials=10, sheet=False)


def test_a_record_that_ends_as_the_mission_starts_is_said_to_end_then(tmp_path):
    spent = chesapeake(tmp_path, STEADY | netcdf(tmp_path, steady) | {"start": "2026-05-01T17:00:00Z"})
    with pytest.raises(
        InputError, match=r"the record ends at 2026-05-01 17:00 UTC; the nominal mission ends at 2026-05-01 \d\d:"
    ):
        simulate(spent, trials=10, sheet=False)


def test_a_record_that_ends_before_the_nominal_mission_is_refused_with_the_remedy(tmp_path):
    short = chesapeake(tmp_path, STEADY | csv(tmp_path, steady, times=(0, 1800)))
    with pytest.raises(InputError, match=r"0 s to 1800 s .*the nominal mission takes \d{4} s .*outside: hold"):
        simulate(short, trials=10, sheet=False)


def test_a_record_that_some_trials_outlast_fails_them_or_the_run(tmp_path):
    slow = {"phases.1.moor.galvanic_release": {"choices": ["10 min"] * 199 + ["8 h"]}}
    found = simulate(chesapeake(tmp_path, STEADY | csv(tmp_path, steady) | slow), trials=1000, sheet=False)
    steps = {step.step: step.lost.value for step in found.attrition}
    share = steps["moor: left the record of the current"]
    assert share == found.limits["left_record"].value == pytest.approx(0.005, abs=0.0045)
    assert found.phases[2].quantities["duration_s"].p95 < 1e4
    often = {"phases.1.moor.galvanic_release": {"choices": ["10 min"] * 19 + ["8 h"]}}
    with pytest.raises(InputError, match=r"% of the trials leave the record .*at most 1 % may .*outside: hold"):
        simulate(chesapeake(tmp_path, STEADY | csv(tmp_path, steady) | often), trials=400, sheet=False)


def test_one_trial_in_a_hundred_may_leave_the_record(tmp_path):
    mission = chesapeake(tmp_path, STEADY | csv(tmp_path, steady))
    means = Scenario.at_means(mission, recorded_current(mission))
    check_trials(means, None)
    check_trials(means, Count(4, 400))
    with pytest.raises(InputError, match=r"1\.25 % of the trials leave the record"):
        check_trials(means, Count(5, 400))


@pytest.mark.parametrize("outside", ["hold", "zero"])
def test_a_short_record_may_be_held_or_taken_as_no_current_and_the_share_is_said(tmp_path, outside):
    changes = STEADY | csv(tmp_path, steady, times=(0, 600))
    changes["site.current"] |= {"outside": outside}
    mission = chesapeake(tmp_path, changes)
    found = simulate(mission, trials=20, sheet=False)
    assert found.limits["left_record"].value == 1.0
    assert "In 100\u00a0% of the trials the mission leaves the record of the current" in answer(found)
    offset = found.phases[1].quantities["offset_m"].mean  # the dive is after the record's end
    assert (offset < 1e-6) == (outside == "zero")


def test_a_record_that_is_not_deep_enough_is_refused(tmp_path):
    shallow = chesapeake(tmp_path, STEADY | csv(tmp_path, steady, depths=(0.0, 4.0)))
    with pytest.raises(InputError, match=r"the nominal moor leaves the record, .* down to 9 m"):
        simulate(shallow, trials=10, sheet=False)


@pytest.mark.parametrize(("west", "east"), [(179.8, 180.2), (-180.3, -179.7), (0.0, 359.0)])
def test_a_field_may_cross_the_date_line_or_be_global(tmp_path, west, east):
    origin = {"latitude": "37.25 deg", "longitude": "179.99 deg"}
    changes = STEADY | netcdf(tmp_path, steady, longitudes=(west, east)) | {"site.origin": origin}
    current = recorded_current(chesapeake(tmp_path, changes))
    assert (np.diff(current.grid.east_axis) > 0.0).all()
    assert current.grid.east_axis[0] < -1700.0 < 1700.0 < current.grid.east_axis[-1]


def test_without_layers_the_anchor_is_sized_for_one_design_current(tmp_path):
    changes = {"phases.1.moor.anchor_wet_weight": "sized", "phases.1.moor.design_current": "0.5 kn"}
    sized = chesapeake(tmp_path, STEADY | csv(tmp_path, steady) | changes)
    scenario = Scenario.at_means(sized, recorded_current(sized))
    speed = 0.5 * 0.514444 * 12.192 / 22.86
    dive = dive_of(scenario, scenario.moor())
    assert dive.wet_weight == pytest.approx(float(dive.vehicle_drag(speed)) + float(dive.anchor_drag(speed)), rel=1e-5)


def test_what_the_steps_of_a_record_cost_a_leg_is_said(tmp_path):
    """A tide of 0.4 m/s each hour: a straight line is off by at most 0.4 (ω h)²/8 = 12.6 mm/s, 13 m on a leg of 1600 m."""
    omega, rows = 2.0 * np.pi / 44_714.16, ["t_s,depth_m,east_m_s,north_m_s"]
    for t in range(0, 30 * 3600, 3600):
        rows += [f"{t},{depth},{0.4 * np.cos(omega * t):.6f},0" for depth in (0, 30)]
    (tmp_path / "tide.csv").write_text("\n".join(rows), encoding="utf-8")
    (tmp_path / "mission.yaml").write_text(
        "name: hourly\nsite: {depth: 30 m, current: {file: tide.csv}}\n"
        "navigation: {velocity_error: {sigma: 0.01 m/s}, surfacing_time: 60 s}\nphases:\n  - transit: {from: [0 m, 0 m], "
        "to: [0 m, 3200 m], depth: 2 m, speed: 1.5 m/s, d_max: 1600 m, arrival_radius: 900 m}\n",
        encoding="utf-8",
    )
    (notice,) = [
        n for n in simulate(load(tmp_path / "mission.yaml"), trials=20, sheet=False).provenance.notices if "every" in n
    ]
    assert "every 60 min" in notice
    (off,) = re.findall(r"up to ([\d.]+) m/s: up to 13 m on a leg of 1600 m", notice)
    assert float(off) == pytest.approx(0.4 * (omega * 3600.0) ** 2 / 8.0, abs=1e-3)
