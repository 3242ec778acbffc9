"""`validate`: what missions, data sets and folders are good for, and every problem of theirs at once.

`data_sets` is imported when there is one: `validate` of a mission imports neither pandas nor scipy's larger parts.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path, PurePath

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem, attempted
from missionplan.mission import Mission, MissionOrPath, load
from missionplan.mission.quantity_paths import ValueInForce
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.mission.views import TransitionMission, navigation_of
from missionplan.phases.place import Cause, Contact, Place, Way
from missionplan.report.quantities import in_reader_units, reading_in, units_of
from missionplan.scenario.anchors import design_current
from missionplan.scenario.phases import moor_plan, room_in_depth
from missionplan.scenario.scenario import Scenario, leg_spread
from missionplan.scenario.ways import blocked
from missionplan.store.folder import as_path, is_folder
from missionplan.studies.leg_length import SweepScenario
from missionplan.studies.optimisation import read_lattice
from missionplan.studies.simulation import check_complete, cover_in_words, covered_means, input_notices, vehicle_notices


@dataclass(frozen=True)
class Readiness:
    """Whether one command can use a file."""

    command: str
    needs: tuple[str, ...] = ()
    """What is missing or wrong; none where it is ready."""
    without: str = ""
    """What a part of its answer needs, where it is ready."""

    def __str__(self) -> str:
        words = f"needs {'; '.join(self.needs)}" if self.needs else "ready"
        return f"{self.command:<17} {words}" + (f"; needs {self.without}" if self.without and not self.needs else "")


@dataclass(frozen=True)
class Validated:
    """What was found of one file or data set."""

    path: Path
    summary: str = ""
    """What it is."""
    values: tuple[ValueInForce, ...] = ()
    """Of a mission, what is in force of the keys that its vehicle file may give too."""
    table: tuple[Readiness, ...] = ()
    """What it is good for."""
    notices: tuple[str, ...] = ()
    """What is unusual."""
    problems: tuple[Problem, ...] = ()
    """What is wrong; then there is no more."""


_ORIGIN = "site.origin for formats with positions on Earth"
_CONSTRUCTION = "vehicle.anchor.construction to say how the anchor is built"


def needs(check: Callable[[], object]) -> tuple[str, ...]:
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


def validated_mission(path: Path, mission: Mission) -> Validated:
    """Check a mission that has been read.

    Raises InputError when the current cannot be read or does not cover the mission, a nominal dive is impossible, or
    what may be chosen is wrong.
    """
    wrong: list[Problem] = []
    if mission.optimise.choose:
        attempted(partial(read_lattice, mission, ()), wrong)
    try:
        means = covered_means(mission)
        check_place(means)
    except InputError as error:
        raise InputError([*error.problems, *wrong]) from None
    if wrong:
        raise InputError(wrong)
    notices: list[str] = []

    def simulable() -> None:
        check_complete(mission)
        notices.extend((*vehicle_notices(mission, means), *input_notices(mission, means), *tracks_lost(means)))

    def sizable() -> None:
        for phase in means.mooring.mission.moors:
            design_current(means, phase)

    simulation = needs(simulable)
    placed = mission.site is not None and mission.site.origin is not None
    anchor = mission.vehicle.anchor if mission.vehicle else None
    built = anchor is None or anchor.construction is not None
    legs = needs(lambda: SweepScenario.of(mission, means))
    table = (
        Readiness("simulate", simulation),
        Readiness("export", needs(lambda: navigation_of(mission)), "" if placed else _ORIGIN),
        Readiness("sweep-dmax", legs),
        Readiness("plan-legs", legs),
        Readiness("size-anchor", needs(sizable), "" if built else _CONSTRUCTION),
        Readiness("sweep-transition", needs(lambda: TransitionMission.of(mission))),
        Readiness(
            "optimise",
            simulation or (() if mission.requirements else ("requirements",)),
            "" if mission.optimise.choose else "optimise.choose in the mission, or --choose",
        ),
    )
    with reading_in(units_of(mission.raw)):
        summary = in_reader_units(f"{_contents(mission)}{cover_in_words(mission, means.recorded)}")
        told = tuple(map(in_reader_units, notices or mission.notices()))
    return Validated(path, summary, mission.values_in_force(), table, told)


def _contents(mission: Mission) -> str:
    kinds = ", ".join(phase.kind for phase in mission.phases) or "none"
    return f"valid. Phases: {kinds}; distributions: {len(mission.uncertain())}."


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
    inputs = [paths] if isinstance(paths, Mission | str | PurePath) else list(paths)
    sources = [
        source for one in inputs for source in ([one] if isinstance(one, Mission) else _expanded(as_path(one, "paths")))
    ]
    datasets = [source for source in sources if isinstance(source, Path) and is_folder(source)]
    done: list[Validated] = []
    valid: list[Mission] = []
    for source in sources:
        if source in datasets:
            continue
        path = Path(source.file) if isinstance(source, Mission) else source
        try:
            mission = source if isinstance(source, Mission) else load(source, allow_outside=allow_outside)
            done.append(validated_mission(path, mission))
        except InputError as error:
            done.append(Validated(path, problems=error.problems))
        else:
            valid.append(mission)
    if datasets:
        from missionplan.datasets import files_outside
        from missionplan.studies.data_sets import validated_dataset

        with files_outside(allowed=allow_outside):
            done += [validated_dataset(path, valid) for path in datasets]
    return tuple(done)


def _expanded(path: Path) -> Iterator[Path]:
    """Missions and data sets in a folder and below; what is neither stays, to be refused."""
    if not is_folder(path) or (path / "dataset.yaml").is_file():
        yield path
        return
    datasets = sorted(file.parent for file in path.rglob("dataset.yaml"))
    inside = [file for file in sorted((*path.rglob("*.yaml"), *path.rglob("*.yml"))) if file.parent not in datasets]
    missions = [file for file in inside if _is_mission(file)]
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


AHEAD = 400
"""Tracks that are drawn ahead."""
_REACH = 2.0
"""Half width, over the spread of a leg, of the strip in which a way may run: six standard deviations."""
_WORDS = {
    Cause.AGROUND: "the water is too shallow there",
    Cause.ON_LAND: "it lies on land",
    Cause.KEEP_OUT: "it lies in a zone kept out of",
    Cause.UNCHARTED: "no depth is known there",
}


def check_place(means: Scenario) -> None:
    """Refuse a mission of which no trial can reach a goal or a mooring.

    A goal is refused that itself cannot be; a way, when start and goal are not joined by water within a strip of six
    standard deviations of a leg's end to each side.

    Raises InputError with each goal, mooring and way.
    """
    if means.place is not None and (problems := list(_problems(means, means.place))):
        raise InputError(problems)


def _problems(means: Scenario, place: Place) -> Iterator[Problem]:
    file, here, is_clear = means.mission.file, np.zeros(2), True
    for phase in means.drawn.phases:
        if isinstance(phase, TransitPhase):
            points = list(_points(means, phase, here))
            for number, (key, point) in enumerate(points):
                is_start = key == "from" or not number
                if is_start and key != "from":
                    continue
                met = _at(place, point, 0.0 if is_start else float(phase.depth))
                if met != Cause.NONE:
                    is_clear = False
                    yield Problem(f"{_shown(point)}: {_WORDS[met]}", file, key=f"{phase.name}.{key}")
            if is_clear and means.mission.navigation is not None:
                yield from _ways(means, place, phase, [point for _, point in points])
            here, is_clear = points[-1][1], True
        elif isinstance(phase, MoorPhase):
            yield from _mooring(means, place, phase, here)


def _points(means: Scenario, phase: TransitPhase[Scalars], here: Array) -> Iterator[tuple[str, Array]]:
    """Start, points on the way and goal of a transit, with their keys."""
    yield ("from", means.position(phase.start).reshape(2)) if phase.start is not None else ("", here)
    for number, point in enumerate(means.ways(phase)):
        yield f"via[{number}]", point.reshape(2)
    yield "to", means.position(phase.to).reshape(2)


def _at(place: Place, point: Array, depth: float) -> Cause:
    """What a vehicle meets at a point, at a depth and at the surface; zones of some times do not count."""
    contact, here = Contact.none(1), point.reshape(2, 1)
    lasting = place.lasting()
    for at in (depth, 0.0):
        way = Way(here, here, np.zeros(1), np.zeros(1), at, at)
        contact.note(np.zeros(1, dtype=np.intp), lasting.meets(way), 0)
    return Cause(int(contact.cause[0]))


def _ways(means: Scenario, place: Place, phase: TransitPhase[Scalars], points: list[Array]) -> Iterator[Problem]:
    import shapely

    width, depth = max(_REACH * leg_spread(means, phase), 1.0), float(phase.depth)
    for start, end in pairwise(points):
        line = shapely.linestrings(np.stack((start, end)))
        strip = line.buffer(width)
        low, high = np.array(strip.bounds[:2]), np.array(strip.bounds[2:])
        water = strip.difference(blocked(place, low, high, depth, at_some_time=False))
        radius = float(phase.arrival_radius)
        parts = shapely.get_parts(water)
        from_start = shapely.distance(parts, shapely.points(start)) <= 1.0
        to_goal = shapely.distance(parts, shapely.points(end)) <= radius
        if not np.any(from_start & to_goal):
            message = (
                f"from {_shown(start)} to {_shown(end)} no water joins both ends within {width:.3g} m to each side, "
                f"six standard deviations of where a leg ends"
            )
            key = f"{phase.name}.to"
            yield Problem(message, means.mission.file, key=key, hint=f"{phase.name}.via: auto goes round")
            return


def _mooring(means: Scenario, place: Place, phase: MoorPhase[Scalars], here: Array) -> Iterator[Problem]:
    file, met = means.mission.file, _at(place, here, 0.0)
    if met != Cause.NONE:
        yield Problem(f"moors at {_shown(here)}: {_WORDS[met]}", file, key=phase.name)
        return
    water = float(place.water_at(here.reshape(2, 1), np.zeros(1))[0])
    if np.isfinite(water) and means.mission.vehicle is not None and means.mission.vehicle.anchor is not None:
        deep = means.at_depth(water)
        plan = moor_plan(deep, phase)
        if np.all(room_in_depth(plan.dive, plan.held.body.length) <= 0.0):
            message = f"moors at {_shown(here)}: line and vehicle are longer than the water is deep, {water:.3g} m"
            yield Problem(message, file, key=f"{phase.name}.line_length")


def _shown(point: Array) -> str:
    return f"[{point[0]:.6g} m, {point[1]:.6g} m]"


def tracks_lost(means: Scenario) -> tuple[str, ...]:
    """Notice of the tracks drawn ahead that meet ground, coast or a zone; none where the mission has no place."""
    if means.place is None:
        return ()
    # what simulates is loaded for missions with a place alone
    from missionplan.results.failures import MET
    from missionplan.studies.simulation.block_statistics import failures_by_step
    from missionplan.studies.simulation.trial_block import run_block

    seed = means.mission.monte_carlo.seed
    ahead = run_block(means.sampled(seed=seed, block=0, size=AHEAD), seed, 0, AHEAD, inputs=False)
    steps = failures_by_step(ahead)
    lost = {step: float(np.mean(failed)) for step, failed in steps.items() if step.name in MET.values()}
    words = ", ".join(f"{100.0 * share:.3g} % {step}" for step, share in lost.items() if share > 0.0)
    if not words:
        return (f"Of {AHEAD} tracks drawn ahead none meets ground, coast or a zone kept out of.",)
    return (f"Of {AHEAD} tracks drawn ahead {100.0 * sum(lost.values()):.3g} % would be lost: {words}.",)
