"""Files for vehicles, read back by the grammar of each format: every number in them is one of the plan's, in its unit.

The readers share no code with the package: they follow the formats' public descriptions, and refuse what these do not
have. A number that a file holds and no test expects fails, because all of a block's numbers are compared at once.
"""

import cmath
import io
import json
import math
import re
import xml.etree.ElementTree as ElementTree
import zipfile
from dataclasses import replace
from itertools import accumulate

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_plans import PLANS, metres_apart, on_earth
from pyproj import Transformer

from missionplan.errors import InputError
from missionplan.exporters import format_named, slocum
from missionplan.exporters.moos import utm_zone
from missionplan.exporters.slocum import degrees_minutes
from missionplan.results.plan_places import Fence

FORMATS = ["csv", "gpx", "geojson", "kml", "slocum", "moos", "neptus", "iver", "qgc"]


@pytest.fixture(params=PLANS)
def plan(request):
    return PLANS[request.param]


def written(plan, name):
    return format_named(name).files(plan, "trip")


def as_it_can(plan, name):
    """The plan as the vehicle of a format can sail it at all."""
    return for_a_glider(plan) if name == "slocum" else plan


def off(plan, point, latitude, longitude):
    """Distance [m] of a point of a file [deg] from where the plan has it."""
    return metres_apart(plan.origin, point.east, point.north, latitude, longitude)


# Slocum: `b_arg: name(unit) value  # comment` between <start:b_arg> and <end:b_arg>, the same for waypoints


def read_ma(text):
    assert text.isascii()
    lines = [line.split("#")[0].strip() for line in text.splitlines()]
    lines = [line for line in lines if line]
    behaviour = re.fullmatch(r"behavior_name=(\w+)", lines[0])[1]
    first, last = lines.index("<start:b_arg>"), lines.index("<end:b_arg>")
    arguments = {}
    for line in lines[first + 1 : last]:
        name, unit, value = re.fullmatch(r"b_arg:\s*(\w+)\((\w+)\)\s+(-?[\d.]+)", line).groups()
        arguments[name, unit] = float(value)
    points = []
    if "<start:waypoints>" in lines:
        body = lines[lines.index("<start:waypoints>") + 1 : lines.index("<end:waypoints>")]
        points = [tuple(float(part) for part in line.split()) for line in body]
    return behaviour, arguments, points


def decimal(number):
    """DDMM.mmmm to degrees."""
    degrees = math.trunc(number / 100.0)
    return degrees + (number - 100.0 * degrees) / 60.0


MASTERDATA = {
    "num_legs_to_run": (-2, None), "num_waypoints": (1, 8), "initial_wpt": (-2, 7), "list_when_wpt_dist": (10, None),
    "gps_wait_time": (120, None), "when_secs": (120, None), "keystroke_wait_time": (0, 900), "num_half_cycles_to_do": (-1, None), "d_target_depth": (3, 1000),
    "c_target_depth": (3, 1000), "d_bpump_value": (-1000, 1000), "c_bpump_value": (-1000, 1000),
    "d_thruster_value": (1, 9), "c_thruster_value": (1, 9),
}  # fmt: skip
"""Least and greatest of the arguments that masterdata (release 10.5) annotates with limits."""
BEHAVIOURS = {
    "abend": {"overtime", "remaining_charge_min"},
    "surface": {
        *("args_from_file", "start_when", "when_secs", "end_action", "gps_wait_time", "keystroke_wait_time"),
        *("c_use_bpump", "c_bpump_value", "c_use_pitch", "c_pitch_value"),
    },
    "goto_list": {
        *("args_from_file", "start_when", "num_waypoints", "num_legs_to_run", "initial_wpt"),
        *("list_stop_when", "list_when_wpt_dist"),
    },
    "yo": {
        *("args_from_file", "start_when", "num_half_cycles_to_do", "end_action"),
        *(f"{way}_{rest}" for way in "dc" for rest in (
            *("target_depth", "use_bpump", "bpump_value", "use_pitch", "pitch_value"),
            *("use_thruster", "thruster_value"),
        )),
    },
    "prepare_to_dive": {"start_when", "wait_time"},
    "sensors_in": set(),
}  # fmt: skip
"""Arguments of each behaviour that masterdata has, as far as they are used."""


def read_mi(text):
    """Behaviours of a mission in their order, with their arguments."""
    assert text.isascii()
    found = []
    for line in (line.split("#")[0].strip() for line in text.splitlines()):
        if behaviour := re.fullmatch(r"behavior: (\w+)", line):
            found.append((behaviour[1], {}))
        elif line and not line.startswith("sensor: "):
            name, value = re.fullmatch(r"b_arg: (\w+)\([\w%]+\) (-?[\d.]+)", line).groups()
            assert name in BEHAVIOURS[found[-1][0]]
            found[-1][1][name] = float(value)
    return found


def for_a_glider(plan, *, speed=0.83, powered=True):
    """The plan at a glider's speeds, each its own."""
    slower = tuple(
        replace(phase, speed=round(speed + 0.07 * n, 2)) if phase in plan.transits else phase
        for n, phase in enumerate(plan.phases)
    )
    return replace(plan, phases=slower, has_thruster=powered)


