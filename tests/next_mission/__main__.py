"""``python -m tests.next_mission --cases 60``: what is planned after a diagnosis, beside what then comes to pass.

A mission sails a log in a sea that it does not know; the diagnosis of the log writes the mission for the next transit, a
week later and another way; that is simulated, and sailed by code of its own.
"""

import argparse
import json
import tempfile
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import yaml

import missionplan

from . import sea

START, WEEK, DAY = datetime(2026, 1, 10, tzinfo=UTC), 7 * 86400.0, 86400.0
AWAY = 6000.0
"""Of the next mission's goal [m]."""
TRIALS = 4000
MISSION = {
    "name": "Loop",
    "start": START.isoformat(),
    "site": {"origin": {"latitude": "37 deg", "longitude": "-76 deg"}},
    "navigation": {
        "velocity_error": {"sigma": f"{sea.SIGMA} m/s"},
        "surfacing_time": f"{sea.SURFACING} s",
        "fix_error": f"{sea.FIX} m",
    },
    "phases": [
        {
            "transit": {
                "name": "out",
                "from": ["0 m", "0 m"],
                "to": ["8 km", "0 m"],
                "speed": f"{sea.SPEED} m/s",
                "d_max": f"{sea.D_MAX} m",
                "arrival_radius": f"{sea.RADIUS} m",
            }
        }
    ],
}
DATA = {
    "kind": "transit",
    "name": "legs",
    "file": "legs.csv",
    "start": START.isoformat(),
    "noise": {"fix": f"{sea.FIX} m"},
}


def made(seed: int) -> dict[str, Any]:
    """Go round the loop once, with the extended mission and without: places among the trials, and scores [s]."""
    rng = np.random.default_rng(seed)
    truth = sea.Sea.drawn(rng)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "data").mkdir()
        (folder / "data" / "legs.csv").write_text(sea.log(truth, rng))
        (folder / "data" / "dataset.yaml").write_text(yaml.safe_dump(DATA))
        (folder / "mission.yaml").write_text(yaml.safe_dump(MISSION))
        found = missionplan.diagnose(folder / "mission.yaml", folder / "data", plan=False)
        found.save(folder / "diagnosis")
        later, course = WEEK + DAY * rng.random(), rng.uniform(-np.pi, np.pi)
        goal = AWAY * np.array([np.sin(course), np.cos(course)])
        took = sea.sailed(truth, later, goal, rng)
        planned = {
            which: _durations(file, later, goal)
            for which, file in (("with", folder / "diagnosis" / "mission.yaml"), ("without", folder / "mission.yaml"))
        }
    return {
        "seed": seed,
        "verdict": found.verdict,
        "took": took,
        **{f"place_{which}": float(np.mean(trials < took)) for which, trials in planned.items()},
        **{f"score_{which}": ranked_probability_score(trials, took) for which, trials in planned.items()},
    }


def _durations(file: Path, later: float, goal: sea.Array) -> sea.Array:
    """Durations of the trials that arrive of a mission's transit to another goal at another time [s]."""
    keys = yaml.safe_load(file.read_text())
    keys["start"] = (START + timedelta(seconds=later)).isoformat()
    keys["phases"][0]["transit"]["to"] = [f"{each:.1f} m" for each in goal]
    planned = file.with_name("next.yaml")
    planned.write_text(yaml.safe_dump(keys, sort_keys=False))
    trials = missionplan.simulate(planned, trials=TRIALS, keep_trials=True).trials
    return trials["total.duration_s"].dropna().to_numpy(dtype=float)


def ranked_probability_score(trials: sea.Array, value: float) -> float:
    """Continuous ranked probability score of trials, E|X − x| − E|X − X′|/2 (Gneiting & Raftery 2007, Eq. 21)."""
    ordered, n = np.sort(trials), len(trials)
    apart = 2.0 * float(np.sum((2.0 * np.arange(1, n + 1) - n - 1.0) * ordered)) / n**2
    return float(np.mean(np.abs(trials - value))) - 0.5 * apart


def figures(found: Sequence[dict[str, Any]]) -> list[float]:
    """Shares within the 90 and 50 % intervals, with the extended mission and without, and the scores' ratio."""
    shares = [
        float(np.mean([abs(each[f"place_{which}"] - 0.5) < inside / 2.0 for each in found]))
        for which in ("with", "without")
        for inside in (0.9, 0.5)
    ]
    scores = [float(np.mean([each[f"score_{which}"] for each in found])) for which in ("with", "without")]
    return [*shares, scores[0] / scores[1]]


def main() -> None:
    """Print a line a case, and the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    found = []
    for seed in range(chosen.seed, chosen.seed + chosen.cases):
        found.append(made(seed))
        print(json.dumps(found[-1]), flush=True)
    print(figures(found))


if __name__ == "__main__":
    main()
