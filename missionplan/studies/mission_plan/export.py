"""`export`: the plan of a mission, written in a format that a vehicle or another program takes."""

from dataclasses import dataclass
from pathlib import Path

from missionplan.errors import InputError, Problem
from missionplan.exporters.formats import FORMATS, format_named
from missionplan.mission import Mission, MissionOrPath
from missionplan.mission.views import TransitMission, required_origin
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.store.folder import as_path, exists, is_file, is_folder, write_atomically
from missionplan.studies.mission_plan.build import mission_plan
from missionplan.studies.run import check_arguments
from missionplan.studies.simulation.checks import check_complete, check_cover


@dataclass(frozen=True)
class ExportedPlan:
    """What was written."""

    files: tuple[Path, ...]
    notes: tuple[str, ...]
    """What a reader of the files is to know."""
    lost: tuple[str, ...]
    """What of the plan the format cannot hold."""


def export(
    mission: MissionOrPath, to: str, *, out: str | Path | None = None, seed: int | None = None, force: bool = False
) -> ExportedPlan:
    """Write a mission's plan: waypoints with course, depth, speed and time-out, surfacings, moorings.

    Parameters
    ----------
    mission : Mission, str or Path
        With at least one transit; uncertain quantities are taken at their means.
    to : str
        Name of the format, of `missionplan.exporters.formats.FORMATS`.
    out : str or Path, optional
        The file; of a format of several files, or where a folder of that name exists, the folder. Default: named after
        the mission file, in the working directory.
    seed : int, optional
        Of the trials from which the time-outs are taken; default: the mission's.
    force : bool
        Write over files of the same names; never over a file that the mission was read from.

    Returns
    -------
    ExportedPlan

    Raises
    ------
    InputError
        When the mission lacks what its phases or the format need, or a file is there already: nothing is written then.
    RunError
        When a file cannot be written.
    """
    mission = check_arguments(mission, seed=seed, one_of={"to": (to, tuple(FORMATS))})
    check_complete(mission)
    TransitMission.of(mission)
    form = format_named(to)
    if form.NEEDS_ORIGIN:
        required_origin(mission, f"positions on Earth, which the format {to} has, need it")
    means = Scenario.at_means(mission, recorded_current(mission))
    check_cover(mission, means)
    plan = mission_plan(mission, seed=seed, means=means, to=to)
    stem = Path(mission.file).stem or "mission"
    written = form.files(plan, stem)
    places = _places(written, to, stem, as_path(out, "out") if out is not None else None)
    _check(places, mission, force=force)
    for path, content in zip(places, written.values(), strict=True):
        write_atomically(path, content)
    return ExportedPlan(tuple(places), plan.notes, form.lost(plan))


def _places(written: dict[str, str | bytes], to: str, stem: str, out: Path | None) -> list[Path]:
    """Return the path of each file."""
    if len(written) > 1:
        folder = out or Path(f"{stem}-{to}")
        return [folder / name for name in written]
    (name,) = written
    if out is None:
        return [Path(name)]
    return [out / name if is_folder(out) else out]


def _check(places: list[Path], mission: Mission, *, force: bool) -> None:
    """Refuse places that hold what is not to be lost."""
    sources = {path.resolve() for path in mission.sources}
    problems = [
        Problem("is read by this command and is not replaced", str(path), hint="name another place with out")
        for path in places
        if path.resolve() in sources
    ]
    for path in places:
        folder = path.parent
        if exists(path) and not is_file(path):
            problems.append(Problem("is no file that could be written over", str(path)))
        elif exists(path) and not force:
            problems.append(Problem("is there already", str(path), hint="force=True writes over it"))
        elif exists(folder) and not is_folder(folder):
            problems.append(Problem("is a file; a folder was expected", str(folder)))
    if problems:
        raise InputError(problems)
