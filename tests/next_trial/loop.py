"""The files of docs/loop.md's second round: ``python -m tests.next_trial.loop FOLDER`` writes those that are missing.

A vehicle goes north by a log on which 0.15 m/s are missing: a head current, which the mission does not know, or a log
that runs fast? It is a current. Legs on one heading cannot tell; the trial that `diagnose --next-trial` writes can.
"""

import sys
from pathlib import Path

import numpy as np
import yaml

from .campaign import legs_of
from .sea import Truth, Vehicle, mission, sail, write_log

VEHICLE, TRUTH = Vehicle(sigma=0.02, fix=5.0), Truth(current=(0.0, -0.15))
LEGS, LENGTH, SEED = 12, 150.0, 5
NEXT_AFTERNOON = 31.0 * 3600.0
"""When the trial is sailed [s]: at another state of the tide."""


def write_first(folder: Path) -> tuple[Path, Path]:
    """Write the mission and the first log."""
    folder.mkdir(parents=True, exist_ok=True)
    plan = folder / "mission.yaml"
    plan.write_text(yaml.safe_dump(mission(VEHICLE, 3000.0, 800.0, 480.0, 100.0), sort_keys=False), encoding="utf-8")
    return plan, write_log(folder / "first-log", VEHICLE, _first_rows(), runs=[1] * LEGS)


def write_second(folder: Path, trial: object) -> Path:
    """Sail the legs of a trial's mission, and write them after those of the first log, as another run.

    Parameters
    ----------
    folder : Path
    trial : mapping
        Contents of ``next-trial.yaml``.
    """
    courses, lengths = legs_of(trial)
    first = _first_rows()
    rows = sail(TRUTH, VEHICLE, courses, lengths, NEXT_AFTERNOON, np.random.default_rng(SEED + 1))
    runs = [1] * len(first) + [2] * len(rows)
    return write_log(folder / "both-logs", VEHICLE, [*first, *rows], runs=runs)


def _first_rows() -> list[list[str]]:
    return sail(TRUTH, VEHICLE, np.zeros(LEGS), np.full(LEGS, LENGTH), 0.0, np.random.default_rng(SEED))


if __name__ == "__main__":
    place = Path(sys.argv[1])
    write_first(place)
    if (place / "next-trial.yaml").exists():
        write_second(place, yaml.safe_load((place / "next-trial.yaml").read_text(encoding="utf-8")))
