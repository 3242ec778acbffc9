"""Legs of a vehicle with a compass that is off and a log that runs slow, mission after mission."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.legs.kind import transit_model
from missionplan.mission import Mission

COMPASS, LOG = "compass-bias", "speed-scale"
LEGS = 24
MONTH = 30 * 86400.0
MINUTE, FIX, SIGMA, SPEED = 60.0, 3.0, 0.03, 1.1
NUISANCE_ANGLE, NUISANCE_PACE, NUISANCE_CURRENT = np.radians(0.1), 0.0015, 0.003
MISSION = {
    "name": "Fleet",
    "start": "2026-01-10T00:00:00Z",
    "site": {"origin": {"latitude": "37 deg", "longitude": "-76 deg"}},
    "navigation": {
        "velocity_error": {"sigma": f"{SIGMA} m/s"},
        "surfacing_time": "60 s",
        "fix_error": f"{FIX} m",
    },
    "phases": [
        {
            "transit": {
                "name": "out",
                "from": ["0 m", "0 m"],
                "to": ["8 km", "0 m"],
                "speed": f"{SPEED} m/s",
                "d_max": "1 km",
                "arrival_radius": "60 m",
            }
        }
    ],
}


@dataclass(frozen=True)
class Sailing:
    """A vehicle that sails legs.

    Attributes
    ----------
    rng : numpy.random.Generator
    truths : mapping
        Levels of its compass [rad] and log in each mission.
    """

    rng: np.random.Generator
    truths: Mapping[str, np.ndarray]

    @property
    def mission(self) -> Mission:
        return Mission.from_data(MISSION)

    def record(self, number: int) -> str:
        """Make a mission: its table."""
        return sail(self.rng, number, self.truths[COMPASS][number], self.truths[LOG][number])

    def halves(self, record: str) -> list[str]:
        """Every second leg, and the others."""
        header, *rows = record.splitlines()
        return ["\n".join([header, *rows[start::2]]) + "\n" for start in (0, 1)]

    def data(self, place: Path, record: str) -> Path:
        """Write a record as a data set."""
        place.mkdir()
        (place / "legs.csv").write_text(record)
        keys = {"kind": "transit", "name": place.name, "file": "legs.csv", "noise": {"fix": f"{FIX} m"}}
        (place / "dataset.yaml").write_text(yaml.safe_dump(keys))
        return place

    def score(self, mission: Mission, place: Path) -> float:
        """Log evidence of a mission as it stands for legs that it has not seen."""
        model = transit_model(read_transit(place, mission), mission, seed=1)
        return float(model.fit(()).log_evidence)


def sail(rng: np.random.Generator, number: int, angle: float, pace: float) -> str:
    """Sail a mission's legs, a month after the last one's, and return its table, comma-separated."""
    angle = angle + NUISANCE_ANGLE * rng.standard_normal()
    pace = pace + NUISANCE_PACE * rng.standard_normal()
    current = NUISANCE_CURRENT * rng.standard_normal(2)
    rows = ["leg,t_start_s,t_end_s,x_start_m,y_start_m,x_dr_m,y_dr_m,x_end_m,y_end_m"]
    place, clock = np.zeros(2), number * MONTH
    for number in range(LEGS):
        heading, minutes = rng.uniform(-np.pi, np.pi), int(rng.integers(10, 20))
        known = place + FIX * rng.standard_normal(2)
        reckoned = known.copy()
        error = SIGMA * rng.standard_normal(2)
        for _ in range(minutes):
            reckoned += SPEED * MINUTE * np.array([np.sin(heading), np.cos(heading)])
            course = heading + angle
            over_ground = SPEED * (1.0 + pace) * np.array([np.sin(course), np.cos(course)]) + current + error
            place = place + MINUTE * over_ground
        fix = place + FIX * rng.standard_normal(2)
        end = clock + MINUTE * minutes
        cells = [number + 1, clock, end, *known, *reckoned, *fix]
        rows.append(",".join(f"{cell:.6g}" if index < 1 else f"{cell:.2f}" for index, cell in enumerate(cells)))
        clock = end + MINUTE
    return "\n".join(rows) + "\n"
