"""Missions that cannot be, or that hold a wrong unit: what is said of each."""

import copy
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from missionplan.errors import InputError
from missionplan.mission import Mission, load
from missionplan.mission.checks.relations import _cover, _layers

MISSIONS = Path(__file__).parents[2] / "missions"
IN, MOOR, OUT = "phases.0.transit.", "phases.1.moor.", "phases.2.transit."

IMPOSSIBLE = [
    (
        {MOOR + "line_length": "50 m"},
        r"moor\.line_length: 50 m of line and 1\.118 m of vehicle are longer than the water",
    ),
    ({MOOR + "line_length": "11.5 m"}, "longer than the water is deep, 12.19 m"),
    ({MOOR + "line_length": {"mean": "13 m", "sd": "1 m"}}, "longer than the water is deep"),
    ({IN + "depth": "80 m"}, "80 m runs aground: the site is 12.19 m deep"),
    ({OUT + "depth": "40 ft"}, "runs aground"),
    ({IN + "to": ["6000 km", "0 m"]}, "6000 km from the origin; expected at most 500 km"),
    ({IN + "from": ["0 m", "-501 km"]}, "501 km from the origin"),
    ({OUT + "to": {"latitude": "52 deg", "longitude": "4 deg"}}, "km from the origin"),
    ({IN + "speed": "15 m/s"}, "15 m/s is impossible: expected at most 10 m/s"),
    ({IN + "speed": {"low": "1 m/s", "high": "30 m/s"}}, "is impossible: expected at most 10 m/s"),
    ({IN + "d_max": "0.5 m"}, "0.5 m is impossible: expected at least 1 m"),
    ({IN + "d_max": "10 m"}, "10 m is less than the arrival radius, 15 m"),
    ({IN + "d_max": "35 km", IN + "arrival_radius": "1500 km"}, "is impossible: expected at least 0.01 m and at most"),
    ({IN + "to": ["10 m", "0 m"]}, "lies 10 m from the start, within the arrival radius, 15 m"),
    ({OUT + "to": ["1600 m", "5 m"]}, "lies 5 m from the start, within the arrival radius"),
    ({IN + "to": ["400 km", "0 m"]}, "take at least 572 legs, even with the current; navigation.max_legs is 400"),
    ({IN + "to": ["280.02 km", "0 m"]}, "take at least 401 legs, even with the current"),  # 400 of 700 m, and 15 m
    ({MOOR + "line_diameter": "0 m"}, "line_diameter: missing; what a line of this material weighs"),
    (
        {MOOR + "line_floats": [{"distance": "3 m", "buoyancy": "2 N"}, {"distance": "2 m", "buoyancy": "2 N"}]},
        r"line_floats\[1\]\.distance: 2 m; expected 3 m to the line's length, 5 m",
    ),
    ({MOOR + "line_floats": [{"distance": "5.1 m", "buoyancy": "2 N"}]}, "5.1 m; expected 0 m to the line's length"),
    ({"site.depth": "12 km"}, "12.000 m is impossible"),
    ({"site.depth": "4 cm"}, "0.04 m is impossible"),
    ({"site.current.0.speed": "15 m/s"}, "15 m/s is impossible: .*Saltstraumen"),
    ({"site.current.0.speed": {"mean": "0.4 m/s", "sd": "8 m/s"}}, "is impossible"),
    ({"site.current.0.down_to": "15 m", "site.current.1.down_to": "20 m"}, "begins at 15 m, below the seafloor"),
    ({"navigation.velocity_error.sigma": "35 m/s"}, "35 m/s is impossible"),
    ({"navigation.velocity_error.mean": ["20 m/s", "0 m/s"]}, "20 m/s is impossible"),
    ({"navigation.surfacing_time": "90 h"}, "is impossible: expected at most 86.400 s"),
    ({"navigation.fix_error": "30 km"}, "is impossible"),
    ({MOOR + "radius": "75 km"}, "is impossible"),
    ({MOOR + "hold": "20 yr"}, "is impossible"),
    ({MOOR + "galvanic_release": "2 yr"}, "is impossible"),
    ({MOOR + "release_time": "10 day"}, "is impossible"),
    ({MOOR + "anchor_wet_weight": "0.5 N"}, "0.5 N cannot sink a vehicle of 0.8896 N net buoyancy"),
    ({MOOR + "anchor_wet_weight": "500 kN"}, "is impossible"),
    (
        {"vehicle.anchor.flooded_mass": "1 kg"},
        r"flooded_mass, 1 kg, weighs in water \(of lead it would weigh 8\.94 N\)",
    ),
    ({"vehicle.net_buoyancy": "200 lbf"}, "% of the vehicle's weight; expected at most 50 %"),
    ({"vehicle.mass": "10.2 g"}, "it cannot float in this hull"),
    ({"vehicle.mass": "500 kg"}, "it cannot float in this hull"),
    ({"vehicle.hull.length": "44 mm"}, "is impossible"),
    ({"vehicle.hull.diameter": "4.75 ft"}, "more than the hull's length"),
    ({"vehicle.sail.thickness": "6 in"}, "more than the sail's chord"),
    ({"vehicle.anchor.construction.trim.density": "850 kg/m^3"}, "850 kg/m.* is impossible: .*lighter than water"),
    ({"vehicle.anchor.overlap_volume": "5 L"}, "more than the whole nose that it is a part of"),
    ({"vehicle.anchor.drag_coefficient": 200}, "200 is impossible"),
    ({"vehicle.energy.capacity": "60 GW*h"}, "is impossible"),
    ({"vehicle.energy.hotel": "8 MW"}, "is impossible"),
    ({"vehicle.anchor.construction.front.density": "7.85 kg/m^3"}, "is impossible"),
]

