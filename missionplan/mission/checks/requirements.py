"""What requirements may ask for: the quantities and events of each kind of phase, and their units."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from missionplan.errors import LocalProblem, did_you_mean
from missionplan.mission.schema.phases import Phase
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.sweep import Requirement
from missionplan.mission.units import QuantityError

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
    "transition": {
        "depth_excursion": "m",
        "pitch_excursion": "rad",
        "hover_time": "s",
        "duration": "s",
        "energy": "J",
    },
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


def misspelt_requirements(data: Mapping[str, object]) -> list[LocalProblem]:
    """List the quantities of requirements that no phase has, in a mission's data that are otherwise not valid."""
    entries, requirements = data.get("phases"), data.get("requirements")
    if not isinstance(entries, list) or not isinstance(requirements, list):
        return []
    phases = [name for entry in entries if (name := _phase_name(entry)) is not None]
    if len(phases) < len(entries):
        return []
    return [
        problem.within(("requirements", index))
        for index, requirement in enumerate(requirements)
        for problem in _misspelt(requirement, phases)
    ]


def _misspelt(requirement: object, phases: Sequence[PhaseName]) -> Sequence[LocalProblem]:
    """Return the problem of a requirement whose quantity no phase has, where it has a quantity to read."""
    quantity = requirement.get("quantity") if isinstance(requirement, dict) else None
    if not isinstance(quantity, str):
        return ()
    try:
        quantity_unit(quantity, phases)
    except QuantityError as error:
        return error.problems
    return ()


def _phase_name(entry: object) -> PhaseName | None:
    """Return name and kind of a phase as written; None where it is none."""
    kind, section = next(iter(entry.items())) if isinstance(entry, dict) and len(entry) == 1 else ("", None)
    if kind not in QUANTITIES or not isinstance(section, dict):
        return None
    return PhaseName(str(section.get("name", kind)), str(kind))


def quantity_unit(quantity: str, phases: Sequence[Phase | PhaseName]) -> str | None:
    """Return the SI unit of a phase's quantity, such as ``moor.offset``; None for an event.

    Raises
    ------
    QuantityError
        When the mission has no such phase, or the phase no such quantity.
    """
    kinds = {phase.name: phase.kind for phase in phases} | {"total": "total"}
    phase, _, name = quantity.rpartition(".")
    if phase not in kinds:
        hint = did_you_mean(phase, kinds, before="; ")
        raise QuantityError(f"given {phase!r}, expected a phase: {', '.join(kinds)}{hint}", ("quantity",))
    events, quantities = EVENTS[kinds[phase]], QUANTITIES[kinds[phase]]
    if name in events:
        return None
    if name not in quantities:
        known = [*events, *quantities]
        hint = did_you_mean(name, known, before="; ")
        raise QuantityError(f"given {name!r}, expected one of {', '.join(known)}{hint}", ("quantity",))
    return quantities[name]


def _with_bound(requirement: Requirement, phases: Sequence[Phase]) -> Requirement:
    """Read one requirement's bound.

    Raises
    ------
    QuantityError
        With the keys of the requirement that are wrong.
    """
    unit = quantity_unit(requirement.quantity, phases)
    owner, _, name = requirement.quantity.rpartition(".")
    needed = (_NEEDED.get(name, "name"), "line_material") if name in _NEEDED else ("name",)
    if any(phase.name == owner and all(getattr(phase, key) is None for key in needed) for phase in phases):
        raise QuantityError(f"{name} needs {' or '.join(needed)} in {owner}", ("quantity",))
    given = [key for key in _BOUNDS if getattr(requirement, key) is not None]
    if unit is None:
        if given:
            message = f"{name} is an event: give only its probability"
            raise QuantityError([LocalProblem((key,), message) for key in given])
        return requirement
    if len(given) != 1:
        raise QuantityError(f"{name} needs either at_most or at_least", ("quantity",))
    try:
        bound = QuantityParser(unit, fixed=True).parse(getattr(requirement, given[0]))
    except QuantityError as error:
        raise QuantityError([problem.within((given[0],)) for problem in error.problems]) from None
    return requirement.model_copy(update={given[0]: bound})
