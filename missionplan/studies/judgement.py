"""Whether a recommendation does what the mission requires, and what an answer takes for granted is worth.

Every command that recommends (`size-anchor`, `optimise`, `plan-legs`, `sweep-dmax`) asks here, and its headline and
exit status follow: what was chosen on one set of random numbers is held to another. The ledger puts each assumption off
by its usual size, and the mission is run again.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from missionplan.effects import CATALOGUE
from missionplan.errors import InputError, MissionplanError
from missionplan.mission import Mission
from missionplan.mission.schema.site import CurrentFile, CurrentLayer, TidalCurrent
from missionplan.mission.schema.vehicle import Anchor
from missionplan.montecarlo.distributions import Quantity, mean_of, sd_of
from missionplan.montecarlo.statistics import Count, Probability
from missionplan.results.decision import Assumption
from missionplan.results.entries import mappings
from missionplan.results.failures import SUCCESS, Counted, CountedKind
from missionplan.results.simulation import Outcome, RequirementOutcome
from missionplan.studies.simulation.block_statistics import happened
from missionplan.studies.simulation.simulate import event_probabilities, simulate
from missionplan.studies.simulation.trial_block import MissionTrials

TRIALS = 400
"""Of each run of the ledger; they share their random numbers, so that small differences show."""
LEAST_WORTH = 0.01
"""Share of these trials below which no requirement is said to be missed for want of an assumption."""
_ANYWHERE = {"low": "0 deg", "high": "360 deg"}
_AXES = "east", "north"
_SD = {"sd": "0.1 m/s"}
"""Of a current: drifters differ by about 0.1 m/s from maps of the current that are measured there and then."""


@dataclass(frozen=True)
class Doubt:
    """An assumption, and the mission without it."""

    what: str
    otherwise: str
    """What is taken for granted, and what is put in its place."""
    changes: Mapping[str, object]
    """Of the mission's keys (`Mission.with_`)."""
    first: str = ""
    """What settles it, as an order."""


def ledger(
    mission: Mission, seed: int, run: MissionTrials | None = None, asked: Sequence[RequirementOutcome] = ()
) -> tuple[Assumption, ...]:
    """Run a mission without each of its assumptions; those that matter most come first; nan where it cannot be run.

    `run`: first trials of the mission as it is, where they are known. `asked`: how often all its trials do what is
    required, of which the few of the ledger, less often by chance, would tell nothing missed.
    """
    doubts = tuple(doubts_of(mission))
    if not doubts:
        return ()
    if run is not None and run.success.size >= TRIALS:
        base = {counted: Count.of(trial[:TRIALS]).probability() for counted, trial in happened(mission, run).items()}
    else:
        base = event_probabilities(mission, trials=TRIALS, seed=seed)
    is_required = any(requirement.quantity == "total.success" for requirement in mission.requirements)
    rows = []
    for doubt in doubts:
        try:
            other = event_probabilities(mission.with_(dict(doubt.changes)), trials=TRIALS, seed=seed)
        except (MissionplanError, ArithmeticError):  # a plug-in's phase, a key that another forbids
            rows.append(Assumption(doubt.what, doubt.otherwise, math.nan, math.nan, first=doubt.first))
            continue
        missed = []
        for index, requirement in enumerate(mission.requirements):
            before, after = (probabilities[Counted.requirement(index)].value for probabilities in (base, other))
            reached = asked[index].probability.value if asked else before
            if before - after >= LEAST_WORTH and reached - before + after < requirement.probability <= reached:
                missed.append(requirement)
        before, after = base[SUCCESS].value, other[SUCCESS].value
        names, phases = tuple(miss.written for miss in missed), tuple(miss.phase for miss in missed)
        fields = doubt.what, doubt.otherwise, after - before, after, names, is_required, _spoilt(base, other)
        rows.append(Assumption(*fields, doubt.first, phases))
    return tuple(sorted(rows, key=lambda row: (not row.turns, math.isnan(row.worth), row.worth)))


def _spoilt(base: Mapping[Counted, Probability], other: Mapping[Counted, Probability]) -> str:
    """Name the phase that loses most more trials than before; empty where none does."""
    more: dict[str, float] = {"": 0.0}
    for step in (counted for counted in other if counted.kind is CountedKind.FAILURE):
        more[step.of] = more.get(step.of, 0.0) + other[step].value - (base[step].value if step in base else 0.0)
    return max(more, key=lambda phase: more[phase])


def doubts_of(mission: Mission) -> Iterator[Doubt]:
    """Yield what a mission takes for granted, as far as it can be put off by its usual size."""
    yield from _current(mission)
    if (mission.transits or mission.moors) and (mission.site is None or mission.site.wind is None):
        blows = {"speed": {"low": "0 m/s", "high": "12 m/s"}, "from": _ANYWHERE}
        first = "take the wind from a forecast (site.wind)"
        yield Doubt("there is no wind", "winds of 0 to 12 m/s from anywhere", {"site.wind": blows}, first)
    if mission.transits and mission.navigation is not None and mission.navigation.fix_error == 0.0:
        first = "find the error of fixes, from those of a night ashore (navigation.fix_error)"
        yield Doubt("fixes are exact", "an error of 5 m on each axis", {"navigation.fix_error": "5 m"}, first)
    if mission.moors:
        yield from _anchor(mission.vehicle.anchor if mission.vehicle else None)
        for phase in mission.moors:
            if phase.line_material is None and phase.line_wet_weight is None:
                changes = {f"{phase.name}.line_material": "polyester"}
                first = "say what the line is made of, and how thick it is (line_material, line_diameter)"
                if phase.line_diameter:
                    yield Doubt(f"the line has no weight ({phase.label})", "polyester", changes, first)
                else:
                    changes[f"{phase.name}.line_diameter"] = "2 mm"
                    words = f"the line has neither weight nor drag ({phase.label})"
                    yield Doubt(words, "2 mm of polyester", changes, first)