@pytest.mark.parametrize("powered", [True, False])
def test_slocum(plan, powered):
    plan = for_a_glider(plan, powered=True) if powered else for_a_glider(plan, speed=0.23, powered=False)
    plan = replace(
        plan, phases=tuple(replace(p, depth=p.depth + 1.5) if p in plan.transits else p for p in plan.phases)
    )
    texts = written(plan, "slocum")
    found = {name: read_ma(text) for name, text in texts.items() if name.endswith(".ma")}
    assert set(found) == {f"{kind}{n}.ma" for n in (10, 11) for kind in ("goto_l", "surfac", "yo")} | {
        "surfac30.ma",
        "surfac31.ma",
    }
    assert set(texts) - set(found) == {"plan10.mi", "plan11.mi"}
    assert all({name for name, _ in arguments} <= BEHAVIOURS[kind] for kind, arguments, _ in found.values())
    for number, transit in zip((10, 11), plan.transits, strict=True):
        behaviour, arguments, [(longitude, latitude)] = found[f"goto_l{number}.ma"]
        assert behaviour == "goto_list"
        assert read_mi(texts[f"plan{number}.mi"]) == [
            ("abend", {"overtime": transit.abort_time, "remaining_charge_min": 10.0}),
            ("surface", {"args_from_file": number + 20}),
            ("surface", {"args_from_file": number}),
            ("goto_list", {"args_from_file": number, "start_when": 0}),
            ("yo", {"args_from_file": number, "start_when": 2}),
            (
                "prepare_to_dive",
                {"start_when": 0, "wait_time": math.ceil(max(600, 5 * transit.surfacing.surface_time_p99))},
            ),
            ("sensors_in", {}),
        ]
        assert arguments == {
            ("num_legs_to_run", "nodim"): -2,
            ("start_when", "enum"): 0,
            ("list_stop_when", "enum"): 7,
            ("list_when_wpt_dist", "m"): 10.0,
            ("initial_wpt", "enum"): 0,
            ("num_waypoints", "nodim"): 1,
        }
        assert off(plan, transit.steered_for, decimal(latitude), decimal(longitude)) < 0.2
        rule = transit.surfacing
        at_surface = {
            ("gps_wait_time", "sec"): max(math.ceil(rule.surface_time_p99), 120),
            ("keystroke_wait_time", "sec"): math.ceil(rule.surface_time),
            ("c_use_bpump", "enum"): 2,
            ("c_bpump_value", "X"): 1000,
            ("c_use_pitch", "enum"): 3,
            ("c_pitch_value", "X"): pytest.approx(math.radians(26.0), abs=1e-4),
        }
        climb = min(transit.depth / math.tan(0.4538), rule.interval / 2.0) / transit.speed
        every = {("start_when", "enum"): 6, ("when_secs", "sec"): math.floor(rule.interval_time - climb)}
        assert found[f"surfac{number}.ma"] == ("surface", {**every, ("end_action", "enum"): 1, **at_surface}, [])
        done = {("start_when", "enum"): 3, ("end_action", "enum"): 0, **at_surface}
        assert found[f"surfac{number + 20}.ma"] == ("surface", done, [])
        yo = {
            ("start_when", "enum"): 2,
            ("num_half_cycles_to_do", "nodim"): -1,
            ("d_target_depth", "m"): pytest.approx(transit.depth + powered, abs=0.0051),
            ("c_target_depth", "m"): pytest.approx(transit.depth - 1.0 if powered else 3.0, abs=0.0051),
            ("end_action", "enum"): 2,
        }
        for way, sign in (("d", -1.0), ("c", 1.0)):
            yo |= {
                (f"{way}_use_bpump", "enum"): 2,
                (f"{way}_bpump_value", "X"): 0 if powered else sign * 1000,
                (f"{way}_use_pitch", "enum"): 3,
                (f"{way}_pitch_value", "X"): sign * (0.209 if powered else 0.4538),
            }
            yo |= {(f"{way}_use_thruster", "enum"): 4, (f"{way}_thruster_value", "X"): 9} if powered else {}
        assert found[f"yo{number}.ma"] == ("yo", yo, [])
        assert f"# {rule.interval:.1f} m at {transit.speed} m/s" in texts[f"surfac{number}.ma"]
    for text in texts.values():
        assert all_within_masterdata(text) >= 1 or "behavior: abend" in text


def all_within_masterdata(text):
    """Whether every argument with a limit keeps it and is annotated with it; how many there are."""
    count = 0
    for name, value, rest in re.findall(r"^ *b_arg: (\w+)\([\w%]+\) (\S+)(.*)$", text, re.M):
        low, high = MASTERDATA.get(name, (None, None))
        limits = [f"{word} = {limit:.1f}" for word, limit in (("min", low), ("max", high)) if limit is not None]
        assert (re.search(r"#! ([^#]*?)(?: #|$)", rest) or [None, ""])[1] == "; ".join(limits)
        assert low is None or float(value) >= low
        assert high is None or float(value) <= high
        count += low is not None
    return count


def test_what_a_glider_cannot_do_is_refused_with_its_numbers(plan):
    with pytest.raises(InputError) as error:
        written(plan, "slocum")
    said = str(error.value)
    assert "ingress: a Slocum glider cannot make 1.313 m/s without a thruster" in said
    assert "egress: a Slocum glider cannot make 1.126 m/s without a thruster" in said
    assert "ingress: a Slocum glider cannot run at 4.37 m" in said
    there, *others = for_a_glider(plan).phases
    flat = replace(for_a_glider(plan), phases=(replace(there, depth=0.0), *others))
    with pytest.raises(InputError, match="cannot run at 0 m"):
        written(flat, "slocum")


@given(st.floats(-math.pi, math.pi))
def test_degrees_and_minutes_come_back(angle):
    text = degrees_minutes(angle)
    minutes = float(text.lstrip("-")) % 100.0
    assert 0.0 <= minutes < 60.0
    assert decimal(float(text)) == pytest.approx(math.degrees(angle), abs=0.51e-4 / 60.0)


def test_what_rounds_to_nothing_has_no_sign():
    assert degrees_minutes(-1e-10) == degrees_minutes(1e-10) == degrees_minutes(0.0)
    assert degrees_minutes(-1e-7).startswith("-")


