"""Files for vehicles, read back by the grammar of each format: places, depth, speed, surfacings."""

import io
import math
import re
import xml.etree.ElementTree as ElementTree
import zipfile

import pytest
from hypothesis import given
from hypothesis import strategies as st
from planned_missions import all_plans, by_table, metres_apart
from pyproj import Transformer

from missionplan.errors import InputError
from missionplan.exporters.formats import format_named
from missionplan.exporters.vehicles.moos import utm_zone
from missionplan.exporters.vehicles.slocum import degrees_minutes
from missionplan.mission import Mission
from missionplan.studies.mission_plan.build import mission_plan


@pytest.fixture(scope="module")
def plans(tmp_path_factory):
    return all_plans(tmp_path_factory.mktemp("starter"))


@pytest.fixture(params=["chesapeake", "starter", "table"])
def plan(plans, request):
    return plans[request.param]


def written(plan, name):
    return format_named(name).files(plan, "trip")


# Slocum: `b_arg: name(unit) value  # comment` between <start:b_arg> and <end:b_arg>, the same for waypoints


def read_ma(text):
    assert text.isascii()
    lines = [line.split("#")[0].strip() for line in text.splitlines()]
    lines = [line for line in lines if line]
    behaviour = re.fullmatch(r"behavior_name=(\w+)", lines[0])[1]
    first, last = lines.index("<start:b_arg>"), lines.index("<end:b_arg>")
    arguments = {}
    for line in lines[first + 1 : last]:
        name, value = re.fullmatch(r"b_arg:\s*(\w+)\(\w+\)\s+(-?[\d.]+)", line).groups()
        arguments[name] = float(value)
    points = []
    if "<start:waypoints>" in lines:
        body = lines[lines.index("<start:waypoints>") + 1 : lines.index("<end:waypoints>")]
        points = [tuple(float(part) for part in line.split()) for line in body]
    return behaviour, arguments, points


def decimal(number):
    """DDMM.mmmm to degrees."""
    degrees = math.trunc(number / 100.0)
    return degrees + (number - 100.0 * degrees) / 60.0


def test_slocum(plan):
    found = {name: read_ma(text) for name, text in written(plan, "slocum").items()}
    for index, transit in enumerate(plan.transits):
        behaviour, arguments, points = found[f"goto_l{10 + index}.ma"]
        assert behaviour == "goto_list"
        assert arguments["num_waypoints"] == len(points) == 1
        assert arguments["list_when_wpt_dist"] == transit.arrival_radius
        longitude, latitude = (decimal(number) for number in points[0])
        assert metres_apart(plan, transit.goal, latitude, longitude) < 1.0
        behaviour, arguments, _ = found[f"surfac{10 + index}.ma"]
        assert (behaviour, arguments["start_when"]) == ("surface", 9)
        assert arguments["when_secs"] == pytest.approx(transit.surfacing.interval / transit.speed, abs=0.5)
        assert arguments["keystroke_wait_time"] == math.ceil(transit.surfacing.surface_time)
        behaviour, arguments, _ = found[f"surfac{30 + index}.ma"]
        assert (behaviour, arguments["start_when"]) == ("surface", 8)
        behaviour, arguments, _ = found[f"yo{10 + index}.ma"]
        assert arguments["d_target_depth"] == arguments["c_target_depth"] == pytest.approx(transit.depth, abs=0.005)


@given(st.floats(-math.pi, math.pi))
def test_degrees_and_minutes_come_back(angle):
    text = degrees_minutes(angle)
    minutes = float(text.lstrip("-")) % 100.0
    assert 0.0 <= minutes < 60.0
    assert decimal(float(text)) == pytest.approx(math.degrees(angle), abs=0.51e-4 / 60.0)


def test_minutes_that_round_up_to_sixty_are_a_degree():
    assert degrees_minutes(math.radians(-(36 + 59.99999 / 60.0))) == "-3700.0000"
    assert degrees_minutes(math.radians(-0.5)) == "-030.0000"


# MOOS-IvP: `Behavior = KIND`, then `key = value` lines in braces


def read_bhv(text):
    assert text.isascii()
    lines = [line.split("//")[0].strip() for line in text.splitlines()]
    body = "\n".join(line for line in lines if line)
    behaviours = []
    for kind, inner in re.findall(r"^Behavior = (\w+)\n\{\n(.*?)\n\}$", body, re.S | re.M):
        pairs = [tuple(part.strip() for part in line.split("=", 1)) for line in inner.splitlines()]
        behaviours.append((kind, pairs))
    rest = re.sub(r"^Behavior = \w+\n\{\n.*?\n\}$", "", body, flags=re.S | re.M)
    rest = re.sub(r"^set MODE = \w+ \{\n.*?\n\} \w+$", "", rest, flags=re.S | re.M)
    initial = dict(re.fullmatch(r"initialize (\w+) = (\w+)", line).groups() for line in rest.splitlines() if line)
    return initial, behaviours


