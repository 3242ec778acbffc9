"""Data sets: what is wrong with them, and which commands they are ready for."""

from collections.abc import Callable, Sequence
from pathlib import Path

from missionplan.datasets import dataset_kind, files_outside
from missionplan.datasets.dives import read_descent
from missionplan.datasets.legs import read_transit
from missionplan.datasets.records import DescentData, TransitData
from missionplan.datasets.summaries import SummaryData, read_summary
from missionplan.datasets.tank import TANK_FORMATS, read_tank_data
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.studies.validate import Readiness, Validated

_Read = Callable[[Path, Mission], TransitData | DescentData | SummaryData]
DIAGNOSED: dict[str, _Read] = {"transit": read_transit, "descent": read_descent, "summary": read_summary}
SCORED = ("transit", "descent")
"""Kinds of data that `score` takes."""
_STAND_IN = {
    "site": {"depth": "11 km"},
    "phases": [{"moor": {"radius": "1 m", "line_length": "1 m", "anchor_wet_weight": "1 N"}}],
}
"""Mission of a data set that is checked alone: what its runs leave to the mission is taken to be there."""


def check_dataset(path: Path, mission: Mission | None, *, allow_outside: bool = False) -> None:
    """Read a data set for what is wrong with it, before a diagnosis is imported for it.

    `path`: of its folder. `mission`: None where it cannot be read: the data set is then checked alone. `allow_outside`:
    whether its table may lie outside its folder. Raises InputError with all problems of the data set.
    """
    with files_outside(allowed=allow_outside):
        kind = dataset_kind(path, (*DIAGNOSED, *TANK_FORMATS))
        if kind in TANK_FORMATS:
            read_tank_data(path)
        else:
            DIAGNOSED[kind](path, mission or Mission.from_data(_STAND_IN))


def validated_dataset(path: Path, missions: Sequence[Mission]) -> Validated:
    """Check a data set with the first of some missions that gives it what its runs leave to it."""
    try:
        if not (path / "dataset.yaml").is_file():
            raise InputError([Problem("holds neither a mission nor a data set", str(path))])
        kind = dataset_kind(path, (*DIAGNOSED, *TANK_FORMATS))
        summary = f"valid data set of kind {kind}."
        if kind in TANK_FORMATS:
            read_tank_data(path)
            return Validated(path, summary, table=(Readiness("identify"), Readiness("diagnose")))
        alone = DIAGNOSED[kind](path, Mission.from_data(_STAND_IN)).notices
    except InputError as error:
        return Validated(path, problems=error.problems)
    lacking: tuple[str, ...] = ("a mission beside it, to check what the runs leave to it",)
    for mission in missions:
        try:
            notices = DIAGNOSED[kind](path, mission).notices
        except InputError as error:
            lacking = tuple(f"{problem.key}: {problem.message} ({mission.file})" for problem in error.problems)
        else:
            return Validated(path, summary, table=_readiness(kind, ()), notices=notices)
    return Validated(path, summary, table=_readiness(kind, lacking), notices=alone)


def _readiness(kind: str, lacking: tuple[str, ...]) -> tuple[Readiness, ...]:
    """Say which commands take a data set that lacks some things."""
    return tuple(Readiness(command, lacking) for command in ("diagnose", *(("score",) if kind in SCORED else ())))
