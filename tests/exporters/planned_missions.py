"""Missions whose plans the tests write and read back, and positions by another way than the package's own."""

from pathlib import Path

import numpy as np
from pyproj import Geod

from missionplan.mission import Mission, load
from missionplan.results.plan import Plan
from missionplan.studies.init import init
from missionplan.studies.mission_plan.build import mission_plan

MISSIONS = Path(__file__).parents[2] / "missions"
TABLE = {
    "name": "Legs by a table, south of the equator, across the date line",
    "site": {"origin": {"latitude": "-17.5 deg", "longitude": "179.99 deg"}},
    "navigation": {"velocity_error": {"sigma": "0.035 m/s"}, "surfacing_time": "90 s"},
    "phases": [
        {
            "transit": {
                "name": "way <out> & up",
                "from": ["0 m", "0 m"],
                "to": ["6 km", "4 km"],
                "depth": "12.5 m",
                "speed": "1.25 m/s",
                "d_max": {"table": [["200 m", "180 m"], ["1500 m", "1400 m"], ["8 km", "3 km"]]},
                "arrival_radius": "50 m",
            }
        }
    ],
}


def chesapeake() -> Mission:
    return load(MISSIONS / "chesapeake.yaml")


def starter(folder: Path) -> Mission:
    init(folder)
    return load(folder / "mission.yaml")


def by_table(changes: dict | None = None) -> Mission:
    return Mission.from_data({**TABLE, **(changes or {})}, file="table.yaml")


def all_plans(folder: Path) -> dict[str, Plan]:
    missions = {"chesapeake": chesapeake(), "starter": starter(folder), "table": by_table()}
    return {name: mission_plan(mission) for name, mission in missions.items()}


def metres_apart(plan: Plan, point, latitude: float, longitude: float) -> float:
    """Distance [m] between a planned point, by azimuth and distance from the origin, and where a file has it [deg]."""
    geod = Geod(ellps="WGS84")
    origin = np.degrees(plan.origin)
    azimuth, distance = np.degrees(np.arctan2(point.east, point.north)), np.hypot(point.east, point.north)
    lon, lat, _ = geod.fwd(origin[1], origin[0], azimuth, distance)
    return geod.inv(lon, lat, longitude, latitude)[2]
