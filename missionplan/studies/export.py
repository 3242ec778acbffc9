"""`export`: the plan of a mission, and its files in a format that a vehicle or another program takes."""

import hashlib
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.exporters import FORMATS, execution_of, format_named, refusals_of
from missionplan.mission import Mission, MissionOrPath
from missionplan.mission.schema.place import to_geographic
from missionplan.mission.views import navigation_of, required_origin
from missionplan.montecarlo.distributions import mean_of
from missionplan.phases.transit.plan import Execution
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results import to_yaml
from missionplan.results.plan import Plan
from missionplan.results.plan_places import Fence
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.store.folder import as_path, exists, is_file, is_folder, write_atomically
from missionplan.studies.planned_phases import PhaseBuilder
from missionplan.studies.run import check_arguments
from missionplan.studies.simulation import check_complete, check_cover


def mission_plan(
    mission: Mission, *, seed: int | None = None, means: Scenario | None = None, to: str | None = None
) -> Plan:
    """Build the plan of a mission with at least one transit.

    `seed`: of the trials from which the time-outs are taken; default: the mission's. `means`: the mission at its means,
    where it is made already. `to`: format of the vehicle that it is for, whose own rules the time-outs and the point
    steered for then follow; default: the plan's rules. Raises InputError when the mission has no transit, or lacks what
    transits need, or allows fewer legs than its course has, or the vehicle of the format cannot do it.
    """
    navigation_of(mission)
    builder = PhaseBuilder(
        means or Scenario.at_means(mission, recorded_current(mission)),
        mission.monte_carlo.seed if seed is None else seed,
        execution_of(to) if to is not None else None,
    )
    phases = tuple(builder.phases())
    origin = mission.site.origin if mission.site else None
    plan = Plan(
        mission=mission.name,
        digest=hashlib.sha256(to_yaml(mission.identified()).encode()).hexdigest(),
        version=version("missionplan"),
        start=mission.start,
        origin=(origin.latitude, math.remainder(origin.longitude, 2.0 * math.pi)) if origin else None,
        phases=phases,
        notes=(*_notes(mission), *builder.notes),
        capacity=float(mean_of(mission.budget.capacity)) / JOULES_PER_WATT_HOUR
        if mission.budget and mission.budget.capacity is not None
        else math.nan,
        fences=tuple(_fences(builder.means)),
        has_thruster=mission.vehicle is not None and mission.vehicle.propulsion is not None,
        corrects=mission.navigation is not None and mission.navigation.drift_compensation != "none",
    )
    refused = refusals_of(to, plan) if to is not None else ()
    if refused:
        raise InputError([replace(problem, file=mission.file) for problem in refused])
    return plan


def executions(mission: Mission, to: str, plan: Plan) -> dict[str, Execution]:
    """Return how the vehicle of a format carries out each transit of the plan that was made for it, by its name."""
    executes = execution_of(to)
    if executes is None:
        return {}
    return {phase.name: executes(made) for phase, made in zip(mission.transits, plan.transits, strict=True)}


def plan_if_any(mission: Mission, means: Scenario, seed: int) -> Plan | None:
    """Build the plan; None where the mission has no transit, or more nominal legs than it allows."""
    try:
        return mission_plan(mission, seed=seed, means=means) if mission.transits else None
    except InputError:
        return None


def _fences(means: Scenario) -> Iterator[Fence]:
    """Yield land and zones kept out of, a polygon each."""
    site = means.mission.site
    if site is None or site.origin is None or means.place is None:
        return
    origin = site.origin

    def corners(ring: Iterable[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
        east, north = np.array(list(ring))[:-1, :2].T
        return tuple(zip(*(axis.tolist() for axis in to_geographic(east, north, origin)), strict=True))

    for zone in means.place.zones:
        for part in getattr(zone.geometry, "geoms", (zone.geometry,)):
            yield Fence(
                name=zone.name,
                outline=corners(part.exterior.coords),
                kind="land" if zone.is_land else "keep-out",
                holes=tuple(corners(hole.coords) for hole in part.interiors),
                since=zone.since,
                until=zone.until,
                above=zone.above,
                below=zone.below,
            )


def _notes(mission: Mission) -> Iterator[str]:
    way = mission.navigation.drift_compensation if mission.navigation else "none"
    if way != "none":
        yield (
            f"the mission corrects its course for drift ({way}) from fix to fix; courses and waypoints here are those "
            "without drift, and the vehicle's own navigation has to correct them"
        )
    names = {phase.name: phase.label for phase in mission.phases}
    split = (path.split(".", 1) for path in mission.uncertain())
    uncertain = [f"{names[first]}.{rest[0]}" for first, *rest in split if first in names]
    if uncertain:
        yield f"uncertain quantities are at their means: {', '.join(uncertain)}"


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
        Name of the format, of `missionplan.exporters.FORMATS`.
    out : str or Path, optional
        The file; of a format of several files, or where a folder of that name exists, the folder. Default: named after
        the mission file, in the working directory.
    seed : int, optional
        Of the trials from which the time-outs are taken; default: the mission's.
    force : bool
        Write over files of the same names; never over a file that the mission was read from.

    Raises
    ------
    InputError
        When the mission lacks what its phases or the format need, or a file is there already: nothing is written then.
    RunError
        When a file cannot be written.
    """
    mission = check_arguments(mission, seed=seed, one_of={"to": (to, tuple(FORMATS))})
    check_complete(mission)
    navigation_of(mission)
    form = format_named(to)
    if form.NEEDS_ORIGIN:
        required_origin(mission, f"positions on Earth, which the format {to} has, need it")
    means = Scenario.at_means(mission, recorded_current(mission))
    check_cover(mission, means)
    plan = mission_plan(mission, seed=seed, means=means, to=to)
    stem = Path(mission.file).stem or "mission"
    written = form.files(plan, stem)
    place = as_path(out, "out") if out is not None else None
    folder = place or Path(f"{stem}-{to}" if len(written) > 1 else "")
    places = [folder / name for name in written]
    if len(written) == 1 and place is not None and not is_folder(place):
        places = [place]
    _check(places, mission, force=force)
    for path, content in zip(places, written.values(), strict=True):
        write_atomically(path, content)
    return ExportedPlan(tuple(places), plan.notes, form.lost(plan))


def _check(places: list[Path], mission: Mission, *, force: bool) -> None:
    """Refuse places that hold what is not to be lost."""
    sources = {path.resolve() for path in mission.sources}
    problems = []
    for path in places:
        folder = path.parent
        if path.resolve() in sources:
            hint = "name another place with out"
            problems.append(Problem("is read by this command and is not replaced", str(path), hint=hint))
        elif exists(path) and not is_file(path):
            problems.append(Problem("is no file that could be written over", str(path)))
        elif exists(path) and not force:
            problems.append(Problem("is there already", str(path), hint="force=True writes over it"))
        elif exists(folder) and not is_folder(folder):
            problems.append(Problem("is a file; a folder was expected", str(folder)))
    if problems:
        raise InputError(problems)
