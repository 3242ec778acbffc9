"""Which anchor? From the worst current to an anchor one can build, the dive it gives, and how often that is enough.

Read then `sizing` (one anchor, and dives with it) and `lightest_anchor` (the search).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Unpack

from missionplan.arrays import Scalars
from missionplan.errors import InputError, Problem, shown
from missionplan.mission import Mission, MissionOrPath
from missionplan.mission.schema.vehicle import Centre
from missionplan.mission.views import MooringMission
from missionplan.physics.anchor import AnchorDesign, wet_centre
from missionplan.physics.anchor_remedies import TrimState, Weight, trim
from missionplan.physics.water import STANDARD_GRAVITY
from missionplan.results import Provenance
from missionplan.results.anchor_sizing import AnchorSizing, DesignLayer, ExplainedAnchor, ProbableAnchor
from missionplan.results.decision import MemberOutcome
from missionplan.results.simulation import Outcome
from missionplan.results.sized_anchor import SizedAnchor
from missionplan.scenario.anchors import anchor_length, design_current, laden, overlap_height, worst_case_weight
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.anchor.lightest_anchor import Demand, lightest_anchor
from missionplan.studies.anchor.sizing import AnchorSizer, AnchorTrials
from missionplan.studies.held_vehicle import held_vehicle
from missionplan.studies.judgement import doubted, judged
from missionplan.studies.run import Run, RunArguments
from missionplan.studies.simulation import covered_means

HEAVIER = (1.005, 1.01, 1.02, 1.03, 1.05)
"""Factors by which an anchor is made heavier where fresh draws do not agree with those on which it was found."""


def size_anchor(
    mission: MissionOrPath,
    *,
    probability: float | None = None,
    phase: str | None = None,
    **run_as: Unpack[RunArguments],
) -> AnchorSizing:
    """Size the anchor of a mooring.

    Parameters
    ----------
    mission : Mission, str or Path
    probability : float, optional
        Share of the dives that must succeed, besides what the mission requires of the mooring.
    phase : str, optional
        Name of the mooring; default: the first.
    **run_as
        See `studies.run.RunArguments`; the trials done are those of the anchor that is being tried.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs, or the probability is not between 0 and 1.
    """
    run = Run.begun("size-anchor", mission, **run_as)
    mission = run.mission
    moor = MooringMission.of(mission).mooring(phase)
    _check_probability(probability)
    means = covered_means(mission)
    dives = AnchorTrials(mission, moor.name, means.recorded, run.trials, run.seed, run.workers)
    means = laden(means, means.moor(moor.name))
    sizer = AnchorSizer(means.moor(moor.name), means, dives)
    try:
        weight = worst_case_weight(sizer.means, sizer.moor)
        anchor = sizer.sized(weight)
        probable = sizer.probable(probability, weight)
        judge = partial(_judged, dives)
        outcome = judge(weight if probable is None or probable.anchor is None else probable.anchor.wet_weight)
        if probable is not None and probable.anchor is not None:
            probable, outcome = _confirmed(sizer, probable, probability, outcome, judge)
    except ValueError as error:
        raise InputError([Problem(str(error), mission.file, key="vehicle.anchor")]) from error
    options = {"probability": probability, "phase": phase, **run.workers.options}
    sizing = _anchor_sizing(run.provenance(options, mission.notices()), sizer, anchor, probable)
    if outcome is not None:
        sizing = replace(sizing, judged=doubted(mission, _with_anchor(dives, sizing.to_build.wet_weight), outcome))
    explained = tuple(_explained(sizing, dives, sizer.demands(probability), weight, run))
    return replace(sizing, explanations=explained, members=tuple(_members(sizing, dives, run)))


def _judged(dives: AnchorTrials, weight: float) -> Outcome | None:
    """Simulate the whole mission with an anchor of a wet weight [N], on fresh draws."""
    values = _with_anchor(dives, weight)
    jobs = dives.workers.jobs
    return judged(dives.mission, values, trials=dives.trials, seed=dives.seed, jobs=jobs, assumptions=False)


def _with_anchor(dives: AnchorTrials, weight: float) -> dict[str, object]:
    return {f"{dives.phase}.anchor_wet_weight": f"{weight!r} N"}


def _confirmed(
    sizer: AnchorSizer,
    probable: ProbableAnchor,
    probability: float | None,
    outcome: Outcome | None,
    judge: Callable[[float], Outcome | None],
) -> tuple[ProbableAnchor, Outcome | None]:
    """Make the anchor that is the lightest on one set of draws heavier until fresh ones agree, where a little does."""
    first, demands = probable.anchor, sizer.demands(probability)
    if first is None or outcome is None or not _misses(outcome, sizer.moor.name):
        return probable, outcome
    for factor in HEAVIER:
        anchor = sizer.sized(factor * first.wet_weight)
        if any(demand.slack(anchor.probabilities) < 0.0 for demand in demands) or anchor.problems:
            continue
        again = judge(anchor.wet_weight)
        if again is not None and not _misses(again, sizer.moor.name):
            return replace(probable, anchor=anchor, best=anchor.probabilities.good.value), again
    return probable, outcome


def _misses(outcome: Outcome, phase: str) -> bool:
    return any(not item.met and item.phase == phase for item in outcome.requirements)


def _explained(
    sizing: AnchorSizing, dives: AnchorTrials, demands: Sequence[Demand], worst_case: float, run: Run
) -> Iterator[ExplainedAnchor]:
    """Dive with the anchor to build under each explanation, and seek the lightest that would do for it alone."""
    weight, line = sizing.to_build.wet_weight, sizing.line_length
    for causes, probability, alone in run.under_explanations():
        explained_dives = replace(dives, mission=alone.mission)
        needed = lightest_anchor(explained_dives.probabilities, demands, worst_case, line).weight if demands else None
        yield ExplainedAnchor(causes, probability, explained_dives.probabilities(weight).good, needed)


def _members(sizing: AnchorSizing, dives: AnchorTrials, run: Run) -> Iterator[MemberOutcome]:
    """Dive with the anchor to build in each member of the current's ensemble."""
    for name, probability, sailed, alone in run.in_members(dives.recorded):
        member_dives = replace(dives, recorded=sailed, trials=alone.trials)
        yield MemberOutcome(name, probability, member_dives.probabilities(sizing.to_build.wet_weight).good)


