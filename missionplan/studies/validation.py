"""What a mission, a data set or a folder of them is good for: everything that any command would refuse, at once."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from missionplan.datasets.dives import DescentData, read_descent
from missionplan.datasets.legs import TransitData, read_transit
from missionplan.datasets.reading import dataset_kind
from missionplan.datasets.summaries import SummaryData, read_summary
from missionplan.datasets.tank.data import read_tank_data
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission, load
from missionplan.mission.views import MooringMission, TransitionMission
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.store.paths import is_folder
from missionplan.studies.leg_length.sweep_scenario import SweepScenario
from missionplan.studies.nominal_dive import check_dives
from missionplan.studies.simulation.checks import check_complete, input_notices
from missionplan.studies.simulation.record_cover import check_cover

_Read = Callable[[Path, Mission], TransitData | DescentData | SummaryData]
DIAGNOSED: dict[str, _Read] = {"transit": read_transit, "descent": read_descent, "summary": read_summary}
TANK = ("drag", "free-oscillation", "thruster", "propeller-transient")
_STAND_IN = {
    "site": {"depth": "11 km"},
    "phases": [{"moor": {"radius": "1 m", "line_length": "1 m", "anchor_wet_weight": "1 N"}}],
}
"""Mission of a data set that is checked alone: what its runs leave to the mission is taken to be there."""


@dataclass(frozen=True)
class Readiness:
    """Whether one command can use a file.

    Attributes
    ----------
    command : str
    needs : tuple of str
        What is missing or wrong; none where it is ready.
    without : str
        What a part of its answer needs, where it is ready.
    """

    command: str
    needs: tuple[str, ...] = ()
    without: str = ""

    def __str__(self) -> str:
        words = f"needs {'; '.join(self.needs)}" if self.needs else "ready"
        return f"{self.command:<17} {words}" + (f"; needs {self.without}" if self.without and not self.needs else "")


@dataclass(frozen=True)
class Validated:
    """What was found of one file or data set.

    Attributes
    ----------
    path : Path
    summary : str
        What it is.
    table : tuple of Readiness
        What it is good for.
    notices : tuple of str
        What is unusual.
    problems : tuple of Problem
        What is wrong; then there is no more.
    """

    path: Path
    summary: str = ""
    table: tuple[Readiness, ...] = ()
    notices: tuple[str, ...] = ()
    problems: tuple[Problem, ...] = ()


def validate(paths: Iterable[Path], *, allow_outside: bool = False) -> tuple[Validated, ...]:
    """Check missions and data sets, and say what each is good for.

    Parameters
    ----------
    paths : iterable of Path
        Mission files, data sets, and folders: of these all missions and data sets, and what is below.
    allow_outside : bool
        Whether included files may lie outside a mission file's folder.

    Returns
    -------
    tuple of Validated
        Missions first; a data set is checked with the first of them that gives it what its runs leave to it.
    """
    found = [each for path in paths for each in _expanded(path)]
    missions = [path for path in found if not is_folder(path)]
    done: list[Validated] = []
    valid: list[Mission] = []
    for path in missions:
        try:
            mission = load(path, allow_outside=allow_outside)
            done.append(_mission(path, mission))
        except InputError as error:
            done.append(Validated(path, problems=error.problems))
        else:
            valid.append(mission)
    return (*done, *(_dataset(path, valid) for path in found if is_folder(path)))


def _expanded(path: Path) -> Iterator[Path]:
    """Missions and data sets in a folder and below; what is neither stays, to be refused."""
    if not is_folder(path) or (path / "dataset.yaml").is_file():
        yield path
        return
    datasets = sorted(each.parent for each in path.rglob("dataset.yaml"))
    inside = [each for each in sorted((*path.rglob("*.yaml"), *path.rglob("*.yml"))) if each.parent not in datasets]
    missions = [each for each in inside if _is_mission(each)]
    yield from (*missions, *datasets)
    if not missions and not datasets:
        yield path


def _is_mission(path: Path) -> bool:
    """Whether a file of a folder is meant as a mission: it has phases, and is not a vehicle."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return True  # said by whoever loads it
    return any(line.startswith(("phases:", "navigation:", "site:")) for line in lines)


def _mission(path: Path, mission: Mission) -> Validated:
    """Check what `load` does not: files of the current, nominal dives and times, and what each command needs.

    Raises
    ------
    InputError
        When the current cannot be read or does not cover the mission, or a nominal dive is impossible.
    """
    means = Scenario.at_means(mission, recorded_current(mission))
    check_cover(mission, means)
    check_dives(means)
    notices: list[str] = []

    def simulable() -> None:
        check_complete(mission)
        notices.extend(input_notices(mission, means))

    simulation = _needs(simulable)
    kinds = ", ".join(phase.kind for phase in mission.phases) or "none"
    legs = _needs(lambda: SweepScenario.of(mission))
    table = (
        Readiness("simulate", simulation),
        Readiness("sweep-dmax", legs),
        Readiness("plan-legs", legs),
        Readiness("size-anchor", _needs(lambda: MooringMission.of(mission)), _construction(mission)),
        Readiness("sweep-transition", _needs(lambda: TransitionMission.of(mission))),
    )
    summary = f"valid. Phases: {kinds}; {len(mission.uncertain())} quantities are distributions."
    return Validated(path, summary, table, tuple(notices) or mission.notices())


def _needs(check: Callable[[], object]) -> tuple[str, ...]:
    """What a check refuses, in words: the key path where it is missing."""
    try:
        check()
    except InputError as error:
        return tuple(_in_words(problem) for problem in error.problems)
    return ()


def _in_words(problem: Problem) -> str:
    if problem.message.startswith("missing"):
        return problem.key
    words = problem.message.removeprefix("the mission has no ")
    return f"a {words}" if words != problem.message else f"{problem.key}: {words}" if problem.key else words


def _construction(mission: Mission) -> str:
    anchor = mission.vehicle.anchor if mission.vehicle else None
    built = anchor is None or anchor.construction is not None
    return "" if built else "vehicle.anchor.construction to say how the anchor is built"


def _dataset(path: Path, missions: Sequence[Mission]) -> Validated:
    try:
        if not (path / "dataset.yaml").is_file():
            raise InputError([Problem("holds neither a mission nor a data set", str(path))])
        kind = dataset_kind(path, (*DIAGNOSED, *TANK))
        summary = f"valid data set of kind {kind}."
        if kind in TANK:
            read_tank_data(path)
            return Validated(path, summary, (Readiness("identify"), Readiness("diagnose")))
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
            return Validated(path, summary, (Readiness("diagnose"),), notices)
    return Validated(path, summary, (Readiness("diagnose", lacking),), alone)
