"""What sections that are each valid say against each other: phases, site, correlations.

What requirements may ask for: the quantities and events of each kind of phase, and their units.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from missionplan.errors import KeyPath, LocalProblem, counted, did_you_mean, shown
from missionplan.mission.schema.effect_list import Learned, OneOf
from missionplan.mission.schema.phases import MoorPhase, Navigation, Phase, TransitPhase
from missionplan.mission.schema.place import Geographic
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.site import CurrentLayer, Site, TidalCurrent
from missionplan.mission.schema.sweep import CorrelationSection, Requirement, SweepSection
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.mission.units import QuantityError
from missionplan.montecarlo.distributions import Quantity
from missionplan.montecarlo.streams import correlation_problems
from missionplan.physics.water import constituent_names


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
        faults: list[LocalProblem] = []
        if phase.label == "total" or counts[phase.label] > 1:
            faults.append(LocalProblem(("name",), f"given {shown(phase.label)}; each phase needs a name of its own"))
        if isinstance(phase, TransitPhase):
            faults += _transit(phase, site, vehicle, is_first=index == 0)
            if navigation is None:
                faults.append(LocalProblem((), "a transit needs the section `navigation`"))
        problems += [problem.within(phase_path(index, phase)) for problem in faults]
    names = [phase.name for phase in phases if isinstance(phase, TransitPhase)]
    if sweep.phase is not None and sweep.phase not in names:
        message = f"given {sweep.phase!r}, expected a transit: {', '.join(names)}"
        problems.append(LocalProblem(("sweep", "phase"), message))
    return problems


def phase_path(index: int, phase: Phase) -> KeyPath:
    """Return the key path of a phase in the file."""
    return ("phases", index, phase.kind)


def _transit(
    phase: TransitPhase, site: Site | None, vehicle: Vehicle | None, *, is_first: bool
) -> Iterator[LocalProblem]:
    if is_first and phase.start is None:
        yield LocalProblem(("from",), "missing; the first transit needs its start")
    if not is_first and phase.start is not None:
        yield LocalProblem(("from",), "only the first phase has `from`; later ones start where the last one ended")
    for key, position in (("from", phase.start), ("to", phase.to)):
        if isinstance(position, Geographic) and (site is None or site.origin is None):
            yield LocalProblem((key,), "given latitude and longitude, but the mission has no site.origin")
    has_propeller = vehicle is not None and vehicle.propulsion is not None
    has_water = site is not None and site.water is not None
    if phase.shaft_rate is not None and not (has_propeller and has_water):
        yield LocalProblem(("shaft_rate",), "a speed from the shaft rate needs vehicle.propulsion and site.water")


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
    problems = list(_layers(site, site.current))
    for index, phase in enumerate(phases):
        speeds = phase.design_current if isinstance(phase, MoorPhase) else None
        if isinstance(speeds, tuple) and len(speeds) != len(site.current):
            message = f"has {counted(len(speeds), 'speed')}; site.current has {counted(len(site.current), 'layer')}"
            problems.append(LocalProblem((*phase_path(index, phase), "design_current"), message))
    return problems


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
    names = constituent_names()
    for row, depth in enumerate(current.tide.depths):
        for column, wave in enumerate(depth.constituents):
            path = ("site", "current", "tide", "depths", row, "constituents", column, "name")
            if wave.name not in names:
                hint = did_you_mean(wave.name.upper(), names) or f"such as {', '.join(_MAIN)}"
                yield LocalProblem(path, f"given {shown(wave.name)}, which is no constituent that UTide knows", hint)
            elif wave.name in (constituent.name for constituent in depth.constituents[:column]):
                yield LocalProblem(path, f"given {shown(wave.name)} a second time at this depth")


EVENTS: dict[str, tuple[str, ...]] = {
    "transit": ("arrived",),
    "moor": ("within_radius", "struck_seafloor", "anchor_holds", "grounded", "line_parts"),
    "transition": ("hovering",),
    "total": ("success",),
}
"""Events by kind of phase."""

QUANTITIES: dict[str, dict[str, str]] = {
    "transit": {"duration": "s", "surfacings": "", "distance": "m", "arrival_error": "m", "energy": "J"},
    "moor": {
        "release_time": "s",
        "payout_time": "s",
        "descent_time": "s",
        "terminal_velocity": "m/s",
        "touchdown_speed": "m/s",
        "offset": "m",
        "target_offset": "m",
        "lowest_altitude": "m",
        "nose_altitude": "m",
        "excursion": "m",
        "line_tension": "N",
        "snatch_tension": "N",
        "holding_margin": "",
        "ascent_time": "s",
        "duration": "s",
        "energy": "J",
    },
    "transition": {"depth_excursion": "m", "pitch_excursion": "rad", "hover_time": "s", "duration": "s", "energy": "J"},
    "total": {"duration": "s", "energy": "J"},
}
"""Quantities by kind of phase, with the SI unit in which they are compared."""

_NEEDED = {"snatch_tension": "line_stiffness", "line_parts": "line_strength"}
"""Keys of a mooring without which, and without `line_material`, it has no such quantity or event."""
_BOUNDS = ("at_most", "at_least")


def read_requirements(
    requirements: Sequence[Requirement], phases: Sequence[Phase]
) -> tuple[tuple[Requirement, ...], list[LocalProblem]]:
    """Read the bounds of requirements, whose units follow from the kinds of the phases that they name.

    Returns
    -------
    requirements, problems : tuple of Requirement, list of LocalProblem
        Those that are right, with bounds in SI; what is wrong with the others.
    """
    read: list[Requirement] = []
    problems: list[LocalProblem] = []
    for index, requirement in enumerate(requirements):
        try:
            read.append(_with_bound(requirement, phases))
        except QuantityError as error:
            problems += [problem.within(("requirements", index)) for problem in error.problems]
    return tuple(read), problems


class PhaseName(NamedTuple):
    """What requirements know of a phase."""

    name: str
    kind: str

    @property
    def label(self) -> str:
        """Its name, which here stands for it in key paths too."""
        return self.name


def misspelt_requirements(data: Mapping[str, object]) -> list[LocalProblem]:
    """List the quantities of requirements that no phase has, in a mission's data that are otherwise not valid."""
    entries, requirements = data.get("phases"), data.get("requirements")
    if not isinstance(entries, list) or not isinstance(requirements, list):
        return []
    phases: list[PhaseName] = []
    problems: list[LocalProblem] = []
    for entry in entries:
        kind, section = next(iter(entry.items())) if isinstance(entry, dict) and len(entry) == 1 else ("", None)
        if kind not in QUANTITIES or not isinstance(section, dict):
            return []
        phases.append(PhaseName(str(section.get("name", kind)), str(kind)))
    for index, requirement in enumerate(requirements):
        quantity = requirement.get("quantity") if isinstance(requirement, dict) else None
        if isinstance(quantity, str):
            try:
                quantity_unit(quantity, phases)
            except QuantityError as error:
                problems += [problem.within(("requirements", index)) for problem in error.problems]
    return problems


