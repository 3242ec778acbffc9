"""Missions whose plans are made in the tests."""

from pathlib import Path

from missionplan.mission import Mission, load
from missionplan.studies.init import init

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
