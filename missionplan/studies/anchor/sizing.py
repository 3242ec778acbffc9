"""One anchor of a mooring: construction, nominal dive, dives on random numbers common to all; and the lightest."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.mission import Mission
from missionplan.mission.schema.phases import MoorPhase
from missionplan.mission.schema.sweep import Requirement
from missionplan.mission.views import MooringMission
from missionplan.montecarlo.blocks import IN_THIS_PROCESS, Workers
from missionplan.montecarlo.statistics import Count, RunningStatistic
from missionplan.montecarlo.streams import BlockStreams, block_count, block_size, stream
from missionplan.phases.currents import Current
from missionplan.phases.hooks import TrialState
from missionplan.phases.mooring.forces import DescentHooks, SteadyDescent
from missionplan.phases.mooring.profile import simulate_profile
from missionplan.physics.anchor import required_terminal_velocity, required_terminal_velocity_vector, solve_anchor
from missionplan.physics.anchor_remedies import buildable_weights, find_remedies
from missionplan.physics.drag import DragBuildUp, QuadraticDrag, anchor_drag, range_notes, terminal_velocity
from missionplan.report.wording import in_words
from missionplan.results.anchor_sizing import Deviation, ProbableAnchor
from missionplan.results.failures import SUCCESS, Counted, CountedKind
from missionplan.results.sized_anchor import DiveProbabilities, SizedAnchor
from missionplan.scenario.anchors import anchor_problem, design_current
from missionplan.scenario.phases import dive_of, start_of
from missionplan.scenario.scenario import STILL_WATER, Scenario
from missionplan.studies.anchor.lightest_anchor import Demand, lightest_anchor
from missionplan.studies.simulation.block_statistics import bound_of, requirement_flags, requirement_key
from missionplan.studies.simulation.mooring_trials import mooring_trials
from missionplan.studies.simulation.outcome_builder import requirement_outcome
from missionplan.studies.simulation.phase_trials import Flags, TrialBlock


@dataclass(frozen=True)
class _Totals:
    """Merged dives: counts by name, and statistics of those that landed."""

    counts: Mapping[Counted, Count]
    offset: RunningStatistic
    lowest: RunningStatistic

    def merge(self, other: "_Totals") -> "_Totals":
        counts = {name: count.merge(other.counts[name]) for name, count in self.counts.items()}
        return _Totals(counts, self.offset.merge(other.offset), self.lowest.merge(other.lowest))


@dataclass(frozen=True)
class AnchorTrials:
    """Dives of a mission's mooring from the planned fix, each trial with the same draws for every anchor."""

    mission: Mission
    phase: str
    """The mooring's name."""
    recorded: Current | None
    """The site's current where the mission reads it from a file."""
    trials: int
    seed: int
    workers: Workers = IN_THIS_PROCESS

    @property
    def counts_holding(self) -> bool:
        """Whether an anchor must also hold: where the vehicle file says how it does."""
        return MooringMission.of(self.mission).anchor.holding_factor is not None

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """What the mission requires of this mooring."""
        return tuple(item for item in self.mission.requirements if item.phase == self.phase)

    def probabilities(self, weight: float, line_length: float | None = None) -> DiveProbabilities:
        """Estimate the probabilities of an anchor of a wet weight [N], with another line [m] if one is given."""
        task = partial(_block, replace(self, workers=IN_THIS_PROCESS), weight, line_length)
        totals = reduce(_Totals.merge, self.workers.run(task, range(block_count(self.trials))))
        shares = {counted.name: count.probability() for counted, count in totals.counts.items()}
        return DiveProbabilities(
            good=shares[SUCCESS.name],
            within=shares["within_radius"],
            holds=shares["anchor_holds"] if self.counts_holding else None,
            struck=shares["struck_seafloor"],
            offset=totals.offset.statistic(),
            lowest_altitude=totals.lowest.statistic(),
            requirements=tuple(
                requirement_outcome(self.mission, item, totals.counts[Counted.requirement(index)])
                for index, item in enumerate(self.requirements)
            ),
        )


def _block(study: AnchorTrials, weight: float, line_length: float | None, block: int) -> _Totals:
    """Dive with one block of trials; a dive is good where the mooring fails in no way."""
    size, source = block_size(study.trials, block), BlockStreams(study.seed, block)
    scenario = Scenario.at_means(study.mission, study.recorded).sampled_from(source, size)
    phase = scenario.moor(study.phase)
    length = phase.line_length if line_length is None else line_length
    phase = phase.model_copy(update={"anchor_wet_weight": weight, "line_length": length})
    place, start = start_of(scenario, phase)
    position = np.broadcast_to(place.reshape(2, -1), (2, size))
    fix_error = scenario.fix_sd * stream(study.seed, f"{study.phase}.fix", block).standard_normal((2, size))
    state = TrialState(
        position=position,
        fix=position + fix_error,
        clock=np.full(size, start),
        energy=np.zeros(size),
        alive=np.ones(size, dtype=bool),
    )
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        _, done = mooring_trials(TrialBlock(scenario, source, 0, inputs=False), phase, state, place.reshape(2, -1))
    columns: dict[str, Array | Flags] = {f"{phase.name}.{name}": values for name, values in done.quantities.items()}
    columns |= {f"{phase.name}.{name}": values for name, values in done.events.items()}
    flags = requirement_flags(study.mission.model_copy(update={"requirements": study.requirements}), columns)
    events = {Counted(CountedKind.EVENT, phase.name, name): values for name, values in done.events.items()}
    good = ~np.logical_or.reduce(list(done.failures.values()))
    return _Totals(
        {counted: Count.of(trials) for counted, trials in {SUCCESS: good, **events, **flags}.items()},
        RunningStatistic.of(done.quantities["offset_m"]),
        RunningStatistic.of(done.quantities["lowest_altitude_m"]),
    )


