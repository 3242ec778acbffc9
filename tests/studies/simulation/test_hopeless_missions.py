"""Missions whose keys are possible one by one, and which no sober engineer would send to sea."""

import re
from pathlib import Path

import pytest
from simulate_missions import chesapeake

from missionplan.report.simulation.page import answer
from missionplan.studies.simulation.simulate import simulate

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")

PAGE = Path(__file__).parents[2] / "mission" / "what_cannot_be.md"
IN, MOOR, OUT = "phases.0.transit", "phases.1.moor", "phases.2.transit"


def current(speed):
    return [{"down_to": "40 ft", "speed": speed, "toward": "60 deg"}]


def speeds(value):
    return {f"{IN}.speed": value, f"{OUT}.speed": value}


HOPELESS = {
    "current of 1 m/s, vehicle of 0.5 m/s": {"site.current": current("1 m/s"), **speeds("0.5 m/s")},
    "current of 0.3 ± 0.1 m/s, vehicle of 0.35 m/s": {
        "site.current": current({"mean": "0.3 m/s", "sd": "0.1 m/s"}),
        **speeds("0.35 m/s"),
    },
    "fixes of ± 300 m, arrival within 15 m": {"navigation.fix_error": "300 m"},
    "a battery of 1 W h": {"vehicle.energy.capacity": "1 W*h"},
    "release 29 minutes after the fix, in a current": {f"{MOOR}.release_time": "29 min"},
    "line of 10.5 ± 1 m in 12.2 m of water": {f"{MOOR}.line_length": {"mean": "10.5 m", "sd": "1 m"}},
    "offset of at most 0.1 m required": {
        "requirements": [{"quantity": "moor.offset", "at_most": "0.1 m", "probability": 0.9}]
    },
    "the whole mission within a minute required": {
        "requirements": [{"quantity": "total.duration", "at_most": "1 min", "probability": 0.9}]
    },
    "two legs at most": {"navigation.max_legs": 2, f"{IN}.d_max": "1600 m", f"{OUT}.d_max": "1600 m"},
    "galvanic release after 40 days": {f"{MOOR}.galvanic_release": "40 day"},
    "an anchor of 0.9 N for a buoyancy of 0.89 N": {f"{MOOR}.anchor_wet_weight": "0.9 N"},
    "a radius of 0.1 m": {f"{MOOR}.radius": "0.1 m"},
    "P(success) = 1 required": {"requirements": [{"quantity": "total.success", "probability": 1.0}]},
}


LONG = (  # vehicles that go on for all legs that are allowed, and anchors that hardly sink
    "current of 1 m/s, vehicle of 0.5 m/s",
    "current of 0.3 ± 0.1 m/s, vehicle of 0.35 m/s",
    "fixes of ± 300 m, arrival within 15 m",
    "an anchor of 0.9 N for a buoyancy of 0.89 N",
)


@pytest.mark.parametrize(
    "what", [pytest.param(each, marks=[pytest.mark.slow] if each in LONG else []) for each in HOPELESS]
)
def test_no_hopeless_mission_is_said_to_work(what, tmp_path):
    row = next(line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith(f"| {what} |"))
    said = answer(simulate(chesapeake(tmp_path, HOPELESS[what]), trials=200, sheet=False))
    assert not said.startswith("This mission works:")
    quoted = re.search(r"`simulate`: “([^”…]*)", row)
    assert quoted is None or quoted.group(1).rstrip(" ;") in said