def test_a_glider_surfaces_at_a_point_on_the_way_where_there_is_one(plan):
    there, *others = for_a_glider(plan).phases
    start, *_, goal = there.waypoints
    for count in (0, 1, 2):
        way = replace(there, waypoints=(start, *[replace(goal, is_via=True)] * count, goal), aim=None)
        texts = written(replace(for_a_glider(plan), phases=(way, *others)), "slocum")
        assert ("surfac50.ma" in texts) == (count > 0)
        assert read_ma(texts["goto_l10.ma"])[1]["num_waypoints", "nodim"] == count + 1


def test_minutes_that_round_up_to_sixty_are_a_degree():
    assert degrees_minutes(math.radians(-(36 + 59.99999 / 60.0))) == "-3700.0000"
    assert degrees_minutes(math.radians(-0.5)) == "-030.0000"


# MOOS-IvP: `Behavior = KIND`, then `key = value` lines in braces


def read_bhv(text):
    """Initial values, and behaviours by name: kind, conditions, flags, and what else they hold, numbers as numbers."""
    assert text.isascii()
    lines = [line.split("//")[0].strip() for line in text.splitlines()]
    body = "\n".join(line for line in lines if line)
    behaviours = {}
    for kind, inner in re.findall(r"^Behavior = (\w+)\n\{\n(.*?)\n\}$", body, re.S | re.M):
        pairs = [tuple(part.strip() for part in line.split("=", 1)) for line in inner.splitlines()]
        conditions = [value for key, value in pairs if key == "condition"]
        assert conditions[0] == "MODE == ACTIVE"
        flags = [value for key, value in pairs if key == "endflag"]
        own = {
            key: number(value) for key, value in pairs if key not in ("condition", "endflag", "name", "post_mapping")
        }
        silent = [value for key, value in pairs if key == "post_mapping"]
        assert silent == (["TIMER_IDLE,silent", "TIMER_RUNNING,silent"] if kind == "BHV_Timer" else [])
        name = dict(pairs)["name"]
        assert name not in behaviours
        behaviours[name] = (kind.removeprefix("BHV_"), conditions[1:], flags, own)
    rest = re.sub(r"^Behavior = \w+\n\{\n.*?\n\}$", "", body, flags=re.S | re.M)
    rest, modes = re.subn(r"^set MODE = ACTIVE \{\nDEPLOY = true\n\} INACTIVE$", "", rest, flags=re.S | re.M)
    assert modes == 1
    initial = dict(re.fullmatch(r"initialize (\w+) = (\w+)", line).groups() for line in rest.splitlines() if line)
    return initial, behaviours


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


FOREVER = {"duration": "no-time-limit", "pwt": 100.0}


def timer(seconds, begins=None):
    reset = {} if begins is None else {"duration_reset": f"PHASE={begins}"}
    return {"pwt": 100.0, "duration": pytest.approx(seconds, abs=0.051), "perpetual": "true", **reset}


def level(state, depth):
    own = {**FOREVER, "depth": pytest.approx(depth, abs=0.0051), "peakwidth": 0.0, "basewidth": 2.0}
    return {f"depth_{state}": ("ConstantDepth", [f"PHASE = {state}"], [], own)}


def enter(state):
    return [f"PHASE = {state}", f"STAGE = {state.rpartition('_')[0] or state}"]


def aborted(reason):
    return ["TIME_OUT = true", f"ABORTED_BY = {reason}", *enter("abort")]


def of_transit(transit, name, following, goal, aim):
    """What a transit's states have to be; `goal` and `aim` are the texts of the points."""
    leg, up, fix, decide = (f"{name}_{state}" for state in ("leg", "surfacing", "fix", "decide"))
    rule = transit.surfacing
    climb = min(transit.depth / math.tan(math.radians(5.0)), rule.interval / 2.0)
    wait = max(600.0, 5.0 * rule.surface_time_p99)

    def waypoint(phase, more, point, capture, slip, flags):
        own = {**FOREVER, "speed": transit.speed, "points": point, "repeat": 0.0, "perpetual": "true"}
        own |= {"capture_radius": pytest.approx(capture, rel=1e-3), "slip_radius": slip}
        return ("Waypoint", [f"PHASE = {phase}", *more], flags, own)

    return {
        f"waypoint_{leg}": waypoint(leg, [], aim, 1.0, 3.0, enter(up)),
        f"early_{leg}": waypoint(leg, [f"NAV_DEPTH > {0.5 * transit.depth:.2f}"], aim, climb, 0.0, enter(up)),
        **level(leg, transit.depth),
        f"interval_{leg}": (
            *("Timer", [f"PHASE = {leg}"], enter(up)),
            timer(rule.interval_time - climb / transit.speed, leg),
        ),
        f"rise_{up}": waypoint(up, ["WAY = true"], aim, 1.0, 3.0, ["WAY = false"]),
        f"whole_{leg}": (
            *("Timer", [f"STAGE = {name}", "WAY = true"], ["WAY = false"]),
            timer(rule.interval_time - 1.0, leg),
        ),
        f"surfaced_{up}": (
            *("Timer", [f"PHASE = {up}", "WAY = false", "NAV_DEPTH <= 0.3"], enter(fix)),
            timer(1.0, up),
        ),
        f"fixed_{up}": ("Timer", [f"PHASE = {up}", "FIXED = true"], enter(decide), timer(10.0, up)),
        f"fixed_{fix}": ("Timer", [f"PHASE = {fix}", "FIXED = true"], enter(decide), timer(1.0, fix)),
        f"no_fix_{fix}": ("Timer", [f"PHASE = {fix}"], aborted("NO_FIX"), timer(wait, fix)),
        f"stop_{decide}": ("ConstantSpeed", [f"PHASE = {decide}"], [], {**FOREVER, "speed": 0.0, "pwt": 1000.0}),
        f"arrived_{decide}": waypoint(decide, [], goal, transit.arrival_radius, 0.0, [*enter(following), "WAY = true"]),
        f"further_{decide}": (
            *("Timer", [f"PHASE = {decide}"], [*enter(leg), "WAY = true", "FIXED = false"]),
            timer(3.0, decide),
        ),
        f"time_out_{name}": (
            *("Timer", [f"STAGE = {name}"], aborted("TRANSIT")),
            timer(1.5 * transit.time_out + wait),
        ),
    }


