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

HEADING = (
    "# The mission of the second round in docs/loop.md; its sea is made up by `python -m tests.next_trial.loop`.\n"
)
VEHICLE, TRUTH = Vehicle(sigma=0.02, fix=5.0), Truth(current=(0.0, -0.15))
LEGS, LENGTH, SEED = 12, 150.0, 5
THIRD_LEGS, THIRD_LENGTH, DAYS_LATER = 20, 300.0, 4.3 * 86_400.0
NEXT_AFTERNOON = 31.0 * 3600.0
"""When the trial is sailed [s]: at another state of the tide."""


def write_first(folder: Path) -> tuple[Path, Path]:
    """Write the mission and the first log."""
    folder.mkdir(parents=True, exist_ok=True)
    plan = folder / "mission.yaml"
    told = yaml.safe_dump(mission(VEHICLE, 3000.0, 800.0, 480.0, 100.0), sort_keys=False)
    plan.write_text(HEADING + told, encoding="utf-8")
    return plan, write_log(folder / "first-log", VEHICLE, _first_rows(), runs=[1] * LEGS)


def write_second(folder: Path, trial: object) -> Path:
    """Sail the legs of a trial's mission, and write them after those of the first log, as another run.

    Parameters
    ----------
    folder : Path
    trial : mapping
        Contents of ``next-trial.yaml``.
    """
    plan = legs_of(trial)
    first = _first_rows()
    rows = sail(TRUTH, VEHICLE, plan.headings, plan.lengths, NEXT_AFTERNOON, np.random.default_rng(SEED + 1))
    runs = [1] * len(first) + [2] * len(rows)
    return write_log(folder / "both-logs", VEHICLE, [*first, *rows], runs=runs)


def write_third(folder: Path) -> Path:
    """Write the log of the mission itself, sailed there and back some days later."""
    headings = np.repeat([0.0, np.pi], THIRD_LEGS // 2)
    rng = np.random.default_rng(SEED + 2)
    rows = sail(TRUTH, VEHICLE, headings, np.full(THIRD_LEGS, THIRD_LENGTH), DAYS_LATER, rng)
    return write_log(folder / "third-log", VEHICLE, rows)


def _first_rows() -> list[list[str]]:
    return sail(TRUTH, VEHICLE, np.zeros(LEGS), np.full(LEGS, LENGTH), 0.0, np.random.default_rng(SEED))


if __name__ == "__main__":
    place = Path(sys.argv[1])
    write_first(place)
    write_third(place)
    if (place / "next-trial.yaml").exists():
        write_second(place, yaml.safe_load((place / "next-trial.yaml").read_text(encoding="utf-8")))
