"""What sections that are each valid say against each other: phases, site, correlations."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from missionplan.errors import KeyPath, LocalProblem, did_you_mean, shown
from missionplan.mission.schema.effect_list import Learned, OneOf
from missionplan.mission.schema.phases import MoorPhase, Navigation, Phase, TransitPhase
from missionplan.mission.schema.site import CurrentLayer, Geographic, Site, TidalCurrent
from missionplan.mission.schema.sweep import CorrelationSection, SweepSection
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.montecarlo.distributions import Quantity
from missionplan.montecarlo.draws import correlation_problems
from missionplan.physics.tides import constituent_names


def check_correlations(
    correlations: Sequence[CorrelationSection],
    quantities: Mapping[str, Quantity],
    doubts: Sequence[OneOf | Learned] = (),
) -> list[LocalProblem]:
    """List what keeps a mission's quantities, given by key path, from having these correlations.

    Those of an explanation are written in it: one matrix then holds together at a time.
    """
    problems = [
        LocalProblem((number, "between", side), f"{name} belongs to an explanation", "its own `correlations` hold it")
        for number, correlation in enumerate(correlations)
        for side, name in enumerate(correlation.between)
        if any(name.startswith(doubt.place) for doubt in doubts)
    ]
    problems = problems or correlation_problems(quantities, [correlation.pair for correlation in correlations])
    return [problem.within(("correlations",)) for problem in problems]


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


_MAIN = ("M2", "S2", "N2", "K2", "K1", "O1", "P1", "Q1", "M4")
"""Constituents that an unknown name may have meant."""
_TOLERANCE = 1e-6
"""By which the layers may end above the seafloor [m]."""


def check_site(site: Site | None, phases: Sequence[Phase]) -> list[LocalProblem]:
    """List what is wrong with the layers or constituents of the current; none where it comes from a file."""
    if site is not None and isinstance(site.current, TidalCurrent):
        return list(_constituents(site.current))
    if site is None or not isinstance(site.current, tuple):
        return []
    return [*_layers(site, site.current), *_design_currents(phases, len(site.current))]


def _layers(site: Site, layers: Sequence[CurrentLayer]) -> Iterator[LocalProblem]:
    above = 0.0
    for index, layer in enumerate(layers):
        if isinstance(layer.down_to, float):
            if layer.down_to <= above:
                message = "layers go from the surface down; this one ends above the last"
                yield LocalProblem(("site", "current", index, "down_to"), message)
            above = layer.down_to
    if isinstance(site.depth, float) and 0.0 < above < site.depth - _TOLERANCE:
        message = f"the deepest layer ends at {above:.4g} m, the seafloor is at {site.depth:.6g} m"
        yield LocalProblem(("site", "current"), message)


def _constituents(current: TidalCurrent) -> Iterator[LocalProblem]:
    known = constituent_names()
    for row, depth in enumerate(current.tide.depths):
        for column, wave in enumerate(depth.constituents):
            path = ("site", "current", "tide", "depths", row, "constituents", column, "name")
            if wave.name not in known:
                hint = did_you_mean(wave.name.upper(), known) or f"such as {', '.join(_MAIN)}"
                yield LocalProblem(path, f"given {shown(wave.name)}, which is no constituent that UTide knows", hint)
            elif wave.name in (each.name for each in depth.constituents[:column]):
                yield LocalProblem(path, f"given {shown(wave.name)} a second time at this depth")


def _design_currents(phases: Sequence[Phase], layers: int) -> Iterator[LocalProblem]:
    for index, phase in enumerate(phases):
        given = phase.design_current if isinstance(phase, MoorPhase) else None
        if isinstance(given, tuple) and len(given) != layers:
            message = f"has {len(given)} speeds; site.current has {layers} layers"
            yield LocalProblem((*phase_path(index, phase), "design_current"), message)