def of_mooring(mooring, name, following):
    release, sink, hold, rise, fix = (f"{name}_{state}" for state in ("release", "descend", "hold", "ascend", "fix"))
    down = 0.9 * (mooring.water_depth - mooring.line_length)

    def at(state, seconds, flags, *more):
        return ("Timer", [f"PHASE = {state}", *more], flags, timer(seconds, state))

    return {
        f"at_{release}": at(
            release, mooring.release_time - 3.0, ["ANCHOR_RELEASE = true", *enter(sink)], "FIXED = true"
        ),
        f"no_fix_{release}": at(release, mooring.release_time + 600.0, aborted("NO_FIX")),
        f"down_{sink}": at(sink, 0.0, enter(hold), f"NAV_DEPTH > {down:.2f}"),
        f"lies_{sink}": at(sink, max(60.0, 5.0 * mooring.water_depth), enter(hold)),
        f"at_{hold}": at(hold, mooring.hold, ["GALVANIC_RELEASE = true", *enter(rise)]),
        f"parted_{rise}": at(rise, mooring.galvanic_release, ["WAY = false"]),
        f"surfaced_{rise}": at(rise, 1.0, enter(fix), "WAY = false", "NAV_DEPTH <= 0.3"),
        f"late_{rise}": at(rise, 3.0 * mooring.galvanic_release + 600.0, aborted("ASCENT")),
        f"fixed_{fix}": at(fix, 1.0, [*enter(following), "WAY = true"], "FIXED = true"),
        f"no_fix_{fix}": at(fix, 600.0, aborted("NO_FIX")),
    }


def test_moos(plan):
    """Every behaviour, condition and number of the file is one of the plan's states."""
    (text,) = written(plan, "moos").values()
    initial, found = read_bhv(text)
    first = {"PHASE": "1_ingress_leg", "STAGE": "1_ingress"}
    assert initial == {"DEPLOY": "false", **first, "WAY": "true", "FIXED": "false"}
    latitude, longitude = (float(re.search(rf"{key} *= (\S+)", text)[1]) for key in ("LatOrigin", "LongOrigin"))
    assert (latitude, longitude) == pytest.approx([math.degrees(angle) for angle in plan.origin], abs=1e-8)
    to_utm = Transformer.from_crs(4326, 32760 if latitude < 0.0 else 32618, always_xy=True)
    origin = to_utm.transform(longitude, latitude)
    (mooring,) = plan.moorings
    forever = {"period": 1e6, "mark_variable": "GPS_UPDATE_RECEIVED", "pending_status_var": "FIX_CLOCK"}
    expected = {
        "fix_clock": ("PeriodicSurface", [], [], {**FOREVER, **forever, "max_time_at_surface": 1e6}),
        "fixed": (
            *("Timer", ["NAV_DEPTH <= 0.3", "FIX_CLOCK > 999990", "FIXED = false"], ["FIXED = true"]),
            timer(0.0),
        ),
        "under_water": ("Timer", ["NAV_DEPTH > 0.6", "FIXED = true"], ["FIXED = false"], timer(0.0)),
        **of_mooring(mooring, "2_moor", "3_egress_leg"),
    }
    idle = {**FOREVER, "pwt": 0.1}
    expected |= {
        "idle_depth": ("ConstantDepth", [], [], {**idle, "depth": 0.0, "peakwidth": 0.0, "basewidth": 2.0}),
        "idle_speed": ("ConstantSpeed", [], [], {**idle, "speed": 0.0}),
        "idle_course": ("ConstantHeading", [], [], {**idle, "heading": 0.0}),
    }
    for transit, name, following in zip(
        plan.transits, ("1_ingress", "3_egress"), ("2_moor_release", "done"), strict=True
    ):
        for state, point in (("decide", transit.goal), ("leg", transit.steered_for)):
            (text_of_point,) = {
                own["points"] for key, (*_, own) in found.items() if key.endswith(f"{name}_{state}") and "points" in own
            }
            x, y = (float(part) for part in text_of_point.split(","))
            lon, lat = to_utm.transform(origin[0] + x, origin[1] + y, direction="INVERSE")
            assert off(plan, point, lat, lon) < 0.05
        goal, aim = (found[key][3]["points"] for key in (f"arrived_{name}_decide", f"waypoint_{name}_leg"))
        expected |= of_transit(transit, name, following, goal, aim)
        place = re.search(rf"// {transit.name}: to (\S+), (\S+);", text, re.M)
        assert off(plan, transit.goal, float(place[1]), float(place[2])) < 0.01
    assert found == expected
    assert f"by {mooring.release_time_p99} s in 99 % of cases" in text


def test_moos_without_an_origin_has_the_mission_s_own_plane():
    plan = replace(PLANS["west"], origin=None)
    _, behaviours = read_bhv(written(plan, "moos")["trip.bhv"])
    assert behaviours["arrived_1_ingress_decide"][3]["points"] == "731.50,-612.75"


@pytest.mark.parametrize(
    ("latitude", "longitude", "zone"),
    [
        *[(37.25, -76.38, 18), (60.0, 5.0, 32), (60.0, 2.0, 31), (60.0, 12.0, 33), (56.0, 3.0, 32), (55.9, 3.0, 31)],
        *[(78.0, -1.0, 30), (78.0, 0.5, 31), (78.0, 41.9, 37), (78.0, 42.1, 38), (78.0, 47.0, 38), (71.9, 8.0, 32)],
        *[(78.0, 15.0, 33), (78.0, 8.0, 31), (78.0, 9.0, 33), (78.0, 21.0, 35), (78.0, 33.0, 37), (84.0, 8.0, 32)],
        *[(0.0, 180.0, 1), (0.0, -180.0, 1), (0.0, 179.9, 60), (0.0, -0.1, 30), (0.0, 0.0, 31), (64.0, 5.0, 31)],
    ],
)
def test_utm_zones(latitude, longitude, zone):
    assert utm_zone(latitude, longitude) == zone


