"""A mission beyond what reading it checks: its current, nominal dives and times, and what each command needs."""

from pathlib import Path

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.views import TransitionMission, TransitMission
from missionplan.scenario.anchors import design_current
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.leg_length.sweep_scenario import SweepScenario
from missionplan.studies.nominal_dive import check_dives
from missionplan.studies.optimisation.choosable import read_lattice
from missionplan.studies.simulation.checks import check_complete, input_notices
from missionplan.studies.simulation.record_cover import check_cover, cover_in_words
from missionplan.studies.validation.place import check_place, tracks_lost
from missionplan.studies.validation.readiness import Readiness, Validated, needs


def validated_mission(path: Path, mission: Mission) -> Validated:
    """Check a mission that has been read.

    Raises
    ------
    InputError
        When the current cannot be read or does not cover the mission, a nominal dive is impossible, or what may be
        chosen is wrong.
    """
    wrong = _wrong_choices(mission)
    try:
        means = Scenario.at_means(mission, recorded_current(mission))
        check_cover(mission, means)
        check_dives(means)
        check_place(means)
    except InputError as error:
        raise InputError([*error.problems, *wrong]) from None
    if wrong:
        raise InputError(wrong)
    notices: list[str] = []

    def simulable() -> None:
        check_complete(mission)
        notices.extend((*input_notices(mission, means), *tracks_lost(means)))

    simulation = needs(simulable)
    kinds = ", ".join(phase.kind for phase in mission.phases) or "none"
    legs = needs(lambda: SweepScenario.of(mission, means))
    table = (
        Readiness("simulate", simulation),
        Readiness("export", needs(lambda: TransitMission.of(mission)), _origin(mission)),
        Readiness("sweep-dmax", legs),
        Readiness("plan-legs", legs),
        Readiness("size-anchor", needs(lambda: _sizable(means)), _construction(mission)),
        Readiness("sweep-transition", needs(lambda: TransitionMission.of(mission))),
        Readiness("optimise", simulation or _requirements(mission), _choices(mission)),
    )
    summary = f"valid. Phases: {kinds}; {len(mission.uncertain())} quantities are distributions."
    summary += cover_in_words(mission, means.recorded)
    return Validated(path, summary, mission.values_in_force(), table, tuple(notices) or mission.notices())


def _origin(mission: Mission) -> str:
    placed = mission.site is not None and mission.site.origin is not None
    return "" if placed else "site.origin for formats with positions on Earth"


def _sizable(means: Scenario) -> None:
    """Refuse a mission whose anchors cannot be sized."""
    for phase in means.mooring.moors:
        design_current(means, phase)


def _construction(mission: Mission) -> str:
    anchor = mission.vehicle.anchor if mission.vehicle else None
    built = anchor is None or anchor.construction is not None
    return "" if built else "vehicle.anchor.construction to say how the anchor is built"


def _wrong_choices(mission: Mission) -> list[Problem]:
    """Everything wrong with what the mission says may be chosen."""
    try:
        if mission.optimise.choose:
            read_lattice(mission, ())
    except InputError as error:
        return list(error.problems)
    return []


def _requirements(mission: Mission) -> tuple[str, ...]:
    return () if mission.requirements else ("requirements",)


def _choices(mission: Mission) -> str:
    return "" if mission.optimise.choose else "optimise.choose in the mission, or --choose"