def _check_probability(probability: float | None) -> None:
    is_number = isinstance(probability, int | float)
    if probability is None or (is_number and 0.0 < probability < 1.0):
        return
    hint = f"was {probability / 100.0:g} meant?" if is_number and 1.0 < probability < 100.0 else ""
    raise InputError([Problem(f"given {shown(probability)}, expected between 0 and 1", key="probability", hint=hint)])


def _anchor_sizing(
    provenance: Provenance,
    sizer: AnchorSizer,
    anchor: SizedAnchor,
    probable: ProbableAnchor | None,
) -> AnchorSizing:
    speeds, thicknesses = design_current(sizer.means, sizer.moor)
    sizing = AnchorSizing(
        provenance=provenance,
        phase=sizer.moor.name,
        others=tuple(moor.name for moor in sizer.means.drawn.moors if moor.name != sizer.moor.name),
        radius=sizer.radius,
        depth=float(sizer.means.mooring.depth),
        line_length=sizer.line_length,
        layers=tuple(DesignLayer(float(h), float(v)) for h, v in zip(thicknesses, speeds, strict=True)),
        required_velocity=sizer.required_velocity,
        vector_velocity=sizer.vector_velocity,
        anchor=anchor,
        probable=probable,
        notes=(),
    )
    chosen = sizing.to_build
    return replace(
        sizing,
        notes=sizer.notes(chosen),
        held=held_vehicle(sizer.means, sizer.moor, chosen.wet_weight),
        trim=trim_states(sizer.means, chosen.wet_weight, chosen.design),
    )


def worst_case_anchor(mission: Mission) -> float:
    """Wet weight that `size_anchor` gives the mission's first mooring for the worst current, without any trials [N].

    Raises InputError when the mission lacks what a descent needs.
    """
    means = Scenario.at_means(mission, recorded_current(mission))
    try:
        return float(worst_case_weight(laden(means, means.moor()), means.moor()))
    except ValueError as error:
        raise InputError([Problem(str(error), mission.file, key="vehicle.anchor")]) from error


def trim_states(means: Scenario, weight: float, design: AnchorDesign | None) -> tuple[TrimState, ...]:
    """Find the trim of the paper's three configurations.

    Sealed, the anchor's weight and buoyancy cancel, and so do their moments where its ring is in place (Eqs. 16, 17).

    `weight`: of the flooded anchor in water [N]. `design`: its parts; None where they are not given, and the anchor's
    wet weight is taken at mid-length.
    """
    hull = means.mooring.vehicle
    has_centres, vehicle_weight = hull.centres is not None, float(means.mooring.mass) * STANDARD_GRAVITY
    middle = Centre[Scalars].model_construct(from_nose=0.5 * float(hull.hull.length), below_axis=0.0)
    gravity, displaced = hull.centres or (middle, middle)
    vehicle = Weight(vehicle_weight, float(gravity.from_nose), float(gravity.below_axis))
    carried = vehicle_weight + float(hull.net_buoyancy)
    buoyancy = Weight(carried, float(displaced.from_nose), float(displaced.below_axis))
    length = float(anchor_length(means, weight))
    from_tip = wet_centre(design) if design is not None else 0.5 * length
    flooded = Weight(weight, from_tip - (length - overlap_height(means)), 0.0)
    return (
        trim("with the sealed anchor", (vehicle,), buoyancy, centres_known=has_centres),
        trim("with the anchor flooded", (vehicle, flooded), buoyancy, centres_known=has_centres),
        trim("released, without the anchor", (vehicle,), buoyancy, centres_known=has_centres),
    )