# Neptus: the elements that MissionType, PlanType, GraphType, Goto and PopUp of its sources read


def leaves(element, path=""):
    """All texts and attributes of an element by their paths; a repeated path is an error."""
    here = f"{path}/{element.tag}" if path else element.tag
    found = {f"{here}@{key}": number(value) for key, value in element.attrib.items()}
    if len(element) == 0 and element.text:
        found[here] = number(element.text)
    for child in element:
        for key, value in leaves(child, here).items():
            assert key not in found, key
            found[key] = value
    return found


def test_neptus(plan):
    ((name, content),) = written(plan, "neptus").items()
    assert name == "trip.nmisz"
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        root = ElementTree.fromstring(archive.read("mission.nmis"))
    assert root.tag == "mission-def"
    assert (root.find("header/name").text, root.find("header/type").text) == (plan.mission, "Test")
    home = root.find("definitions/home-reference/origin")
    assert [float(home.find(axis).text) for axis in ("latitude", "longitude", "depth")] == pytest.approx(
        [*(math.degrees(angle) for angle in plan.origin), 0.0], abs=1e-8
    )
    assert [each.get("id") for each in root.findall("body/plan")] == ["1_ingress", "2_egress"]
    graphs = root.findall("body/plan/graph")
    for graph, transit in zip(graphs, plan.transits, strict=True):
        sequence = [node.find("maneuver") for node in in_order(graph)]
        rule = transit.surfacing
        for leg, goto, pop_up in zip(transit.sequence, sequence[::2], sequence[1::2], strict=True):
            surfaced = math.ceil(rule.surface_time_p99)
            assert of_manoeuvre(goto, "Goto", plan, leg) == {
                "minTime": 0.0,
                "maxTime": leg.time_out,
                "Goto@kind": "automatic",
                "Goto/trajectoryTolerance/radiusTolerance": transit.arrival_radius,
                **to_the_end(transit, leg, "Goto"),
            }
            assert leg.time_out >= leg.duration_p99
            assert of_manoeuvre(pop_up, "PopUp", plan, leg) == {
                "minTime": 0.0,
                "maxTime": 2 * surfaced + 60,
                "PopUp@kind": "automatic",
                "PopUp/duration": surfaced,
                "PopUp/flags@CurrPos": "true",
                "PopUp/flags@WaitAtSurface": "false",
                **to_the_end(transit, leg, "PopUp"),
            }


def of_manoeuvre(element, kind, plan, leg):
    """What a manoeuvre holds but for its place, which is that of the leg's end."""
    found = {key.removeprefix("maneuver/"): value for key, value in leaves(element).items()}
    place = f"{kind}/finalPoint/point/coordinate"
    assert off(plan, leg, found.pop(f"{place}/latitude"), found.pop(f"{place}/longitude")) < 0.01
    return found


def to_the_end(transit, leg, kind):
    return {
        f"{kind}/finalPoint@type": "pointType",
        f"{kind}/finalPoint/point/id": leg.name,
        f"{kind}/finalPoint/point/name": leg.name,
        f"{kind}/finalPoint/point/coordinate/height": 0.0,
        f"{kind}/finalPoint/point/z": transit.depth,
        f"{kind}/finalPoint/point/zunits": "DEPTH",
        f"{kind}/finalPoint/radiusTolerance": transit.arrival_radius,
        f"{kind}/speed": transit.speed,
        f"{kind}/speed@type": "float",
        f"{kind}/speed@unit": "MPS",
    }


def in_order(graph):
    """Nodes from the one marked as start along the edges, as Neptus's getManeuversSequence goes."""
    nodes = {node.find("id").text: node for node in graph.findall("node")}
    after = {edge.find("source").text: edge.find("target").text for edge in graph.findall("edge")}
    assert {edge.find("guard").text for edge in graph.findall("edge")} == {"ManeuverIsDone"}
    (name,) = (key for key, node in nodes.items() if node.get("start") == "true")
    sequence = [nodes[name]]
    while name in after:
        name = after[name]
        sequence.append(nodes[name])
    assert len(sequence) == len(nodes)
    return sequence


def test_neptus_writes_the_same_bytes_again(plan):
    (content,) = written(plan, "neptus").values()
    assert written(plan, "neptus") == {"trip.nmisz": content}
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert [each.date_time for each in archive.infolist()] == [(1980, 1, 1, 0, 0, 0)]  # as early as ZIP allows


# Iver: lines of the block between START and END, as VectorMap's readers scan them

LINE = re.compile(
    r"(\d+); (-?[\d.]+); (-?[\d.]+); ([\d.]+); ([\d.]+); D([\d.]+) P(\d+) VC1,0,0,1000,0,VC2,0,0,1000,0 S([\d.]+); 0;-1"
)
TIMING = re.compile(r"WP(\d+);Time=([\d.]+);Dist=([\d.]+)")
TOTAL = re.compile(r"Total Time = (\d+):(\d\d):(\d\d);Total Distance = ([\d.]+)")


def block(lines, name):
    first, last = ("START", "END") if name is None else (name, f"END {name.removeprefix('START ')}")
    return lines[lines.index(first) + 1 : lines.index(last)]


