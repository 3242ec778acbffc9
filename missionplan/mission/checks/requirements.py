"""What requirements may ask for: the quantities and events of each kind of phase, and their units."""

from difflib import get_close_matches
from typing import Any

from pydantic_core import PydanticCustomError

from missionplan.mission.schema.phases import Phase
from missionplan.mission.units import QuantityParser

EVENTS: dict[str, tuple[str, ...]] = {
    "transit": ("arrived",),
    "moor": ("within_radius", "struck_seafloor"),
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
        "offset": "m",
        "target_offset": "m",
        "lowest_altitude": "m",
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


def check_requirement(item: dict[str, Any], phases: tuple[Phase, ...]) -> tuple[dict[str, Any], list[tuple[str, str]]]:
    """Check one requirement against the phases of the mission and read its bound.

    Parameters
    ----------
    item : dict
        The requirement's `quantity`, `at_most`, `at_least`.
    phases : tuple
        Phases of the mission.

    Returns
    -------
    bounds, problems : dict, list of (key, message)
        `at_most` or `at_least` in SI; what is wrong, by key of the requirement.
    """
    kinds = {phase.name: phase.kind for phase in phases} | {"total": "total"}
    phase, _, name = str(item.get("quantity", "")).partition(".")
    if phase not in kinds:
        return {}, [("quantity", f"given {phase!r}, expected a phase: {', '.join(kinds)}{_near(phase, list(kinds))}")]
    kind = kinds[phase]
    events, quantities = EVENTS[kind], QUANTITIES[kind]
    bounds = [key for key in ("at_most", "at_least") if item.get(key) is not None]
    if name in events:
        return {}, [(key, f"{name} happens or not: give its probability alone") for key in bounds]
    if name not in quantities:
        known = [*events, *quantities]
        return {}, [("quantity", f"given {name!r}, expected one of {', '.join(known)}{_near(name, known)}")]
    if len(bounds) != 1:
        return {}, [("quantity", f"{name} needs either at_most or at_least")]
    try:
        return {bounds[0]: QuantityParser(quantities[name], fixed=True)(item[bounds[0]])}, []
    except PydanticCustomError as error:
        return {}, [(bounds[0], str((error.context or {})["words"]))]


def _near(name: str, known: list[str]) -> str:
    close = get_close_matches(name, known, n=1)
    return f"; did you mean {close[0]}?" if close else ""
