"""The plan: nominal legs in closed form, time-outs from trials, the interval in place of a table, the hash."""

import copy
import hashlib
import json
import re
from dataclasses import replace
from types import SimpleNamespace

import jsonschema
import numpy as np
import pandas as pd
import pytest
from made_plans import PLANS
from planned_missions import TABLE, by_table, chesapeake, starter
from pyproj import Geod

import missionplan
from missionplan.errors import InputError
from missionplan.exporters import VEHICLES, conformance, conformance_table, one_interval
from missionplan.exporters.plan_json import plan_json
from missionplan.mission import Mission
from missionplan.results import to_yaml
from missionplan.results.plan import PlannedMooring, PlannedTransit, SurfacingRule
from missionplan.results.plan_places import Waypoint, time_out
from missionplan.results.plan_states import GUARDS, states_of
from missionplan.studies.export import mission_plan
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.simulation.simulate import simulate, simulate_block

pytestmark = pytest.mark.usefixtures("unassumed")

SCHEMA = missionplan.schema("plan")
VALIDATOR = jsonschema.Draft7Validator(SCHEMA)


@pytest.fixture(scope="module")
def plan():
    return mission_plan(chesapeake())


def test_nominal_legs_are_those_of_d_max(plan):
    ingress, egress = plan.transits
    assert [leg.length for leg in ingress.legs] == pytest.approx([350.0] * 4 + [200.0])
    assert [leg.east for leg in ingress.waypoints] == pytest.approx([0.0, 350.0, 700.0, 1050.0, 1400.0, 1600.0])
    assert [leg.kind for leg in ingress.waypoints] == ["start", *["surfacing"] * 4, "arrival"]
    assert not any(leg.is_via for leg in ingress.waypoints)
    rule = ingress.surfacing
    assert (rule.interval, rule.extra_time, rule.extra_time_error) == (350.0, 0.0, 0.0)
    assert {np.degrees(leg.course) for leg in ingress.legs} == {90.0}
    assert {round(np.degrees(leg.course), 9) for leg in egress.legs} == {270.0}
    assert [leg.duration for leg in ingress.legs] == pytest.approx([350.0 / 1.5] * 4 + [200.0 / 1.5])


def test_waypoints_lie_on_the_way_in_every_quadrant():
    """From the start, which is not the origin: each waypoint a leg's length along the course from the one before."""
    corners = [(300.0, -200.0), (-500.0, 400.0), (-900.0, -800.0), (700.0, -950.0), (1000.0, 100.0)]
    first = {**TABLE["phases"][0]["transit"], "d_max": "330 m", "arrival_radius": "20 m"}
    sides = [{**first, "name": f"side {n}", "to": [f"{x} m", f"{y} m"]} for n, (x, y) in enumerate(corners[1:])]
    sides = [side if n == 0 else {key: side[key] for key in side if key != "from"} for n, side in enumerate(sides)]
    sides[0]["from"] = ["300 m", "-200 m"]
    found = mission_plan(by_table({"phases": [{"transit": side} for side in sides]}))
    elapsed = 0.0
    for transit, start, goal in zip(found.transits, corners[:-1], corners[1:], strict=True):
        way = np.subtract(goal, start)
        assert (transit.start.east, transit.start.north) == pytest.approx(start)
        assert (transit.goal.east, transit.goal.north) == pytest.approx(goal)
        assert transit.start.elapsed == pytest.approx(elapsed)
        for number, leg in enumerate(transit.legs):
            before = transit.waypoints[number]
            moved = np.array([leg.east - before.east, leg.north - before.north])
            assert leg.length == pytest.approx(np.hypot(*moved)) == min(330.0, np.hypot(*way) - 330.0 * number)
            assert np.array([np.sin(leg.course), np.cos(leg.course)]) == pytest.approx(moved / leg.length)
            assert moved / leg.length == pytest.approx(way / np.hypot(*way))
            assert leg.duration == pytest.approx(leg.length / 1.25)
            elapsed += leg.duration + 90.0 * (number > 0)
            assert leg.elapsed == pytest.approx(elapsed)
            azimuth, distance = np.degrees(np.arctan2(leg.east, leg.north)), np.hypot(leg.east, leg.north)
            longitude, latitude, _ = Geod(ellps="WGS84").fwd(179.99, -17.5, azimuth, distance)
            turn = np.remainder(np.degrees(leg.longitude) - longitude + 180.0, 360.0) - 180.0
            assert (np.degrees(leg.latitude), turn) == pytest.approx((latitude, 0.0), abs=1e-6)
        elapsed += 90.0


