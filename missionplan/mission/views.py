"""A mission with the sections that one kind of phase needs: checked once, so that none of their fields is None."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from missionplan.errors import InputError, Problem
from missionplan.mission.mission import Mission
from missionplan.mission.schema.navigation import Navigation
from missionplan.mission.schema.phases import MoorPhase, TransitPhase
from missionplan.mission.schema.site import CurrentFile, ForecastError, Geographic, Site, TidalCurrent
from missionplan.mission.schema.transition import Manoeuvring, TransitionPhase
from missionplan.mission.schema.vehicle import Anchor, Vehicle

_Phase = TypeVar("_Phase", TransitPhase, MoorPhase, TransitionPhase)
_Section = TypeVar("_Section")


def required(section: _Section | None, mission: Mission, key: str, reason: str) -> _Section:
    """Return a section of a mission, or raise InputError with its key path and the reason why it is needed."""
    if section is None:
        raise InputError(_missing(mission, reason, {key: None}))
    return section


def required_origin(mission: Mission, reason: str) -> Geographic:
    """Return the site's origin, or raise InputError with the reason why it is needed."""
    return required(mission.site.origin if mission.site else None, mission, "site.origin", reason)


def forecast_error(mission: Mission) -> ForecastError | None:
    """Return what a mission says of the error of its forecast of the current; None where it says nothing."""
    current = mission.site.current if mission.site else None
    return current.error if isinstance(current, CurrentFile | TidalCurrent) else None


@dataclass(frozen=True)
class TransitMission:
    """A mission with at least one transit and what transits need.

    Attributes
    ----------
    mission : Mission
    transits : tuple of TransitPhase
        One or more.
    navigation : Navigation
    """

    mission: Mission
    transits: tuple[TransitPhase, ...]
    navigation: Navigation

    @classmethod
    def of(cls, mission: Mission) -> "TransitMission":
        """Check a mission.

        Raises
        ------
        InputError
            With everything that is missing.
        """
        problems, navigation = missing_for_transits(mission), mission.navigation
        if problems or navigation is None:
            raise InputError(problems)
        return cls(mission, mission.transits, navigation)

    def transit(self, name: str | None = None) -> TransitPhase:
        """Return the transit of that name, by default the first; InputError where there is none."""
        return _named(self.transits, name, "a transit")


@dataclass(frozen=True)
class MooringMission:
    """A mission with at least one mooring and what its descent needs.

    Attributes
    ----------
    mission : Mission
    moors : tuple of MoorPhase
        One or more.
    vehicle : Vehicle
        With a mass.
    anchor : Anchor
        With a flooded mass or a construction.
    site : Site
        With water, and with a depth unless `of` was called with `depth=False`.
    """

    mission: Mission
    moors: tuple[MoorPhase, ...]
    vehicle: Vehicle
    anchor: Anchor
    site: Site

    @classmethod
    def of(cls, mission: Mission, *, depth: bool = True) -> "MooringMission":
        """Check a mission.

        Parameters
        ----------
        mission : Mission
        depth : bool
            Whether the site's depth is needed; data of dives bring their own.

        Raises
        ------
        InputError
            With everything that is missing.
        """
        problems, vehicle, site = missing_for_moorings(mission, depth=depth), mission.vehicle, mission.site
        if problems or vehicle is None or vehicle.anchor is None or site is None:
            raise InputError(problems)
        return cls(mission, mission.moors, vehicle, vehicle.anchor, site)

    def mooring(self, name: str | None = None) -> MoorPhase:
        """Return the mooring of that name, by default the first; InputError where there is none."""
        return _named(self.moors, name, "a mooring")