MARGIN = 0.1
"""Share by which an anchor may turn out lighter or heavier than it was meant to be."""
FEW = 500
"""Dives that say where to look, and of the search for a longer line, at most."""
_INSIDE = (".within_radius", ".offset")


@dataclass(frozen=True)
class AnchorSizer:
    """Sizes anchors of a mooring."""

    moor: MoorPhase[Scalars]
    means: Scenario
    """The mission at its means."""
    trials: AnchorTrials
    """Its dives."""

    @property
    def radius(self) -> float:
        """Radius of the mooring at its mean [m]."""
        return float(self.moor.radius)

    @property
    def line_length(self) -> float:
        """Length of the line at its mean [m]."""
        return float(self.moor.line_length)

    @property
    def required_velocity(self) -> float:
        """Terminal velocity needed over the ground (Briggs et al., Eq. 1) [m/s]."""
        speeds, thicknesses = design_current(self.means, self.moor)
        return float(required_terminal_velocity(speeds, thicknesses, self.radius))

    @property
    def vector_velocity(self) -> float | None:
        """The same with the layers' own directions; None where the design current has none [m/s]."""
        speeds, thicknesses = design_current(self.means, self.moor)
        current = self.means.mooring.site.current
        if not isinstance(current, tuple) or not current:
            return None
        toward = np.array([float(layer.toward) for layer in current])
        return float(required_terminal_velocity_vector(speeds, toward, thicknesses, self.radius))

    @property
    def _hooks(self) -> DescentHooks:
        return DescentHooks(self.means.descent_effects)

    def sized(self, weight: float) -> SizedAnchor:
        """Anchor of a wet weight [N]: its construction, nominal dive and probabilities."""
        design = (
            None if self.means.mooring.anchor.construction is None else solve_anchor(anchor_problem(self.means), weight)
        )
        dive = dive_of(self.means, self.moor, weight)
        position, t_start = start_of(self.means, self.moor)
        profile = simulate_profile(
            dive,
            effects=self.means.descent_effects,
            release_time=float(self.moor.release_time),
            current=self.means.current or STILL_WATER,
            position=position,
            t_start=t_start,
        )
        # speed through the water at which the drag balances the wet weight (Eq. 15, or with the buoyancy) [m/s]
        descent = SteadyDescent.at(
            self.required_velocity, self._hooks, float(self.means.mooring.depth), self.line_length
        )
        pull = weight * float(descent.weight_factor) - float(descent.lift)
        pull -= float(self.means.mooring.vehicle.net_buoyancy) if self.moor.carry_net_buoyancy else 0.0
        factor = float(descent.drag_factor)
        speed = float(terminal_velocity(lambda v: factor * (self.means.vehicle_drag(v) + self._anchor_drag(v)), pull))
        return SizedAnchor(
            wet_weight=weight,
            terminal_velocity=speed,
            drag=self._drag(speed),
            design=design,
            remedies=find_remedies(design) if design is not None else (),
            buildable=buildable_weights(design.problem) if design is not None and not design.feasible else None,
            dive=dive,
            profile=profile,
            probabilities=self.trials.probabilities(weight),
        )

    def demands(self, probability: float | None) -> tuple[Demand, ...]:
        """What dives have to do: what the mission requires of this mooring, and so often to succeed.

        A mission that must succeed so often needs a dive that does. One that strikes is not taken as within the radius.
        """
        must = [item.probability for item in self.trials.mission.requirements if item.quantity == "total.success"]
        shares = [*([] if probability is None else [probability]), *must]
        demands = list(_succeeding(max(shares), holds=self.trials.counts_holding)) if shares else []
        for index, item in enumerate(self.trials.requirements):
            demands.append(
                Demand(
                    self._in_words(item),
                    item.probability,
                    lambda odds, index=index: odds.requirements[index].probability.value,  # type: ignore[misc]
                    needs_height=item.quantity.endswith(".lowest_altitude"),
                )
            )
        inside = [item.probability for item in self.trials.requirements if item.quantity.endswith(_INSIDE)]
        if inside:
            demands.append(Demand("a dive clear of the seafloor", max(inside), _clear, needs_height=True))
        return tuple(demands)

    def probable(self, probability: float | None, worst_case: float) -> ProbableAnchor | None:
        """Lightest anchor that meets all demands, searched from the worst-case weight [N]; None without any."""
        demands = self.demands(probability)
        if not demands:
            return None
        start = worst_case + max(float(self.means.mooring.vehicle.net_buoyancy), 0.0)
        rough = replace(self.trials, trials=FEW).probabilities if self.trials.trials > FEW else None
        lightest = lightest_anchor(self.trials.probabilities, demands, start, self.line_length, rough)
        anchor = self.sized(lightest.weight) if lightest.weight is not None else None
        heavier = self._buildable(anchor, demands) if anchor is not None else None
        chosen = heavier or anchor
        best = self.trials.probabilities(lightest.compromise) if chosen is None else chosen.probabilities
        return ProbableAnchor(
            required=probability,
            anchor=chosen,
            reason=lightest.reason,
            compromise=lightest.compromise,
            best=best.good.value,
            margins=tuple(self._deviations(chosen.wet_weight, demands)) if chosen is not None else (),
            line_length=lightest.line_length,
            line_anchor_weight=lightest.line_weight,
            lighter=lightest.weight if heavier is not None else None,
        )

    def _deviations(self, weight: float, demands: Sequence[Demand]) -> Iterator[Deviation]:
        """Yield anchors that turned out lighter and heavier, and what their dives then miss."""
        for factor in (1.0 - MARGIN, 1.0 + MARGIN):
            odds = self.trials.probabilities(factor * weight)
            misses = tuple(
                f"{demand.words}: {100.0 * demand.share(odds):.1f} % of {100.0 * demand.required:g} %"
                for demand in demands
                if demand.slack(odds) < 0.0
            )
            yield Deviation(factor * weight, odds, misses)

    def _buildable(self, anchor: SizedAnchor, demands: Sequence[Demand]) -> SizedAnchor | None:
        """Lightest heavier anchor that the parts can make, if that one is impossible and this one does too."""
        if anchor.buildable is None or anchor.buildable[0] <= anchor.wet_weight:
            return None
        heavier = self.sized(anchor.buildable[0])
        return heavier if all(demand.slack(heavier.probabilities) >= 0.0 for demand in demands) else None

    def notes(self, anchor: SizedAnchor) -> tuple[str, ...]:
        """Sentences on where the model leaves its range for an anchor."""
        fineness = anchor.design.length / (2.0 * anchor.design.problem.radius) if anchor.design else None
        notes = range_notes(self.means.vehicle_drag, anchor.terminal_velocity, fineness)
        load = anchor.nominal.snatch_tension
        if anchor.profile.record.parted[0] and load is not None:
            notes = (*notes, f"The line parts in the nominal dive: the snatch loads it with {load:.0f} N.")
        if self.means.mooring.anchor.flooding_time is None:
            notes = (*notes, "The anchor is taken as full of water when it separates (anchor.flooding_time).")
        buoyancy = float(self.means.mooring.vehicle.net_buoyancy)
        if anchor.wet_weight > buoyancy:
            return notes
        note = (
            f"The anchor's {anchor.wet_weight:.2f} N do not overcome the vehicle's net buoyancy of {buoyancy:.2f} N, "
            "which Eq. 15 leaves out; `carry_net_buoyancy: true` in the mooring adds it."
        )
        return (note, *notes)

    def _drag(self, speed: float) -> DragBuildUp:
        """Drag by its sources at a speed through the water, with the effects' factor."""
        descent = SteadyDescent.at(speed, self._hooks, float(self.means.mooring.depth), self.line_length)
        parts = self.means.vehicle_drag.build_up(speed, self._anchor_drag)
        factor = float(descent.drag_factor)
        return replace(parts, **{name: float(value) * factor for name, value in vars(parts).items()})

    @property
    def _anchor_drag(self) -> QuadraticDrag:
        anchor = self.means.mooring.anchor
        return anchor_drag(anchor.diameter, anchor.drag_coefficient, self.means.water.density)

    def _in_words(self, requirement: Requirement) -> str:
        """Write a requirement in words, with its bound in SI."""
        bound, name = bound_of(requirement), in_words(requirement.quantity)
        if bound is None:
            return name
        (side, limit), (_, unit) = bound, requirement_key(self.trials.mission, requirement.quantity)
        return f"{name} {side.replace('_', ' ')} {limit:.4g} {unit or ''}".rstrip()


def _clear(odds: DiveProbabilities) -> float:
    return 1.0 - odds.struck.value


def _succeeding(required: float, *, holds: bool) -> Iterator[Demand]:
    """Yield a dive that succeeds, and what every such dive does: of that the shares rise or fall with the weight."""
    yield Demand("an anchor within the radius", required, lambda odds: odds.within.value)
    yield Demand("a dive clear of the seafloor", required, _clear, needs_height=True)
    if holds:
        yield Demand("an anchor that holds", required, lambda odds: odds.holds.value if odds.holds else 1.0)
    yield Demand("a dive that succeeds", required, lambda odds: odds.good.value, is_hill=True)