def test_nominal_time_adds_legs_and_surfacings(plan):
    ingress, egress = plan.transits
    (moor,) = plan.moorings
    assert ingress.goal.elapsed == pytest.approx(1600.0 / 1.5 + 4 * 90.0)
    assert moor.elapsed == pytest.approx(ingress.goal.elapsed + 90.0)
    held = moor.release_time + moor.hold + moor.galvanic_release + 90.0
    assert egress.start.elapsed == pytest.approx(moor.elapsed + held)


def test_the_moor_is_where_the_transit_ends_with_its_release_time(plan):
    (moor,) = plan.moorings
    assert (moor.east, moor.north, moor.radius) == pytest.approx((1600.0, 0.0, 75 * 0.3048))
    assert moor.release_time == pytest.approx(10.0, abs=0.01)
    assert moor.release_time_p99 == pytest.approx(10.0 + 3.0 * 2.3263, abs=0.02)
    assert (moor.hold, moor.galvanic_release, moor.surface_time_p99) == (1200.0, 600.0, 90.0)
    assert (moor.line_length, moor.anchor_wet_weight) == (5.0, 11.8)
    assert moor.water_depth == pytest.approx(40 * 0.3048)
    azimuth, _, distance = Geod(ellps="WGS84").inv(-76.38, 37.25, *np.degrees((moor.longitude, moor.latitude)))
    assert (azimuth, distance) == pytest.approx((90.0, 1600.0), abs=0.01)


@pytest.mark.parametrize("unknown", ["depth", "site"])
def test_a_mooring_in_water_of_unknown_depth_has_none(unknown):
    data = copy.deepcopy({key: value for key, value in chesapeake().raw.items() if key != "requirements"})
    del (data if unknown == "site" else data["site"])[unknown]
    (moor,) = mission_plan(Mission.from_data(data)).moorings
    assert np.isnan(moor.water_depth)
    assert np.isnan(moor.latitude) == (unknown == "site")


def test_p99_of_a_leg_is_that_of_its_trials(plan):
    """The second leg out: its durations in the trials of the mission itself."""
    trials = simulate_block(chesapeake(), seed=1, block=0, trials=1024)
    outcome = simulate(chesapeake(), trials=300, seed=1, sheet=False)
    time = outcome.tracks.time[outcome.tracks.phase == 0]
    second = time[3] - time[2]
    assert plan.transits[0].legs[1].duration_p99 == pytest.approx(np.nanquantile(second, 0.99), abs=3.0)
    whole = trials.phases[0].quantities["duration_s"]
    assert plan.transits[0].duration_p99 == pytest.approx(np.quantile(whole[np.isfinite(whole)], 0.99))


def test_a_time_out_is_never_below_the_nominal_time():
    assert time_out(100.0, 80.0) == 110.0
    assert time_out(100.0, 140.0) == 154.0
    assert time_out(100.0, float("nan")) == 110.0


def test_one_interval_in_place_of_a_table_costs_least_and_its_cost_is_that_of_a_sweep():
    mission = by_table()
    rule = mission_plan(mission).transits[0].surfacing
    sweep = sweep_dmax(mission, trials=4096, seed=5, method="monte-carlo")
    (curve,) = sweep.curves
    found = min(curve.points, key=lambda point: abs(point.d_max - rule.interval))
    nominal = sweep.distance / sweep.speed
    assert found.cost <= curve.recommended.cost + 4.0 * np.hypot(found.standard_error, curve.recommended.standard_error)
    extra = (found.cost - curve.table.cost) * nominal
    surfacing_error = 4.0 * nominal * np.hypot(found.standard_error, curve.table.standard_error)
    assert rule.extra_time == pytest.approx(extra, abs=surfacing_error + 4.0 * rule.extra_time_error)
    assert 4.0 * rule.extra_time_error < 2.5 * surfacing_error  # a quarter of the trials, but in pairs


