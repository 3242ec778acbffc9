"""The sections of a mission that one kind of phase needs: checked once, so that none of them is None."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from missionplan.errors import InputError, Problem
from missionplan.mission.mission import Mission
from missionplan.mission.schema import V
from missionplan.mission.schema.manoeuvring import Manoeuvring, TransitionPhase
from missionplan.mission.schema.phases import MoorPhase, Navigation, Phase, TransitPhase
from missionplan.mission.schema.place import Geographic
from missionplan.mission.schema.site import CurrentFile, ForecastError, Site, TidalCurrent
from missionplan.mission.schema.vehicle import Anchor, Vehicle

_Phase = TypeVar("_Phase", bound="Phase[object]")
_At = TypeVar("_At")
_Section = TypeVar("_Section")


def required(section: _Section | None, mission: Mission[object], key: str, reason: str) -> _Section:
    """Return a section of a mission, or raise InputError with its key path and the reason why it is needed."""
    if section is None:
        raise InputError(_missing(mission, reason, {key: None}))
    return section


def required_origin(mission: Mission[object], reason: str) -> Geographic:
    """Return the site's origin, or raise InputError with the reason why it is needed."""
    return required(mission.site.origin if mission.site else None, mission, "site.origin", reason)


def forecast_error(mission: Mission[_At]) -> ForecastError[_At] | None:
    """Return what a mission says of the error of its forecast of the current; None where it says nothing."""
    current = mission.site.current if mission.site else None
    return current.error if isinstance(current, CurrentFile | TidalCurrent) else None


def navigation_of(mission: Mission[_At]) -> Navigation[_At]:
    """Return how the transits of a mission navigate.

    Raises InputError with everything that transits need and the mission lacks.
    """
    problems, navigation = missing_for_transits(mission), mission.navigation
    if problems or navigation is None:
        raise InputError(problems)
    return navigation


def transit_of(mission: Mission[_At], name: str | None = None) -> TransitPhase[_At]:
    """Return the transit of that name, by default the first; raises as `navigation_of`, or where there is none."""
    navigation_of(mission)
    return _named(mission.transits, name, "a transit")


@dataclass(frozen=True)
class MooringMission(Generic[V]):
    """A mission with at least one mooring and what its descent needs."""

    mission: Mission[V]
    vehicle: Vehicle[V]
    mass: V
    """The vehicle's."""
    anchor: Anchor[V]
    """With a flooded mass or a construction."""
    site: Site[V]
    depth: V | float
    """The site's; nan where it has none and `of` was called with `depth=False`."""

    @classmethod
    def of(cls, mission: Mission[_At], *, depth: bool = True) -> "MooringMission[_At]":
        """Check a mission.

        Raises InputError with everything that is missing.

        The site's `depth` may not be needed: data of dives bring their own.
        """
        problems, vehicle, site = missing_for_moorings(mission, depth=depth), mission.vehicle, mission.site
        if problems or vehicle is None or vehicle.mass is None or vehicle.anchor is None:
            raise InputError(problems)
        if site is None or site.water is None:
            raise InputError(problems)
        site_depth = math.nan if site.depth is None else site.depth
        return MooringMission(mission, vehicle, vehicle.mass, vehicle.anchor, site, site_depth)

    def mooring(self, name: str | None = None) -> MoorPhase[V]:
        """Return the mooring of that name, by default the first; InputError where there is none."""
        return _named(self.mission.moors, name, "a mooring")


@dataclass(frozen=True)
class TransitionMission(Generic[V]):
    """A mission with at least one transition from survey speed to hover, and what transitions need."""

    mission: Mission[V]
    vehicle: Vehicle[V]
    mass: V
    """The vehicle's."""
    manoeuvring: Manoeuvring[V]

    @classmethod
    def of(cls, mission: Mission[_At]) -> "TransitionMission[_At]":
        """Check a mission.

        Raises InputError with everything that is missing.
        """
        problems, vehicle = missing_for_transitions(mission), mission.vehicle
        if problems or vehicle is None or vehicle.mass is None or vehicle.manoeuvring is None:
            raise InputError(problems)
        return TransitionMission(mission, vehicle, vehicle.mass, vehicle.manoeuvring)

    def transition(self, name: str | None = None) -> TransitionPhase[V]:
        """Return the transition of that name, by default the first; InputError where there is none."""
        return _named(self.mission.transitions, name, "a transition")


def missing_for_transits(mission: Mission[object]) -> list[Problem]:
    """List what a mission lacks to run transits."""
    return _no_phase(mission, mission.transits, "transit") + _missing(
        mission, "a transit needs it", {"navigation": mission.navigation}
    )


def missing_for_moorings(mission: Mission[object], *, depth: bool = True) -> list[Problem]:
    """List what a mission lacks to run moorings; `depth` as for `MooringMission.of`."""
    vehicle, site = mission.vehicle, mission.site
    anchor = vehicle.anchor if vehicle else None
    deep = None if site is None else site.bathymetry if site.depth is None else site.depth
    needed = {
        "site.depth": deep if depth else True,
        "site.water": site.water if site else None,
        "vehicle": vehicle,
        "vehicle.mass": vehicle.mass if vehicle else None,
        "vehicle.anchor": anchor,
    }
    problems = _no_phase(mission, mission.moors, "mooring") + _missing(mission, "a mooring needs it", needed)
    if anchor and anchor.flooded_mass is None and anchor.construction is None:
        reason = "a descent needs it where no construction is given"
        problems += _missing(mission, reason, {"vehicle.anchor.flooded_mass": None})
    return problems


def missing_for_transitions(mission: Mission[object]) -> list[Problem]:
    """List what a mission lacks to run transitions."""
    vehicle, site = mission.vehicle, mission.site
    needed = {
        "site.water": site.water if site else None,
        "vehicle": vehicle,
        "vehicle.manoeuvring": vehicle.manoeuvring if vehicle else None,
        "vehicle.mass": vehicle.mass if vehicle else None,
    }
    return _no_phase(mission, mission.transitions, "transition") + _missing(mission, "a transition needs it", needed)


def _no_phase(mission: Mission[object], phases: Sequence[object], kind: str) -> list[Problem]:
    return [] if phases else [Problem(f"the mission has no {kind}", mission.file, key="phases")]


def _missing(mission: Mission[object], reason: str, needed: Mapping[str, object]) -> list[Problem]:
    """Problems of the keys that are None."""
    return [Problem(f"missing; {reason}", mission.file, key=key) for key, value in needed.items() if value is None]


def _named(phases: tuple[_Phase, ...], name: str | None, kind: str) -> _Phase:
    """Return the phase of that name, by default the first."""
    choices = {phase.name: phase for phase in phases} | {phase.label: phase for phase in phases}
    if name is None:
        return phases[0]
    if name not in choices:
        raise InputError([Problem(f"given {name!r}, expected {kind}: {', '.join(choices)}", key="phase")])
    return choices[name]