def test_iver(plan):
    files = written(plan, "iver")
    assert list(files) == ["trip-1_ingress.mis", "trip-2_egress.mis"]
    for text, transit in zip(files.values(), plan.transits, strict=True):
        assert text.isascii()
        lines = text.split("\r\n")
        stops = [[float(part) for part in LINE.fullmatch(line).groups()] for line in block(lines, None)]
        minutes = {371.4: 7, 131.2: 3, 44.8: 1}[transit.surfacing.surface_time_p99]
        way = (transit.start, *transit.sequence)
        for count, (stop, waypoint) in enumerate(zip(stops, way, strict=True), start=1):
            first, latitude, longitude, distance, heading, depth, park, speed = stop
            assert first == count
            assert off(plan, waypoint, latitude, longitude) < 0.02
            assert speed * 1852.0 / 3600.0 == pytest.approx(transit.speed, abs=0.0003)
            under_way, before = count > 1, way[max(count - 2, 0)]  # to a point that is aimed off the goal
            east, north = waypoint.east - before.east, waypoint.north - before.north
            assert distance == pytest.approx(math.hypot(east, north), abs=0.0005)
            assert depth * 0.3048 == pytest.approx(transit.depth * under_way, abs=0.0016)
            assert cmath.rect(distance, math.radians(heading)) == pytest.approx(complex(north, east), abs=0.2)
            assert park == minutes * under_way
        *timing, total = block(lines, "WP TIMING")
        times = [[float(part) for part in TIMING.fullmatch(line).groups()] for line in timing]
        under = [sum(each.duration for each in way[: n + 1]) for n in range(len(stops))]
        assert [each[0] for each in times] == list(range(1, len(stops) + 1))
        assert [each[1] for each in times] == pytest.approx(
            [t + 60 * minutes * n for n, t in enumerate(under)], abs=0.05
        )
        run = list(accumulate(each[3] for each in stops))
        assert [each[2] for each in times] == pytest.approx(run, abs=0.05)
        hours, rest, seconds, distance = (float(part) for part in TOTAL.fullmatch(total).groups())
        assert 3600.0 * hours + 60.0 * rest + seconds == pytest.approx(times[-1][1], abs=0.55)
        assert distance == pytest.approx(run[-1], abs=0.005)
        (radius,) = block(lines, "START VEHICLE")
        assert float(radius.removeprefix("UVC=WPRadius=")) == min(5.0, transit.arrival_radius)


def test_iver_says_for_how_long_it_parks(plan):
    words = format_named("iver").lost(plan)[0]
    longest = "3 min for 131 s" if plan is PLANS["date line"] else "7 min for 371 s"
    assert words == f"times at the surface but in whole minutes (1 min for 45 s, {longest})"


# QGroundControl: the developer guide's Plan File Format, and the commands of MAVLink's common.xml by pymavlink

PLACE = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
QGC = {
    "type": "object",
    "required": ["fileType", "version", "groundStation", "mission", "geoFence", "rallyPoints"],
    "properties": {
        "fileType": {"const": "Plan"},
        "version": {"const": 1},
        "groundStation": {"const": "QGroundControl"},
        "mission": {
            "type": "object",
            "required": [
                *("version", "firmwareType", "vehicleType", "cruiseSpeed", "hoverSpeed", "plannedHomePosition", "items")
            ],
            "properties": {
                "version": {"const": 2},
                "firmwareType": {"enum": [3, 12]},
                "vehicleType": {"const": 12},
                "globalPlanAltitudeMode": {"const": 1},
                "plannedHomePosition": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
                "items": {
                    "type": "array",
                    "items": {
                        "type": "object",
                        "required": ["type", "autoContinue", "command", "doJumpId", "frame", "params"],
                        "properties": {
                            "type": {"const": "SimpleItem"},
                            "autoContinue": {"const": True},
                            "AltitudeMode": {"const": 1},
                            "params": {
                                "type": "array",
                                "items": {"type": ["number", "null"]},
                                "minItems": 7,
                                "maxItems": 7,
                            },
                        },
                    },
                },
            },
        },
        "geoFence": {
            "type": "object",
            "required": ["version", "circles", "polygons"],
            "properties": {
                "version": {"const": 2},
                "polygons": {
                    "type": "array",
                    "items": {
                        "type": "object",
                        "required": ["version", "inclusion", "polygon"],
                        "properties": {
                            "version": {"const": 1},
                            "inclusion": {"type": "boolean"},
                            "polygon": {"type": "array", "items": PLACE, "minItems": 3},
                        },
                    },
                },
            },
        },
        "rallyPoints": {"type": "object", "required": ["version", "points"], "properties": {"version": {"const": 2}}},
    },
}


def test_qgc(plan):
    files = written(plan, "qgc")
    assert list(files) == [
        f"trip-{name}-{suffix}.plan" for name in ("1_ingress", "2_egress") for suffix in ("ardusub", "px4")
    ]
    for text, transit, firmware in zip(
        files.values(), [each for each in plan.transits for _ in range(2)], [3, 12, 3, 12], strict=True
    ):
        data = json.loads(text)
        jsonschema.validate(data, QGC)
        assert data["mission"]["firmwareType"] == firmware
        *home, height = data["mission"]["plannedHomePosition"]
        assert (off(plan, transit.start, *home) < 0.01, height) == (True, 0)
        speed, *items, jump = data["mission"]["items"]
        assert [each["doJumpId"] for each in data["mission"]["items"]] == list(range(1, len(items) + 3))
        assert (speed["command"], speed["frame"]) == (178, 2)
        assert speed["params"] == [1, transit.speed, -1, 0, 0, 0, 0]
        assert data["mission"]["cruiseSpeed"] == data["mission"]["hoverSpeed"] == transit.speed
        loiter = math.ceil(transit.surfacing.surface_time_p99) + 60
        ends = [*transit.waypoints[1:-1], transit.goal]
        begins = [transit.start, *ends[:-1]]
        radius, down = transit.arrival_radius, -transit.depth
        expected = [
            each
            for begin, end in zip(begins, ends, strict=True)
            for each in (
                (16, begin, [0, radius, 0, None, down]),
                (16, end, [0, radius, 0, None, down]),
                (19, end, [loiter, 0, 0, 0, -0.1]),
            )
        ]
        for item, (command, point, numbers) in zip(items, expected, strict=True):
            *first, latitude, longitude, altitude = item["params"]
            assert (item["command"], item["frame"], [*first, altitude]) == (command, 3, numbers)
            assert item["Altitude"] == altitude
            assert off(plan, point, latitude, longitude) < 0.01
        assert (jump["command"], jump["params"]) == (177, [len(items), 1 + transit.extra_legs, 0, 0, 0, 0, 0])