def test_the_rule_for_surfacing_is_the_mission_s():
    """Times at the surface are of mean 80 s and 10 s of scatter: 99 % are below 80 s + 2.3263 times 10 s."""
    legs = {**TABLE["phases"][0]["transit"], "d_max": "2 km"}
    scattered = {**TABLE["navigation"], "surfacing_time": {"mean": "80 s", "sd": "10 s"}}
    found = mission_plan(by_table({"phases": [{"transit": legs}], "navigation": scattered}))
    (transit,) = found.transits
    rule = transit.surfacing
    assert (transit.name, transit.depth, transit.speed, transit.arrival_radius) == ("way <out> & up", 12.5, 1.25, 50.0)
    assert (rule.interval, rule.interval_time, rule.surface_time) == pytest.approx((2000.0, 1600.0, 80.0))
    assert rule.surface_time_p99 == pytest.approx(103.263, abs=0.01)
    assert (rule.table, rule.extra_time, rule.extra_time_error) == ((), 0.0, 0.0)
    assert (transit.aim, transit.extra_legs, found.has_thruster, found.corrects) == (None, 0, False, False)
    turned = {**scattered, "drift_compensation": "last-leg"}
    assert mission_plan(by_table({"phases": [{"transit": legs}], "navigation": turned})).corrects


def test_legs_by_a_table_are_as_long_as_it_says():
    legs = mission_plan(by_table()).transits[0].legs
    left = np.hypot(6000.0, 4000.0)
    for leg in legs:
        assert leg.length == pytest.approx(min(left, np.interp(left, [200.0, 1500.0, 8000.0], [180.0, 1400.0, 3000.0])))
        left -= leg.length
    assert left == pytest.approx(0.0, abs=2e-3)


def test_the_hash_is_that_of_the_report_s_mission(plan):
    mission = chesapeake()
    assert plan.digest == hashlib.sha256(to_yaml(mission.raw).encode()).hexdigest()
    changed = copy.deepcopy(dict(mission.raw))
    changed["phases"][0]["transit"]["d_max"] = "351 m"
    assert mission_plan(Mission.from_data(changed)).digest != plan.digest


def test_plans_follow_their_schema(plan, tmp_path):
    VALIDATOR.check_schema(SCHEMA)
    local = {key: value for key, value in TABLE.items() if key != "site"}
    for each in (
        plan,
        mission_plan(starter(tmp_path)),
        mission_plan(by_table()),
        mission_plan(Mission.from_data(local)),
    ):
        VALIDATOR.validate(json.loads(plan_json(each)))


def test_the_plan_is_a_state_machine(plan):
    """Every state is reached, every way ends, and the anchor is released after a fix within the radius alone."""
    states = {state.name: state for state in states_of(plan)}
    first = states_of(plan)[0].name
    reached, new = {first}, [first]
    while new:
        new = [each.to for name in new for each in states[name].transitions if each.to not in reached]
        reached |= set(new)
    assert reached == set(states)
    assert {name for name, state in states.items() if not state.transitions} == {"done", "abort"}
    into = [(state, each) for state in states.values() for each in state.transitions if each.to == "2-release"]
    ((decide, transition),) = into
    assert decide.kind == "decide"
    assert [(guard.kind, guard.value) for guard in transition.guards] == [("fix-within", 15.0)]
    kinds = {each.to: [guard.kind for guard in each.guards] for each in states["1-fix"].transitions[:1]}
    assert kinds == {"1-decide": ["fix-received"]}
    longest = {
        guard.value for each in states["1-surfacing"].transitions for guard in each.guards if guard.kind == "way-made"
    }
    assert longest == {350.0}
    legs = [each for each in states_of(PLANS["west"])[0].transitions if each.to == "1-surfacing"]
    ascent = 4.37 / np.tan(np.radians(5.0))  # goes up so much before the end of a leg, which none is longer than
    assert [each.guards[0].value for each in legs] == pytest.approx([ascent, 411.7 - ascent])


def test_a_leg_after_a_point_on_the_way_begins_with_a_fix_there():
    there = {**TABLE["phases"][0]["transit"], "to": ["0 m", "2 km"], "via": [["0 m", "1 km"]], "d_max": "600 m"}
    (transit,) = mission_plan(by_table({"phases": [{"transit": there}]})).transits
    assert [leg.length for leg in transit.legs] == pytest.approx([600.0, 400.0] * 2)
    assert [leg.elapsed for leg in transit.legs] == pytest.approx(
        [way / 1.25 + 90.0 * k for k, way in enumerate((600.0, 1000.0, 1600.0, 2000.0))]
    )
    assert [leg.is_via for leg in transit.legs] == [False, True, False, False]


