"""Fleets of missions, one after the other: each mission is diagnosed, its extended mission is the next one's.

``python -m tests.fleets --fleets 100`` prints the figures. Every vehicle has a compass that is off and
a log that runs slow or fast; between missions 3 and 4 the compass of every second vehicle is knocked to another angle.
The legs are sailed in steps of a minute with errors of their own, and each mission has nuisances of its own: a slight
current, a compass and a log that differ a little.
"""

import argparse
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import yaml

from missionplan import diagnose
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.legs.model_factory import transit_model
from missionplan.mission import Mission
from missionplan.results.learned.diagnosis import Diagnosis

MISSIONS, LEGS, CHANGED = 5, 40, 3
MINUTE, FIX, SIGMA, SPEED = 60.0, 3.0, 0.03, 1.1
COMPASS, LOG = "compass-bias", "speed-scale"
NUISANCE_ANGLE, NUISANCE_PACE, NUISANCE_CURRENT = np.radians(0.1), 0.0015, 0.003
MISSION = {
    "name": "Fleet",
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
class Fleet:
    """What one fleet showed: whether the change was named, intervals that held, and gains in log score."""

    named: bool | None
    held: tuple[bool, ...]
    gains: tuple[float, ...]


def sail(rng: np.random.Generator, angle: float, pace: float) -> str:
    """Sail a mission's legs and return its table, comma-separated."""
    angle = angle + NUISANCE_ANGLE * rng.standard_normal()
    pace = pace + NUISANCE_PACE * rng.standard_normal()
    current = NUISANCE_CURRENT * rng.standard_normal(2)
    rows = ["leg,t_start_s,t_end_s,x_start_m,y_start_m,x_dr_m,y_dr_m,x_end_m,y_end_m"]
    place, clock = np.zeros(2), 0.0
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


def halves(table: str) -> list[str]:
    """Every second leg, and the others."""
    header, *rows = table.splitlines()
    return ["\n".join([header, *rows[start::2]]) + "\n" for start in (0, 1)]


def data(folder: Path, name: str, table: str) -> Path:
    place = folder / name
    place.mkdir()
    (place / "legs.csv").write_text(table)
    keys = {"kind": "transit", "name": name, "file": "legs.csv", "noise": {"fix": f"{FIX} m"}}
    (place / "dataset.yaml").write_text(yaml.safe_dump(keys))
    return place


def score(mission: Mission, place: Path) -> float:
    """Log evidence of a mission as it stands for legs that it has not seen."""
    model = transit_model(read_transit(place, mission), mission, seed=1)
    return float(model.fit(()).log_evidence)


def extended(found: Diagnosis) -> Mission:
    return Mission.from_data(found.extended)


def run(seed: int, *, changes: bool) -> Fleet:
    rng = np.random.default_rng([seed, 77])
    angle, pace = np.radians(rng.uniform(2.0, 6.0)) * rng.choice([-1.0, 1.0]), rng.uniform(-0.08, -0.03)
    fresh = mission = Mission.from_data(MISSION)
    held: list[bool] = []
    gains: list[float] = []
    named: bool | None = None
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for number in range(MISSIONS):
            if changes and number == CHANGED:
                angle += np.radians(4.0) * rng.choice([-1.0, 1.0])
            table = sail(rng, angle, pace)
            if number:
                learned, unseen = (data(folder, f"{number}-{i}", half) for i, half in enumerate(halves(table)))
                known, anew = (diagnose(each, learned, plan=False) for each in (mission, fresh))
                gains.append(score(extended(known), unseen) - score(extended(anew), unseen))
            found = diagnose(mission, data(folder, f"{number}", table), plan=False)
            if changes and number == CHANGED:
                named = COMPASS in found.changed
            best = found.best.parameters if found.causes and found.best is not None else ()
            estimates = {each.effect: each for each in (*found.confirmed, *best)}
            for effect, truth in ((COMPASS, angle), (LOG, pace)):
                if effect in estimates:
                    held.append(estimates[effect].low <= truth <= estimates[effect].high)
            mission = extended(found)
    return Fleet(named, tuple(held), tuple(gains))


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fleets", description=__doc__)
    parser.add_argument("--fleets", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    seeds = range(chosen.seed, chosen.seed + chosen.fleets)
    with ProcessPoolExecutor(chosen.jobs) as pool:
        steady = list(pool.map(partial(run, changes=False), seeds[::2]))
        changing = list(pool.map(partial(run, changes=True), seeds[1::2]))
    fleets = steady + changing
    gains = np.array([fleet.gains for fleet in fleets])
    held = np.concatenate([fleet.held for fleet in fleets])
    error = gains.mean(axis=1).std(ddof=1) / np.sqrt(len(fleets))
    print(f"fleets: {len(fleets)}, of which {len(changing)} change between missions {CHANGED} and {CHANGED + 1}")
    print(f"change named in mission {CHANGED + 1}: {sum(bool(fleet.named) for fleet in changing)} of {len(changing)}")
    print(f"90 % intervals that hold the truth: {held.mean():.3f} of {held.size}")
    print(f"effects without an estimate: {2 * MISSIONS * len(fleets) - held.size} of {2 * MISSIONS * len(fleets)}")
    print(f"log score of unseen legs over starting afresh: {gains.mean():+.2f} ± {error:.2f} nats a mission")
    print("by mission:", ", ".join(f"{gain:+.2f}" for gain in gains.mean(axis=0)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