def _anchor(anchor: Anchor | None) -> Iterator[Doubt]:
    if anchor is None:
        return
    holding = "vehicle.anchor.holding_factor"
    pull = f"pull such an anchor over the site's bottom ({holding})"
    if anchor.holding_factor is None:  # DNV-RP-F109: clay to sand
        changes = {holding: {"low": 0.2, "high": 0.6}}
        yield Doubt("the anchor stays where it lies", "a holding factor of 0.2 to 0.6", changes, pull)
    elif isinstance(anchor.holding_factor, float):
        factor = {"median": anchor.holding_factor, "factor": 1.4}
        words = "the anchor holds just as its holding factor says"
        yield Doubt(words, "a factor of 1.4 more or less", {holding: factor}, pull)
    if anchor.flooding_time is None:
        words, floods = "the anchor is full of water at once", "vehicle.anchor.flooding_time"
        yield Doubt(words, "10 s of flooding", {floods: "10 s"}, f"time how the anchor floods ({floods})")


def _current(mission: Mission) -> Iterator[Doubt]:
    """Yield a current that is taken as exact: none, numbers for layers, a record or a tide without an error."""
    current = mission.site.current if mission.site else ()
    if (mission.transits or mission.moors) and not _has_current(mission):
        flows = {"down_to": "11 km", "speed": {"low": "0 m/s", "high": "0.5 m/s"}, "toward": _ANYWHERE}
        first = "measure the site's current, or take it from a forecast (site.current)"
        yield Doubt("there is no current", "currents of 0 to 0.5 m/s to anywhere", {"site.current": [flows]}, first)
    if isinstance(current, CurrentFile | TidalCurrent):
        single = not isinstance(current, CurrentFile) or len(current.members) == 1
        if current.error is None and single:
            error = {"sigma": "0.1 m/s", "time": "12 h"}
            first = "find how far the current was from such records (site.current.error)"
            yield Doubt("the current is as recorded", "0.1 m/s off on each axis", {"site.current.error": error}, first)
    else:
        yield from _layers(mission, current)


def _layers(mission: Mission, current: Sequence[CurrentLayer[Quantity]]) -> Iterator[Doubt]:
    """Yield layers of a current whose speeds are taken as exact, or that stay as at the start."""
    exact = {
        f"site.current[{number}].speed": {"mean": f"{mean_of(layer.speed)!r} m/s", **_SD}
        for number, layer in enumerate(current)
        if not sd_of(layer.speed)
    }
    if exact:
        first = "find how the layers' speeds vary from day to day (sd of site.current's speeds)"
        yield Doubt("the layers flow just as fast as stated", "0.1 m/s faster or slower", exact, first)
    fastest = max((abs(mean_of(layer.speed)) for layer in current), default=0.0)
    name = next(name for name, info in CATALOGUE.items() if {f"m2_{axis}" for axis in _AXES} <= info.parameters.keys())
    if mission.transits and fastest and not any(effect.effect == name for effect in mission.effects):
        strength, phase = {"low": f"{-fastest!r} m/s", "high": f"{fastest!r} m/s"}, f"{math.pi / 2.0!r} rad"
        tide = {f"m2_{axis}": strength for axis in _AXES} | {f"m2_{axis}_phase": phase for axis in _AXES}
        changes = {"effects": [*mappings(mission.raw.get("effects")), {name: tide}]}
        first = "find the tide in a record of the site's current (missionplan tide)"
        yield Doubt("the current stays as at the start", "a tide up to as strong from then on", changes, first)


def _has_current(mission: Mission) -> bool:
    """Whether the mission's site or its effects tell of a current, of those in doubt at least as likely as not."""
    flow = {name for name, info in CATALOGUE.items() if info.is_steady_current or info.is_modulated}
    always = any(entry.effect in flow and entry.explanation is None for entry in mission.effects)
    likely = (
        sum(share for share, causes in zip(doubt.probabilities, doubt.causes, strict=True) if flow.intersection(causes))
        for doubt in mission.doubts
    )
    return bool(mission.site and mission.site.current) or always or max(likely, default=0.0) >= 0.5


FRESH = 1_000_003
"""Added to the seed on which the recommendation was chosen."""


def judged(
    mission: Mission,
    values: Mapping[str, object],
    *,
    trials: int,
    seed: int,
    jobs: int = 1,
    assumptions: bool = True,
    fresh: bool = True,
) -> Outcome | None:
    """Simulate a mission with what is recommended, and without each of its assumptions; None where it cannot be.

    `mission`: as its file has it. `values`: by key path, as a mission file has them. `trials`, `seed`: with which they
    were chosen; `fresh` draws are those of another seed.
    """
    seed += FRESH if fresh else 0
    try:
        whole = mission.with_written(values)
        return simulate(whole, trials=trials, seed=seed, jobs=jobs, assumptions=assumptions, sheet=False)
    except InputError:
        return None


def doubted(mission: Mission, recommended: Mapping[str, object], outcome: Outcome) -> Outcome:
    """Simulate a mission that was judged without each of its assumptions too."""
    whole = mission.with_written(recommended)
    return replace(outcome, assumed=ledger(whole, outcome.provenance.seed, None, outcome.requirements))


def is_good(outcome: Outcome | None) -> bool:
    """Whether every requirement is met, and every anchor can be built; so too where nothing was judged."""
    return outcome is None or (outcome.requirements_met and outcome.can_be_built)