@pytest.fixture(scope="module")
def aimed():
    return mission_plan(chesapeake(), to="moos").transits


def test_a_plan_for_a_vehicle_aims_off_by_the_drift_at_the_surface(aimed):
    """0.4 kn for 90 s toward 60°, drawn with a scatter whose mean is zero."""
    ingress, _ = aimed
    off = np.subtract((ingress.aim.east, ingress.aim.north), (ingress.goal.east, ingress.goal.north))
    drift = 0.4 * 1852.0 / 3600.0 * 90.0 * np.array([np.sin(np.radians(60.0)), np.cos(np.radians(60.0))])
    assert off == pytest.approx(-drift, abs=1.0)


def test_parts_of_a_transit_aim_off_as_its_goal_does(aimed):
    ingress = aimed[0]
    ways = tuple(replace(each, is_via=number == 2) for number, each in enumerate(ingress.waypoints))
    first, second = replace(ingress, waypoints=ways).parts
    assert (first.goal, second.start, second.goal) == (ways[2], ways[2], ways[-1])
    for axis in ("east", "north", "latitude", "longitude"):
        off = [getattr(each.aim, axis) - getattr(each.goal, axis) for each in (ingress, first, second)]
        assert off == pytest.approx([off[0]] * 3, rel=1e-6)
        assert off[0] != 0.0


def test_the_schema_refuses_what_is_no_plan(plan):
    for key in SCHEMA["required"]:
        data = {name: value for name, value in json.loads(plan_json(plan)).items() if name != key}
        with pytest.raises(jsonschema.ValidationError):
            VALIDATOR.validate(data)


def test_simulate_writes_the_plan_without_an_origin_too(tmp_path):
    local = {key: value for key, value in TABLE.items() if key != "site"}
    mission = Mission.from_data({**local, "monte_carlo": {"seed": 5}})
    simulate(Mission.from_data(local), trials=50, seed=5, sheet=False).save(tmp_path / "report")
    data = json.loads((tmp_path / "report" / "plan.json").read_text())
    VALIDATOR.validate(data)
    planned = json.loads(plan_json(mission_plan(mission)))
    assert planned["phases"] == data["phases"] != json.loads(plan_json(mission_plan(mission, seed=6)))["phases"]
    table = pd.read_csv(tmp_path / "report" / "waypoints.csv", comment="#")
    assert table["east_m"].iloc[-1] == 6000.0
    assert table["latitude_deg"].isna().all()
    assert not (tmp_path / "report" / "track.geojson").exists()
    assert hashlib.sha256((tmp_path / "report" / "mission.yaml").read_bytes()).hexdigest() == data["mission_sha256"]


def test_a_course_of_more_legs_than_the_mission_allows_is_no_plan():
    short = copy.deepcopy(TABLE)
    short["phases"][0]["transit"]["d_max"] = "100 m"
    short["navigation"]["max_legs"] = 60
    short["site"]["current"] = [{"down_to": "50 m", "speed": "0.6 m/s", "toward": "56 deg"}]  # with it 60 may do
    mission = Mission.from_data(short)
    with pytest.raises(InputError, match="max_legs: given 60, but way <out> & up is 1211 m from its goal"):
        mission_plan(mission)
    assert simulate(mission, trials=20, seed=1, sheet=False).plan is None


@pytest.mark.parametrize("start", ["2026-06-01T14:00:00+02:00", "2026-06-01T12:00:00", "2026-06-01T12:00:00Z"])
def test_the_start_is_in_utc(start):
    assert mission_plan(by_table({"start": start})).start_utc == "2026-06-01T12:00:00+00:00"


def test_every_format_says_what_it_keeps_of_each_guard():
    rows = conformance_table().splitlines()
    assert len(rows) == 2 + len(GUARDS)
    assert {row.count("|") for row in rows} == {len(VEHICLES) + 2}
    for name in VEHICLES:
        assert set(conformance(name)) == set(GUARDS)
        assert all(re.match("kept|weaker: |done otherwise: |refused", words) for words in conformance(name).values())