UNUSUAL = [
    ({IN + "speed": "5 m/s"}, r"phases\[0\]\.transit\.speed: 5 m/s is unusual: .* Is the unit right\?"),
    ({IN + "speed": "0.1 m/s"}, "0.1 m/s is unusual"),
    ({"navigation.velocity_error.sigma": "1 m/s"}, "1 m/s is unusual"),
    ({"navigation.fix_error": "300 m"}, "arriving is a matter of chance"),
    ({"navigation.surfacing_time": "90 min"}, "5400 s is unusual"),
    ({MOOR + "hold": "120 day"}, "is unusual"),
    ({MOOR + "line_length": "10.9 m"}, "leaves 0.17 m of water above the moored vehicle"),
    (
        {MOOR + "line_material": None, MOOR + "line_diameter": "20 mm"},
        "Of polyester it would pull the vehicle down with 5.5 N",  # 355 kg/m³ over the water's, of 5 m, 314 mm²
    ),
    ({MOOR + "radius": "0.5 m"}, "0.5 m is unusual"),
    ({"site.current.0.speed": {"mean": "4 kn", "sd": "2 kn"}}, "is unusual: .*Gulf Stream"),
    ({"vehicle.energy.capacity": "60 J"}, "0.01667 W.h is unusual"),
    (
        {"vehicle.energy.capacity": "60 kW*h"},
        "vehicle.energy.capacity: 60.000 W h in a vehicle of 10.2 kg are 5882 W h/kg",
    ),
    ({"energy": {"capacity": "3 kW*h"}}, r"^[^ ]*energy.capacity: 3000 W h in a vehicle of 10.2 kg"),
    ({"vehicle.net_buoyancy": "11.5 N"}, "11.5 N is 11.5 % of the vehicle's weight"),
    ({"vehicle.mass": "20 kg"}, "displace .* of the hull's volume"),
    ({"vehicle.appendage_factor": 12.5}, "12.5 is unusual"),
]


def altered(changes):
    data = copy.deepcopy(dict(load(MISSIONS / "chesapeake.yaml").raw))
    for path, value in changes.items():
        *outer, last = (int(key) if key.isdigit() else key for key in path.split("."))
        section = data
        for key in outer:
            section = section[key]
        section[last] = value
    return data


def named(cases):
    return [" ".join(f"{path}={value}" for path, value in changes.items()) for changes, _ in cases]


@pytest.mark.parametrize(("changes", "said"), IMPOSSIBLE, ids=named(IMPOSSIBLE))
def test_what_cannot_be_is_refused_with_its_reason(changes, said):
    with pytest.raises(InputError, match=said):
        Mission.from_data(altered(changes))


@pytest.mark.parametrize(("changes", "said"), UNUSUAL, ids=named(UNUSUAL))
def test_what_is_unusual_is_asked_about(changes, said):
    notices = Mission.from_data(altered(changes)).notices()
    assert any(re.search(said, notice) for notice in notices), notices


@pytest.mark.parametrize("path", sorted(MISSIONS.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_missions_hold_nothing_unusual(path):
    assert load(path).notices() == ()


def test_what_just_can_be_is_let_pass():
    """400 legs of 700 m, with a current that carries as far as they go, and the arrival radius; floats at both ends."""
    floats = [{"distance": each, "buoyancy": "0.1 N"} for each in ("0 m", "5 m")]
    changes = {IN + "to": ["280.01 km", "0 m"], MOOR + "line_floats": floats}
    assert Mission.from_data(altered(changes)).moors[0].line_floats[1].distance == 5.0


def test_water_above_a_moored_vehicle_is_asked_about_where_there_is_less_than_a_metre_and_some():
    vehicle = SimpleNamespace(hull=SimpleNamespace(length=1.5))
    asked = [bool(list(_cover(SimpleNamespace(line_length=5.0), 6.5 + cover, vehicle))) for cover in (-1, 0, 0.5, 1)]
    assert asked == [False, False, True, False]


def test_a_layer_is_refused_that_begins_at_the_seafloor_or_below():
    site = SimpleNamespace(current=tuple(SimpleNamespace(down_to=end) for end in (5.0, 10.0, 20.0, 30.0)))
    refused = [[problem.path[-1] for problem in _layers(site, depth)] for depth in (21.0, 12.0, 10.0)]
    assert refused == [[], [3], [2, 3]]
