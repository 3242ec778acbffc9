"""A program of somebody else's: it plans, looks at numbers and writes files; `mypy --strict` checks its types."""

from pathlib import Path

import missionplan


def slower_is_safer(path: str | Path, speeds: tuple[float, ...] = (1.2, 1.5)) -> dict[float, float]:
    """Return P(success) of a mission by speed [m/s]."""
    mission: missionplan.Mission = missionplan.load(path)
    found: dict[float, float] = {}
    for speed in speeds:
        outcome = missionplan.simulate(mission.with_(speed=speed), trials=200)
        found[speed] = outcome.total.events["success"].value
    return found


def best_leg(path: str | Path) -> float:
    """Return the d_max to choose [m]."""
    sweep = missionplan.sweep_dmax(path, trials=200)
    frame = sweep.to_frame()
    assert len(frame) > 0
    return sweep.middle.recommended.d_max


def problems(path: str | Path) -> list[str]:
    """Return what is wrong with a mission file."""
    try:
        missionplan.load(path)
    except missionplan.InputError as error:
        return [f"{problem.key}: {problem.message}" for problem in error.problems]
    return []