def test_a_zone_kept_out_of_is_a_fence_of_the_plan(tmp_path):
    ring = [[-76.375, 37.252], [-76.370, 37.252], [-76.370, 37.256], [-76.375, 37.256], [-76.375, 37.252]]
    zone = {"type": "Feature", "properties": {"name": "range"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    (tmp_path / "zones.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [zone]}))
    mission = chesapeake().with_({"site.keep_out": {"file": str(tmp_path / "zones.geojson")}})
    (fence,) = mission_plan(mission).fences
    assert not fence.limits
    found = {tuple(np.round(np.degrees(corner), 6)) for corner in fence.outline}
    assert found == {(latitude, longitude) for longitude, latitude in ring}


def test_times_depths_and_parts_of_a_plan_by_hand():
    def moored(depth, line, surface):
        return PlannedMooring("m", 0.0, 0.0, 0.0, 0.0, 20.0, depth, line, 11.0, 3.0, 7.0, 600.0, 500.0, 0.0, surface)

    times = ("touchdown_depth", "longest_sinking", "longest_release", "fix_wait")
    deep, shallow, unknown = moored(30.0, 5.0, 150.0), moored(8.0, 8.0, 100.0), moored(np.nan, 5.0, 0.0)
    assert [getattr(deep, name) for name in times] == pytest.approx([0.9 * 25.0, 150.0, 2100.0, 750.0])
    assert [getattr(shallow, name) for name in times] == pytest.approx([np.nan, 60.0, 2100.0, 600.0], nan_ok=True)
    assert [getattr(unknown, name) for name in times[:2]] == pytest.approx([np.nan, 600.0], nan_ok=True)

    def point(name, east, north, elapsed, *, is_via=False):
        place = (east, north, 1e-6 * north, 2e-6 * east)
        return Waypoint(name, "surfacing", *place, 0.0, 300.0, 250.0, 280.0, elapsed, is_via)

    way = (point("0", 0.0, 0.0, 100.0), point("1", 300.0, 100.0, 400.0, is_via=True), point("2", 600.0, -50.0, 900.0))
    rule = SurfacingRule(interval=400.0, interval_time=333.0, surface_time=30.0, surface_time_p99=200.0)
    transit = PlannedTransit("t", 4.0, 1.2, 50.0, rule, way, 850.0, point("aim", 590.0, -20.0, 900.0), 2)
    assert (transit.time_out, replace(transit, duration_p99=np.nan).time_out) == (935.0, 913.0)
    assert transit.abort_time == 1.5 * 935.0 + 5.0 * 200.0
    assert transit.ascent_margin == pytest.approx(4.0 / np.tan(np.radians(5.0)))
    assert replace(transit, depth=40.0).ascent_margin == 200.0
    assert transit.aim_off == pytest.approx(np.hypot(10.0, 30.0))
    first, second = transit.parts
    assert [(each.start.name, each.goal.name) for each in transit.parts] == [("0", "1"), ("1", "2")]
    assert (first.aim.east, first.aim.north) == pytest.approx((290.0, 130.0))
    assert (first.aim.latitude, first.aim.longitude) == pytest.approx((130e-6, 580e-6))
    assert (second.aim.east, second.aim.north) == (590.0, -20.0)
    assert [each.name for each in transit.sequence] == ["1", "aim", "2 again 1", "2 again 2"]
    assert [(each.east, each.length, each.duration) for each in transit.sequence[2:]] == [(590.0, 0.0, 0.0)] * 2


@pytest.mark.parametrize(("extra", "words"), [(-81.6, "1.36 ± 0.03 minutes less"), (81.6, "1.36 ± 0.03 minutes more")])
def test_time_that_one_interval_saves_is_less(extra, words):
    rule = SimpleNamespace(interval=300.0, extra_time=extra, extra_time_error=1.8, table=((0.0, 100.0),))
    (lost,) = one_interval(SimpleNamespace(transits=(SimpleNamespace(name="out", surfacing=rule),)))
    assert lost.endswith(f"{words} on average")


@pytest.mark.parametrize(("written", "degrees"), [(283.62, -76.38), (-181.0, 179.0), (180.0, 180.0)])
def test_the_origin_lies_within_180_degrees_whatever_the_mission_counts_from(written, degrees):
    moved = chesapeake().with_({"site.origin.longitude": f"{written} deg"})
    assert np.degrees(mission_plan(moved).origin[1]) == pytest.approx(degrees)


def test_a_longitude_beyond_a_turn_is_refused():
    with pytest.raises(InputError, match="given '400 deg', expected at least -6"):
        chesapeake().with_({"site.origin.longitude": "400 deg"})