def test_qgc_sails_no_nearer_the_surface_than_where_it_takes_a_fix(plan):
    depths = {plan.transits[0].name: 0.0, plan.transits[1].name: 0.4}
    phases = (replace(each, depth=depths[each.name]) if each.name in depths else each for each in plan.phases)
    shallow = replace(plan, phases=tuple(phases))
    for text, altitude in zip(written(shallow, "qgc").values(), (-0.1, -0.1, -0.4, -0.4), strict=True):
        _, *items, _ = json.loads(text)["mission"]["items"]
        assert {each["Altitude"] for each in items if each["command"] == 16} == {altitude}


def test_qgc_as_mavlink_messages(plan):
    mavlink = pytest.importorskip("pymavlink.dialects.v20.common")
    commands, frames = mavlink.enums["MAV_CMD"], mavlink.enums["MAV_FRAME"]
    link = mavlink.MAVLink(None)
    for text in written(plan, "qgc").values():
        mission = json.loads(text)["mission"]
        assert mavlink.enums["MAV_TYPE"][mission["vehicleType"]].name == "MAV_TYPE_SUBMARINE"
        names = {3: "MAV_AUTOPILOT_ARDUPILOTMEGA", 12: "MAV_AUTOPILOT_PX4"}
        assert mavlink.enums["MAV_AUTOPILOT"][mission["firmwareType"]].name == names[mission["firmwareType"]]
        for number, item in enumerate(mission["items"]):
            own = [math.nan if each is None else each for each in item["params"]]
            x, y = (round(each * 1e7) for each in own[4:6])
            packed = link.mission_item_int_encode(
                *(1, 1, number, item["frame"], item["command"], 0, item["autoContinue"]), *own[:4], x, y, own[6]
            )
            (back,) = mavlink.MAVLink(None).parse_buffer(packed.pack(link))
            assert commands[back.command].name in {
                "MAV_CMD_NAV_WAYPOINT", "MAV_CMD_NAV_LOITER_TIME", "MAV_CMD_DO_JUMP", "MAV_CMD_DO_CHANGE_SPEED"
            }  # fmt: skip
            placed = commands[back.command].name.startswith("MAV_CMD_NAV")
            assert frames[back.frame].name == ("MAV_FRAME_GLOBAL_RELATIVE_ALT" if placed else "MAV_FRAME_MISSION")
            assert (back.x, back.y) == (x, y)
            assert back.z == pytest.approx(own[6], abs=1e-6)
            assert not placed or back.z < 0.0


def test_zones_kept_out_of_are_fences(plan):
    corners = tuple(on_earth(plan.origin, east, north) for east, north in ((10.0, 20.0), (400.0, 30.0), (90.0, 500.0)))
    fenced = replace(plan, fences=(Fence("range", corners, above=5.0), Fence("shore", corners)))
    data = json.loads(written(fenced, "qgc")["trip-1_ingress-px4.plan"])
    jsonschema.validate(data, QGC)
    for polygon in data["geoFence"]["polygons"]:
        assert polygon["inclusion"] is False
        assert polygon["polygon"] == [[pytest.approx(math.degrees(each), abs=1e-8) for each in c] for c in corners]
    assert any("(range)" in words for words in format_named("qgc").lost(fenced))


# what all of them say of themselves


@pytest.mark.parametrize("name", FORMATS)
def test_every_file_names_its_plan_and_what_it_lacks(plan, name):
    plan = as_it_can(plan, name)
    for content in written(plan, name).values():
        text = unpacked(content)
        assert plan.digest in text
        assert plan.version in text
        for words in format_named(name).lost(plan):
            assert words.split(",")[0].split("(")[0].split("±")[0][:40] in text


@pytest.mark.parametrize("name", ["slocum", "neptus", "iver", "qgc"])
def test_a_mooring_that_a_file_cannot_hold_is_said_with_its_numbers(plan, name):
    words = (
        "the mooring moor (release 10.7 s after the fix on arrival, by 18.9 s in 99 % of cases; hold 1807 s; "
        "galvanic release 5431 s; line 3.08 m)"
    )
    assert all(words in unpacked(content) for content in written(as_it_can(plan, name), name).values())


@pytest.mark.parametrize("name", ["slocum", "moos", "gpx", "geojson", "kml"])
def test_the_interval_in_place_of_a_table_and_its_cost_are_in_the_header(name):
    plan = as_it_can(PLANS["date line"], name)
    text = unpacked(next(iter(written(plan, name).values())))
    said = re.search(r"of ingress; in its place .* costs least, (\d+) m, at (\S+) (?:\+-|±) (\S+) minutes more", text)
    assert [float(each) for each in said.groups()] == [1333.0, 1.69, 0.23]


@pytest.mark.parametrize("name", ["csv", "slocum", "moos", "gpx", "geojson", "kml", "gpkg"])
def test_no_table_is_missed_where_there_is_none(name):
    assert not any("table of legs" in words for words in format_named(name).lost(PLANS["west"]))
    assert sum("table of legs" in words for words in format_named(name).lost(PLANS["date line"])) == 1


def test_a_cost_that_is_not_known_is_said_so():
    there, *others = PLANS["date line"].phases
    unknown = replace(there, surfacing=replace(there.surfacing, extra_time=math.nan, extra_time_error=math.nan))
    (words,) = (
        each for each in format_named("gpx").lost(replace(PLANS["west"], phases=(unknown, *others))) if "table" in each
    )
    assert words.endswith("in its place the interval of its longest leg, 1333 m, whose cost is not known")