def quantity_unit(quantity: str, phases: Sequence[Phase | PhaseName]) -> str | None:
    """Return the SI unit of a phase's quantity, such as ``moor.offset``; None for an event.

    Raises QuantityError when the mission has no such phase, or the phase no such quantity.
    """
    kinds = {phase.name: phase.kind for phase in phases} | {"total": "total"}
    phase, _, name = quantity.rpartition(".")
    if phase not in kinds:
        choices = [*(phase.label for phase in phases), "total"]
        hint = did_you_mean(phase, choices, before="; ")
        raise QuantityError(f"given {phase!r}, expected a phase: {', '.join(choices)}{hint}", ("quantity",))
    events, quantities = EVENTS[kinds[phase]], QUANTITIES[kinds[phase]]
    if name in events:
        return None
    if name not in quantities:
        choices = [*events, *quantities]
        hint = did_you_mean(name, choices, before="; ")
        raise QuantityError(f"given {name!r}, expected one of {', '.join(choices)}{hint}", ("quantity",))
    return quantities[name]


def _with_bound(requirement: Requirement, phases: Sequence[Phase]) -> Requirement:
    """Read one requirement's bound.

    Raises QuantityError with the keys of the requirement that are wrong.
    """
    unit = quantity_unit(requirement.quantity, phases)
    owner, _, name = requirement.quantity.rpartition(".")
    needed = (_NEEDED.get(name, "name"), "line_material") if name in _NEEDED else ("name",)
    if any(phase.name == owner and all(getattr(phase, key) is None for key in needed) for phase in phases):
        raise QuantityError(f"{name} needs {' or '.join(needed)} in {owner}", ("quantity",))
    keys = [key for key in _BOUNDS if getattr(requirement, key) is not None]
    if unit is None:
        if keys:
            message = f"{name} is an event: give only its probability"
            raise QuantityError([LocalProblem((key,), message) for key in keys])
        return requirement
    if len(keys) != 1:
        raise QuantityError(f"{name} needs either at_most or at_least", ("quantity",))
    try:
        bound = QuantityParser(unit, fixed=True).parse(getattr(requirement, keys[0]))
    except QuantityError as error:
        raise QuantityError([problem.within((keys[0],)) for problem in error.problems]) from None
    return requirement.model_copy(update={keys[0]: bound})
