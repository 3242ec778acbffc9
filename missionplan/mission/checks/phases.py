"""Phases against each other and against the sections that they need."""

from collections import Counter
from collections.abc import Iterator, Sequence

from missionplan.errors import KeyPath, LocalProblem, shown
from missionplan.mission.schema.navigation import Navigation
from missionplan.mission.schema.phases import Phase, TransitPhase
from missionplan.mission.schema.site import Geographic, Site
from missionplan.mission.schema.sweep import SweepSection
from missionplan.mission.schema.vehicle import Vehicle


def check_phases(
    phases: Sequence[Phase],
    site: Site | None,
    vehicle: Vehicle | None,
    navigation: Navigation | None,
    sweep: SweepSection,
) -> list[LocalProblem]:
    """List what is wrong with names, positions and speeds of the phases, and with the phase that is swept."""
    problems: list[LocalProblem] = []
    counts = Counter(phase.label for phase in phases)
    for index, phase in enumerate(phases):
        found: list[LocalProblem] = []
        if phase.label == "total" or counts[phase.label] > 1:
            found.append(LocalProblem(("name",), f"given {shown(phase.label)}; each phase needs a name of its own"))
        if isinstance(phase, TransitPhase):
            found += _start(phase, is_first=index == 0)
            found += _positions(phase, site)
            found += _shaft_rate(phase, site, vehicle)
            if navigation is None:
                found.append(LocalProblem((), "a transit needs the section `navigation`"))
        problems += [problem.within(phase_path(index, phase)) for problem in found]
    return [*problems, *_swept(sweep, [phase.name for phase in phases if isinstance(phase, TransitPhase)])]


def phase_path(index: int, phase: Phase) -> KeyPath:
    """Return the key path of a phase in the file."""
    return ("phases", index, phase.kind)


def _start(phase: TransitPhase, *, is_first: bool) -> Iterator[LocalProblem]:
    if is_first and phase.start is None:
        yield LocalProblem(("from",), "missing; the first transit needs its start")
    if not is_first and phase.start is not None:
        yield LocalProblem(("from",), "only the first phase has `from`; later ones start where the last one ended")


def _positions(phase: TransitPhase, site: Site | None) -> Iterator[LocalProblem]:
    if site is not None and site.origin is not None:
        return
    for key, position in (("from", phase.start), ("to", phase.to)):
        if isinstance(position, Geographic):
            yield LocalProblem((key,), "given latitude and longitude, but the mission has no site.origin")


def _shaft_rate(phase: TransitPhase, site: Site | None, vehicle: Vehicle | None) -> Iterator[LocalProblem]:
    has_propeller = vehicle is not None and vehicle.propulsion is not None
    has_water = site is not None and site.water is not None
    if phase.shaft_rate is not None and not (has_propeller and has_water):
        yield LocalProblem(("shaft_rate",), "a speed from the shaft rate needs vehicle.propulsion and site.water")


def _swept(sweep: SweepSection, names: Sequence[str]) -> Iterator[LocalProblem]:
    if sweep.phase is not None and sweep.phase not in names:
        yield LocalProblem(("sweep", "phase"), f"given {sweep.phase!r}, expected a transit: {', '.join(names)}")
