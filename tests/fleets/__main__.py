"""Fleets of missions, one after the other: each mission is diagnosed, its extended mission is the next one's.

``python -m tests.fleets --fleets 40`` prints the figures. Every vehicle has a compass that is off and a log that runs
slow. One of the two stays as it is, drifts, jumps once or is drawn anew each mission; the other stays. The legs are
sailed in steps of a minute with errors of their own, and each mission has nuisances of its own: a slight current, a
compass and a log that differ a little.
"""

import argparse
import sys
import tempfile
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from missionplan import diagnose
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.legs.model_factory import transit_model
from missionplan.mission import Mission
from missionplan.results.learned.diagnosis import Diagnosis

MISSIONS, LEGS = 6, 24
MONTH = 30 * 86400.0
MINUTE, FIX, SIGMA, SPEED = 60.0, 3.0, 0.03, 1.1
COMPASS, LOG = "compass-bias", "speed-scale"
WAYS = ("constant", "drifting", "jumping", "redrawn")
CHANGES = {
    COMPASS: {"constant": 0.0, "drifting": np.radians(0.8), "jumping": np.radians(6.0), "redrawn": np.radians(2.0)},
    LOG: {"constant": 0.0, "drifting": 0.02, "jumping": 0.08, "redrawn": 0.02},
}
"""Change a mission, greatest jump, standard deviation of what is drawn anew."""
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
class Fleet:
    """What one vehicle showed in its missions.

    Attributes
    ----------
    held : tuple of bool
        Whether the 90 % interval of each level, at its date, held the truth.
    gains : tuple of float
        Log scores of legs unseen in the third and the last mission, over starting afresh [nats].
    trend, jump : bool or None
        Whether a trend was told at the end, and a jump at its mission; None where there was none to tell.
    false_trend : bool
        Whether a trend was told of what does not drift.
    """

    held: tuple[bool, ...]
    gains: tuple[float, ...]
    trend: bool | None
    jump: bool | None
    false_trend: bool


def levels_of(rng: np.random.Generator, way: str, changing: str) -> tuple[dict[str, np.ndarray], int | None]:
    """Draw the levels of both parameters in each mission [rad, –], and the mission that jumps."""
    found = {
        COMPASS: np.full(MISSIONS, np.radians(rng.uniform(2.0, 6.0)) * rng.choice([-1.0, 1.0])),
        LOG: np.full(MISSIONS, rng.uniform(-0.08, -0.03)),
    }
    at = int(rng.integers(2, 5)) if way == "jumping" else None
    change = {
        "constant": np.zeros(MISSIONS),
        "drifting": np.arange(MISSIONS) * rng.choice([-1.0, 1.0]),
        "jumping": (np.arange(MISSIONS) >= (at or 0)) * rng.choice([-1.0, 1.0]) * rng.uniform(0.7, 1.0),
        "redrawn": rng.standard_normal(MISSIONS),
    }[way]
    found[changing] = found[changing] + CHANGES[changing][way] * change
    return found, at


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


def kind_of(seed: int) -> tuple[str, str]:
    """Return how a vehicle of that seed changes, and what of it does."""
    return WAYS[seed % 4], (COMPASS, LOG)[seed // 4 % 2]


def run(seed: int) -> Fleet:
    """Sail and diagnose one vehicle's missions."""
    rng = np.random.default_rng([seed, 77])
    way, changing = kind_of(seed)
    truths, at = levels_of(rng, way, changing)
    fresh = mission = Mission.from_data(MISSION)
    held: list[bool] = []
    gains: list[float] = []
    trend = jump = None
    false_trend = False
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for number in range(MISSIONS):
            table = sail(rng, number, truths[COMPASS][number], truths[LOG][number])
            if number in (2, MISSIONS - 1) and number != at:
                learned, unseen = (data(folder, f"{number}-{i}", half) for i, half in enumerate(halves(table)))
                known, anew = (diagnose(each, learned, plan=False) for each in (mission, fresh))
                gains.append(score(extended(known), unseen) - score(extended(anew), unseen))
            found = diagnose(mission, data(folder, f"{number}", table), plan=False)
            mission = extended(found)
            told = {each.effect: each for each in found.levels}
            for effect in told.keys() & truths.keys():
                last, truth = told[effect].missions[-1], truths[effect][number]
                held.append(bool(abs(last.value - truth) < 1.645 * last.sd))
            one = told.get(changing)
            if at is not None and one is not None and number in (at, at + 1):
                jump = bool(jump) or one.missions[at] in one.jumps
            drifts = {effect for effect, each in told.items() if each.has_trend}
            trend = changing in drifts if way == "drifting" else None
            false_trend |= bool(drifts - ({changing} if way == "drifting" else set()))
    return Fleet(tuple(held), tuple(gains), trend, jump if at is None else bool(jump), false_trend)


def table(found: Mapping[int, Fleet]) -> str:
    """Coverage, gains, trends and jumps by the way in which the vehicles change."""
    lines = []
    for way in WAYS:
        own = [each for seed, each in found.items() if kind_of(seed)[0] == way]
        if not own:
            continue
        held, gains = ([value for each in own for value in getattr(each, name)] for name in ("held", "gains"))
        named = [bool(value) for each in own for value in (each.trend, each.jump) if value is not None]
        lines.append(
            f"{way}: {len(own)} vehicles; 90 % intervals hold {np.mean(held):.3f} of {len(held)}; "
            f"over starting afresh {np.mean(gains):+.2f} nats; false trends {sum(each.false_trend for each in own)}"
            + (f"; named {sum(named)} of {len(named)}" if named else "")
        )
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fleets", description=__doc__)
    parser.add_argument("--fleets", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    seeds = range(chosen.seed, chosen.seed + chosen.fleets)
    with ProcessPoolExecutor(chosen.jobs) as pool:
        print(table(dict(zip(seeds, pool.map(run, seeds), strict=True))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