KEYS = {
    "BHV_Waypoint": {"speed", "capture_radius", "slip_radius", "points", "repeat"},
    "BHV_ConstantDepth": {"depth"},
    "BHV_ConstantSpeed": {"speed"},
    "BHV_PeriodicSurface": {
        *("period", "mark_variable", "zero_speed_depth", "max_time_at_surface", "ascent_speed", "ascent_grade"),
    },
    "BHV_Timer": set(),
}
COMMON = {"name", "pwt", "condition", "endflag", "duration"}


def test_moos(plan):
    (text,) = written(plan, "moos").values()
    initial, behaviours = read_bhv(text)
    assert initial["DEPLOY"] == "false"
    names = [dict(pairs)["name"] for _, pairs in behaviours]
    assert len(set(names)) == len(names)
    for kind, pairs in behaviours:
        assert {key for key, _ in pairs} - COMMON <= KEYS[kind]
    latitude, longitude = (float(re.search(rf"{key} *= (\S+)", text)[1]) for key in ("LatOrigin", "LongOrigin"))
    zone = 32700 + 60 if latitude < 0.0 else 32600 + 18
    to_utm = Transformer.from_crs(4326, zone, always_xy=True)
    origin = to_utm.transform(longitude, latitude)
    waypoints = [dict(pairs) for kind, pairs in behaviours if kind == "BHV_Waypoint"]
    depths = [dict(pairs) for kind, pairs in behaviours if kind == "BHV_ConstantDepth"]
    surfacings = [dict(pairs) for kind, pairs in behaviours if kind == "BHV_PeriodicSurface"]
    assert len(waypoints) == len(surfacings) == len(plan.transits)
    for transit, waypoint, surfacing in zip(plan.transits, waypoints, surfacings, strict=True):
        x, y = (float(part) for part in waypoint["points"].split(","))
        lon, lat = to_utm.transform(origin[0] + x, origin[1] + y, direction="INVERSE")
        assert metres_apart(plan, transit.goal, lat, lon) < 1.0
        assert float(waypoint["speed"]) == pytest.approx(transit.speed, rel=1e-3)
        assert float(surfacing["period"]) == pytest.approx(transit.surfacing.interval / transit.speed, abs=0.05)
        assert float(surfacing["max_time_at_surface"]) == math.ceil(transit.surfacing.surface_time)
        (depth,) = (each for each in depths if each["condition"] == waypoint["condition"])
        assert float(depth["depth"]) == pytest.approx(transit.depth, abs=0.005)


def test_moos_goes_through_the_phases_in_order(plans):
    """From the initial phase, by the end flags, past the release of the anchor, to the end."""
    initial, behaviours = read_bhv(written(plans["chesapeake"], "moos")["trip.bhv"])
    phase, seen, timers = initial["PHASE"], [], {}
    for _ in range(10):
        active = [pairs for _, pairs in behaviours if ("condition", f"PHASE = {phase}") in pairs]
        seen.append(phase)
        following = [
            value for pairs in active for key, value in pairs if key == "endflag" and value.startswith("PHASE")
        ]
        for pairs in active:
            for key, value in pairs:
                if key == "endflag":
                    timers[value] = dict(pairs)["duration"]
        if not following:
            break
        phase = following[0].split("=")[1].strip()
    assert seen == ["1_ingress", "2_moor", "hold_2_moor", "3_egress", "done"]
    assert float(timers["ANCHOR_RELEASE = true"]) == pytest.approx(10.0, abs=0.1)
    assert float(timers["GALVANIC_RELEASE = true"]) == pytest.approx(1800.0)


def test_moos_without_an_origin_has_the_mission_s_own_plane():
    data = {key: value for key, value in by_table().raw.items() if key != "site"}
    plan = mission_plan(Mission.from_data(data))
    _, behaviours = read_bhv(written(plan, "moos")["trip.bhv"])
    assert dict(behaviours[0][1])["points"] == "6000.00,4000.00"


@pytest.mark.parametrize(
    ("latitude", "longitude", "zone"),
    [(37.25, -76.38, 18), (60.0, 5.0, 32), (60.0, 2.0, 31), (78.0, 15.0, 33), (78.0, 8.0, 31), (0.0, 180.0, 1)],
)
def test_utm_zones(latitude, longitude, zone):
    assert utm_zone(latitude, longitude) == zone


# Neptus: the elements that MissionType, PlanType, GraphType, Goto and PopUp of its sources read