@dataclass(frozen=True)
class TransitionMission:
    """A mission with at least one transition from survey speed to hover, and what transitions need.

    Attributes
    ----------
    mission : Mission
    transitions : tuple of TransitionPhase
        One or more.
    vehicle : Vehicle
        With a mass.
    manoeuvring : Manoeuvring
    """

    mission: Mission
    transitions: tuple[TransitionPhase, ...]
    vehicle: Vehicle
    manoeuvring: Manoeuvring

    @classmethod
    def of(cls, mission: Mission) -> "TransitionMission":
        """Check a mission.

        Raises
        ------
        InputError
            With everything that is missing.
        """
        problems, vehicle = missing_for_transitions(mission), mission.vehicle
        if problems or vehicle is None or vehicle.manoeuvring is None:
            raise InputError(problems)
        return cls(mission, mission.transitions, vehicle, vehicle.manoeuvring)

    def transition(self, name: str | None = None) -> TransitionPhase:
        """Return the transition of that name, by default the first; InputError where there is none."""
        return _named(self.transitions, name, "a transition")


@dataclass(frozen=True)
class ExplainedMission:
    """A mission in which one explanation is known to hold.

    Attributes
    ----------
    causes : tuple of str
        Its effects; empty for none.
    probability : float
        As the mission gives it.
    mission : Mission
    """

    causes: tuple[str, ...]
    probability: float
    mission: Mission


def under_each_explanation(mission: Mission) -> tuple[ExplainedMission, ...]:
    """Return the mission under each explanation of each doubt, the other doubts as they are; none without doubts."""
    return tuple(
        ExplainedMission(causes, share, mission.knowing(doubt.place, number))
        for doubt in mission.doubts
        if doubt.known is None
        for number, (causes, share) in enumerate(zip(doubt.causes, doubt.probabilities, strict=True))
    )


def missing_for_transits(mission: Mission) -> list[Problem]:
    """List what a mission lacks to run transits."""
    return _no_phase(mission, mission.transits, "transit") + _missing(
        mission, "a transit needs it", {"navigation": mission.navigation}
    )


def missing_for_moorings(mission: Mission, *, depth: bool = True) -> list[Problem]:
    """List what a mission lacks to run moorings; `depth` as for `MooringMission.of`."""
    vehicle, site = mission.vehicle, mission.site
    anchor = vehicle.anchor if vehicle else None
    needed = {
        "site.depth": (site and site.depth) if depth else True,
        "site.water": site and site.water,
        "vehicle": vehicle,
        "vehicle.mass": vehicle and vehicle.mass,
        "vehicle.anchor": anchor,
    }
    problems = _no_phase(mission, mission.moors, "mooring") + _missing(mission, "a mooring needs it", needed)
    if anchor and anchor.flooded_mass is None and anchor.construction is None:
        reason = "a descent needs it where no construction is given"
        problems += _missing(mission, reason, {"vehicle.anchor.flooded_mass": None})
    return problems


def missing_for_transitions(mission: Mission) -> list[Problem]:
    """List what a mission lacks to run transitions."""
    vehicle, site = mission.vehicle, mission.site
    needed = {
        "site.water": site and site.water,
        "vehicle": vehicle,
        "vehicle.manoeuvring": vehicle and vehicle.manoeuvring,
        "vehicle.mass": vehicle and vehicle.mass,
    }
    return _no_phase(mission, mission.transitions, "transition") + _missing(mission, "a transition needs it", needed)


def _no_phase(mission: Mission, phases: Sequence[object], kind: str) -> list[Problem]:
    return [] if phases else [Problem(f"the mission has no {kind}", mission.file, key="phases")]


def _missing(mission: Mission, reason: str, needed: Mapping[str, object]) -> list[Problem]:
    """Problems of the keys that are None."""
    return [Problem(f"missing; {reason}", mission.file, key=key) for key, value in needed.items() if value is None]


def _named(phases: tuple[_Phase, ...], name: str | None, kind: str) -> _Phase:
    """Return the phase of that name, by default the first."""
    found = {phase.name: phase for phase in phases} | {phase.label: phase for phase in phases}
    if name is None:
        return phases[0]
    if name not in found:
        raise InputError([Problem(f"given {name!r}, expected {kind}: {', '.join(found)}", key="phase")])
    return found[name]
