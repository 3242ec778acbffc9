"""What a vehicle does with its file by `simulate --as-exported` is what the file itself says, number by number."""

import io
import json
import math
import re
import xml.etree.ElementTree as ElementTree
import zipfile

import numpy as np
import pytest
from made_plans import PLANS, metres_apart
from test_vehicle_files import LINE, block, decimal, for_a_glider, in_order, read_bhv, read_ma, read_mi, written

from missionplan.exporters import FORMATS, VEHICLES, execution_of


@pytest.fixture(params=PLANS)
def plan(request):
    return PLANS[request.param]


def together(plan, points, places):
    """Whether points of the plane, shape (2, m), are those of a file, pairs of latitude and longitude [deg]."""
    assert np.shape(points) == (2, len(places))
    return all(
        metres_apart(plan.origin, *point, *place) < 0.2
        for point, place in zip(np.transpose(points), places, strict=True)
    )


def test_formats_of_vehicles_alone_are_carried_out():
    assert {name for name in FORMATS if execution_of(name) is not None} == set(VEHICLES)


def test_slocum(plan):
    plan = for_a_glider(plan)
    texts = written(plan, "slocum")
    for number, transit in zip((10, 11), plan.transits, strict=True):
        does = execution_of("slocum")(transit)
        _, goto, [(longitude, latitude)] = read_ma(texts[f"goto_l{number}.ma"])
        surfacing = read_ma(texts[f"surfac{number}.ma"])[1]
        abend = dict(read_mi(texts[f"plan{number}.mi"]))["abend"]
        assert together(plan, does.aim[:, None], [(decimal(latitude), decimal(longitude))])
        assert does.capture == goto["list_when_wpt_dist", "m"]
        assert does.fix_wait == surfacing["gps_wait_time", "sec"]
        assert does.key_wait == surfacing["keystroke_wait_time", "sec"]
        assert (does.time_out, 100.0 * does.reserve) == (abend["overtime"], abend["remaining_charge_min"])
        assert does.interval == transit.surfacing.interval
        assert (does.ends, does.corrects, does.aborts, does.holds) == ("reckoning", True, False, False)
        assert (does.points, does.surface_time) == (None, None)


def test_moos(plan):
    (text,) = written(plan, "moos").values()
    _, found = read_bhv(text)
    for transit, name in zip(plan.transits, ("1_ingress", "3_egress"), strict=True):
        does = execution_of("moos")(transit)
        x, y = (float(part) for part in found[f"waypoint_{name}_leg"][3]["points"].split(","))
        assert does.aim == pytest.approx([x, y], abs=30.0)  # its grid is turned by the meridians' convergence
        assert np.hypot(*does.aim) == pytest.approx(math.hypot(x, y), rel=2e-3)
        assert (found[f"no_fix_{name}_fix"][3]["duration"], found[f"time_out_{name}"][3]["duration"]) == pytest.approx(
            (does.fix_wait, does.time_out), abs=0.051
        )
        assert does.interval == transit.surfacing.interval
        assert (does.ends, does.aborts, does.corrects, does.holds) == ("fix", True, False, False)
        assert (does.points, does.surface_time, does.key_wait, does.capture, does.reserve) == (
            None,
            None,
            0.0,
            0.0,
            0.0,
        )


def test_neptus(plan):
    ((_, content),) = written(plan, "neptus").items()
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        graphs = ElementTree.fromstring(archive.read("mission.nmis")).findall("body/plan/graph")
    for graph, transit in zip(graphs, plan.transits, strict=True):
        does = execution_of("neptus")(transit)
        coordinates = [node.find("maneuver//coordinate") for node in in_order(graph)[::2]]
        places = [[float(each.find(axis).text) for axis in ("latitude", "longitude")] for each in coordinates]
        assert together(plan, does.points, places)
        assert together(plan, does.aim[:, None], places[-1:])
        assert (does.ends, does.surface_time, does.capture) == ("count", None, 0.0)
        assert (does.aborts, does.corrects, does.holds) == (False, False, False)


def test_iver(plan):
    for text, transit in zip(written(plan, "iver").values(), plan.transits, strict=True):
        does = execution_of("iver")(transit)
        lines = text.split("\r\n")
        _, *stops = [[float(part) for part in LINE.fullmatch(line).groups()] for line in block(lines, None)]
        places = [stop[1:3] for stop in stops]
        assert together(plan, does.points, places)
        assert together(plan, does.aim[:, None], places[-1:])
        assert {60.0 * stop[6] for stop in stops} == {does.surface_time}
        assert float(re.search(r"WPRadius=(\S+)", text)[1]) == does.capture
        assert (does.ends, does.aborts, does.corrects, does.holds) == ("count", False, False, False)


def test_qgc(plan):
    texts = list(written(plan, "qgc").values())[::2]
    for text, transit in zip(texts, plan.transits, strict=True):
        does = execution_of("qgc")(transit)
        _, *items, jump = json.loads(text)["mission"]["items"]
        ends = [item["params"] for item in items if item["command"] == 19]
        places = [end[4:6] for end in ends] + [ends[-1][4:6]] * jump["params"][1]
        assert together(plan, does.points, places)
        assert together(plan, does.aim[:, None], places[-1:])
        assert {end[0] for end in ends} == {does.surface_time}
        assert (does.ends, does.holds, does.aborts, does.corrects) == ("count", True, False, False)