def test_neptus(plan):
    ((name, content),) = written(plan, "neptus").items()
    assert name == "trip.nmisz"
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        root = ElementTree.fromstring(archive.read("mission.nmis"))
    assert root.tag == "mission-def"
    for path in ("header/id", "header/name", "header/type", "definitions/home-reference/origin/latitude"):
        assert root.find(path).text
    graphs = root.findall("body/plan/graph")
    assert len(graphs) == len(plan.transits)
    for graph, transit in zip(graphs, plan.transits, strict=True):
        sequence = [node.find("maneuver") for node in in_order(graph)]
        assert len(sequence) == 2 * len(transit.legs)
        for leg, goto, pop_up in zip(transit.legs, sequence[::2], sequence[1::2], strict=True):
            point = goto.find("Goto/finalPoint/point")
            place = [float(point.find(f"coordinate/{axis}").text) for axis in ("latitude", "longitude")]
            assert metres_apart(plan, leg, *place) < 1.0
            assert point.find("zunits").text == "DEPTH"
            assert float(point.find("z").text) == pytest.approx(transit.depth, abs=0.005)
            speed = goto.find("Goto/speed")
            assert (float(speed.text), speed.get("unit")) == (pytest.approx(transit.speed, rel=1e-3), "MPS")
            assert int(goto.find("maxTime").text) == leg.time_out >= leg.duration_p99
            assert int(pop_up.find("PopUp/duration").text) == round(transit.surfacing.surface_time)
            assert pop_up.find("PopUp/flags").attrib == {"CurrPos": "true", "WaitAtSurface": "true"}


def in_order(graph):
    """Nodes from the one marked as start along the edges, as Neptus's getManeuversSequence goes."""
    nodes = {node.find("id").text: node for node in graph.findall("node")}
    after = {edge.find("source").text: edge.find("target").text for edge in graph.findall("edge")}
    (name,) = (key for key, node in nodes.items() if node.get("start") == "true")
    sequence = [nodes[name]]
    while name in after:
        name = after[name]
        sequence.append(nodes[name])
    assert len(sequence) == len(nodes)
    return sequence


def test_neptus_writes_the_same_bytes_again(plan):
    assert written(plan, "neptus") == written(plan, "neptus")


# Iver: lines of the block between START and END, as VectorMap's readers scan them

LINE = re.compile(
    r"(\d+); (-?[\d.]+); (-?[\d.]+); ([\d.]+); ([\d.]+); D([\d.]+) P(\d+) VC1,0,0,1000,0,VC2,0,0,1000,0 S([\d.]+); 0;-1"
)


def test_iver(plan):
    files = written(plan, "iver")
    assert len(files) == len(plan.transits)
    for text, transit in zip(files.values(), plan.transits, strict=True):
        assert text.isascii()
        lines = text.split("\r\n")
        body = lines[lines.index("START") + 1 : lines.index("END")]
        stops = [[float(part) for part in LINE.fullmatch(line).groups()] for line in body]
        assert [stop[0] for stop in stops] == list(range(1, len(transit.waypoints) + 1))
        for stop, waypoint in zip(stops, transit.waypoints, strict=True):
            _, latitude, longitude, distance, heading, depth, park, speed = stop
            assert metres_apart(plan, waypoint, latitude, longitude) < 1.0
            assert speed * 1852.0 / 3600.0 == pytest.approx(transit.speed, rel=1e-3)
            assert distance == pytest.approx(waypoint.length, abs=1e-3)
            if waypoint.kind != "start":
                assert depth * 0.3048 == pytest.approx(transit.depth, abs=0.005)
                assert heading == pytest.approx(math.degrees(waypoint.course), abs=0.01)
                assert park * 60.0 == pytest.approx(transit.surfacing.surface_time, abs=30.0)


@pytest.mark.parametrize("name", ["csv", "gpx", "geojson", "kml", "slocum", "moos", "neptus", "iver"])
def test_every_file_names_its_plan_and_what_it_lacks(plan, name):
    for content in written(plan, name).values():
        text = unpacked(content)
        assert plan.digest in text
        for words in format_named(name).lost(plan):
            assert words.split(",")[0].split("(")[0].split("±")[0][:40] in text


@pytest.mark.parametrize("name", ["slocum", "moos"])
def test_the_interval_in_place_of_a_table_and_its_cost_are_in_the_header(plans, name):
    plan = plans["table"]
    rule = plan.transits[0].surfacing
    text = next(iter(written(plan, name).values()))
    said = re.search(r"costs least, (\d+) m, at (-?[\d.]+) \+- ([\d.]+) minutes more", text)
    assert float(said[1]) == pytest.approx(rule.interval, abs=0.5)
    assert float(said[2]) == pytest.approx(rule.extra_time / 60.0, abs=0.005)


def unpacked(content):
    if isinstance(content, str):
        return content.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&").replace("\\n", "\n")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return unpacked(archive.read("mission.nmis").decode())


def test_a_glider_has_no_numbers_for_more_than_twenty_transits(plans):
    plan = plans["table"]
    many = type(plan)(**{**vars(plan), "phases": plan.phases * 21})
    with pytest.raises(InputError, match="21 transits"):
        written(many, "slocum")
