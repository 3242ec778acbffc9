"""`validate`: what missions, data sets and folders are good for, and every problem of theirs at once."""

from collections.abc import Iterable, Iterator
from pathlib import Path, PurePath

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission, MissionOrPath, load
from missionplan.mission.views import TransitionMission, TransitMission
from missionplan.scenario.anchors import design_current
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.store.folder import as_path, is_folder
from missionplan.studies.held_vehicle import check_dives
from missionplan.studies.leg_length.sweep_scenario import SweepScenario
from missionplan.studies.optimisation.choosable import read_lattice
from missionplan.studies.simulation.checks import (
    check_complete,
    check_cover,
    cover_in_words,
    input_notices,
    vehicle_notices,
)
from missionplan.studies.validation.place import check_place, tracks_lost
from missionplan.studies.validation.readiness import Readiness, Validated, needs


def validated_mission(path: Path, mission: Mission) -> Validated:
    """Check a mission that has been read.

    Raises
    ------
    InputError
        When the current cannot be read or does not cover the mission, a nominal dive is impossible, or what may be
        chosen is wrong.
    """
    wrong = _wrong_choices(mission)
    try:
        means = Scenario.at_means(mission, recorded_current(mission))
        check_cover(mission, means)
        check_dives(means)
        check_place(means)
    except InputError as error:
        raise InputError([*error.problems, *wrong]) from None
    if wrong:
        raise InputError(wrong)
    notices: list[str] = []

    def simulable() -> None:
        check_complete(mission)
        notices.extend((*vehicle_notices(mission, means), *input_notices(mission, means), *tracks_lost(means)))

    simulation = needs(simulable)
    kinds = ", ".join(phase.kind for phase in mission.phases) or "none"
    legs = needs(lambda: SweepScenario.of(mission, means))
    table = (
        Readiness("simulate", simulation),
        Readiness("export", needs(lambda: TransitMission.of(mission)), _origin(mission)),
        Readiness("sweep-dmax", legs),
        Readiness("plan-legs", legs),
        Readiness("size-anchor", needs(lambda: _sizable(means)), _construction(mission)),
        Readiness("sweep-transition", needs(lambda: TransitionMission.of(mission))),
        Readiness("optimise", simulation or _requirements(mission), _choices(mission)),
    )
    summary = f"valid. Phases: {kinds}; {len(mission.uncertain())} quantities are distributions."
    summary += cover_in_words(mission, means.recorded)
    return Validated(path, summary, mission.values_in_force(), table, tuple(notices) or mission.notices())


def _origin(mission: Mission) -> str:
    placed = mission.site is not None and mission.site.origin is not None
    return "" if placed else "site.origin for formats with positions on Earth"


def _sizable(means: Scenario) -> None:
    """Refuse a mission whose anchors cannot be sized."""
    for phase in means.mooring.moors:
        design_current(means, phase)


def _construction(mission: Mission) -> str:
    anchor = mission.vehicle.anchor if mission.vehicle else None
    built = anchor is None or anchor.construction is not None
    return "" if built else "vehicle.anchor.construction to say how the anchor is built"


def _wrong_choices(mission: Mission) -> list[Problem]:
    """Everything wrong with what the mission says may be chosen."""
    try:
        if mission.optimise.choose:
            read_lattice(mission, ())
    except InputError as error:
        return list(error.problems)
    return []


def _requirements(mission: Mission) -> tuple[str, ...]:
    return () if mission.requirements else ("requirements",)


def _choices(mission: Mission) -> str:
    return "" if mission.optimise.choose else "optimise.choose in the mission, or --choose"


def validate(paths: MissionOrPath | Iterable[MissionOrPath], *, allow_outside: bool = False) -> tuple[Validated, ...]:
    """Check missions and data sets, and say what each is good for.

    Parameters
    ----------
    paths : str, Path, Mission or iterable of them
        Missions, mission files, data sets, and folders: of these all missions and data sets, and what is below.
    allow_outside : bool
        Whether included files may lie outside a mission file's folder, and tables outside their data set's.

    Returns
    -------
    tuple of Validated
        Missions first; a data set is checked with the first of them that gives it what its runs leave to it.
    """
    given = [paths] if isinstance(paths, Mission | str | PurePath) else list(paths)
    found = [
        each for one in given for each in ([one] if isinstance(one, Mission) else _expanded(as_path(one, "paths")))
    ]
    datasets = [each for each in found if isinstance(each, Path) and is_folder(each)]
    done: list[Validated] = []
    valid: list[Mission] = []
    for each in found:
        if each in datasets:
            continue
        path = Path(each.file) if isinstance(each, Mission) else each
        try:
            mission = each if isinstance(each, Mission) else load(each, allow_outside=allow_outside)
            done.append(validated_mission(path, mission))
        except InputError as error:
            done.append(Validated(path, problems=error.problems))
        else:
            valid.append(mission)
    if datasets:
        from missionplan.datasets.reading import files_outside
        from missionplan.studies.validation.data_sets import validated_dataset

        with files_outside(allowed=allow_outside):
            done += [validated_dataset(path, valid) for path in datasets]
    return tuple(done)


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