def unpacked(content):
    if isinstance(content, str):
        return content.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&").replace("\\n", "\n")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return unpacked(archive.read("mission.nmis").decode())


def test_a_glider_has_no_numbers_for_more_than_twenty_transits(plan):
    plan = for_a_glider(plan)
    transits = plan.transits[:1]
    assert len(written(replace(plan, phases=transits * 20), "slocum")) == 100
    with pytest.raises(InputError, match="21 lists"):
        written(replace(plan, phases=transits * 21), "slocum")


def test_a_glider_gets_more_than_eight_points_as_missions_one_after_the_other(plan):
    """Each list within masterdata's eight, all points in their order, a surfacing at each; the last ends the mission."""
    there, *others = for_a_glider(plan).phases
    start, *_, goal = there.waypoints
    points = []
    for n in range(1, 17):
        east, north = 90.0 * n, -40.0 * n
        latitude, longitude = on_earth(plan.origin, east, north)
        placed = replace(goal, east=east, north=north, latitude=latitude, longitude=longitude)
        points.append(replace(placed, name=f"by {n}", is_via=True))
    way = replace(there, waypoints=(start, *points, goal), aim=None)
    texts = written(replace(plan, phases=(way, *others), has_thruster=True), "slocum")
    assert [name for name in texts if name.endswith(".mi")] == [f"plan{n}.mi" for n in (10, 11, 12, 13)]
    listed = [read_ma(texts[f"goto_l{n}.ma"]) for n in (10, 11, 12)]
    assert [len(places) for _, _, places in listed] == [8, 8, 1]
    assert [arguments["num_waypoints", "nodim"] for _, arguments, _ in listed] == [8, 8, 1]
    places = [place for *_, each in listed for place in each]
    for point, (longitude, latitude) in zip([*points, goal], places, strict=True):
        assert off(plan, point, decimal(latitude), decimal(longitude)) < 0.2
    for number in (10, 11):
        assert ("surface", {"args_from_file": number + 40}) in read_mi(texts[f"plan{number}.mi"])
        assert read_ma(texts[f"surfac{number + 40}.ma"])[1]["start_when", "enum"] == 8
    assert "surfac52.ma" not in texts


def test_a_glider_is_not_let_up_sooner_than_masterdata_has_it(plan):
    there, *others = for_a_glider(plan).phases
    short = replace(there, surfacing=replace(there.surfacing, interval=100.0, interval_time=120.0))
    with pytest.raises(InputError, match=r"surface 109 s after it dived, for legs of 100 m .* after 120 s"):
        written(replace(for_a_glider(plan), phases=(short, *others)), "slocum")


@pytest.mark.parametrize("name", ["slocum", "moos", "neptus", "iver", "qgc"])
def test_what_becomes_of_the_guard_for_the_battery_is_in_every_file(plan, name):
    guarded = replace(as_it_can(plan, name), capacity=71.25)
    assert all("the guard for the battery of 71.25 W h: " in unpacked(each) for each in written(guarded, name).values())
    assert "guard for the battery" not in " ".join(format_named(name).lost(as_it_can(plan, name)))
    if name == "moos":
        _, found = read_bhv(written(guarded, name)["trip.bhv"])
        for stage in ("1_ingress", "3_egress"):
            conditions = [f"STAGE = {stage}", "ENERGY_USED > 71.25"]
            assert found[f"battery_{stage}"] == ("Timer", conditions, aborted("BATTERY"), timer(0.0))


@pytest.mark.parametrize("name", ["moos", "neptus", "iver"])
def test_no_correction_is_missed_where_the_mission_makes_none(plan, name):
    said = [" ".join(format_named(name).lost(replace(plan, corrects=made))) for made in (True, False)]
    assert ["correction of the course" in words for words in said] == [True, False]


@pytest.mark.parametrize(("radius", "metres"), [(0.4, 1), (2.7, 2), (4.99, 4), (38.5, 5)])
def test_an_iver_turns_within_whole_metres_of_the_radius_and_five_at_most(radius, metres):
    there, *others = PLANS["west"].phases
    near = replace(PLANS["west"], phases=(replace(there, arrival_radius=radius), *others))
    lines = written(near, "iver")["trip-1_ingress.mis"].split("\r\n")
    assert block(lines, "START VEHICLE") == [f"UVC=WPRadius={metres}"]


def test_how_far_a_helm_aims_off_is_said_of_the_transits_that_do():
    """By (7.25, -3.5) m off the goal in one, and at the goal in the other."""
    said = " ".join(format_named("moos").lost(PLANS["west"]))
    assert "ingress aims 8.1 m off" in said
    assert "egress aims" not in said


@pytest.mark.parametrize(("depth", "goes_up_early"), [(0.5, False), (0.6, False), (0.7, True), (1.1, True)])
def test_a_helm_goes_up_early_only_where_it_has_been_down(depth, goes_up_early):
    there, *others = PLANS["west"].phases
    plan = replace(PLANS["west"], phases=(replace(there, depth=depth), *others))
    _, found = read_bhv(written(plan, "moos")["trip.bhv"])
    assert ("early_1_ingress_leg" in found) == goes_up_early
    if goes_up_early:
        assert f"NAV_DEPTH > {0.5 * depth:.2f}" in found["early_1_ingress_leg"][1]


def test_a_glider_far_below_begins_to_climb_half_a_leg_before_its_end():
    """300 m at 26° are 615 m; of a leg of 411.7 m half is the most that may be the climb."""
    deep = replace(PLANS["west"].transits[0], depth=300.0)
    assert slocum._interval(deep) == math.floor(317.6 - 0.5 * 411.7 / 1.313)
