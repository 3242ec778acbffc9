"""One anchor of a mooring: its construction, nominal dive and probabilities; and the lightest that is enough."""

from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Scalars
from missionplan.mission.schema.phases import MoorPhase
from missionplan.phases.mooring.forces import DescentHooks, SteadyDescent
from missionplan.phases.mooring.profile import simulate_profile
from missionplan.physics.anchor import AnchorDesign, solve_anchor
from missionplan.physics.anchor_remedies import buildable_weights, find_remedies
from missionplan.physics.mooring import required_terminal_velocity, required_terminal_velocity_vector
from missionplan.physics.vehicle_drag import DragBuildUp, QuadraticDrag, anchor_drag, range_notes, terminal_velocity
from missionplan.results.mooring.sized_anchor import SizedAnchor
from missionplan.results.mooring.sizing import DesignLayer, ProbableAnchor
from missionplan.scenario.anchors import anchor_problem, design_current
from missionplan.scenario.mooring import dive_of, start_of
from missionplan.scenario.scenario import STILL_WATER, Scenario
from missionplan.studies.anchor.dive_trials import AnchorTrials
from missionplan.studies.anchor.lightest_anchor import lightest_anchor
from missionplan.studies.nominal_dive import flooding_notice


@dataclass(frozen=True)
class AnchorSizer:
    """Sizes anchors of a mooring.

    Attributes
    ----------
    moor : MoorPhase
    means : Scenario
        The mission at its means.
    trials : AnchorTrials
        Its dives.
    """

    moor: MoorPhase[Scalars]
    means: Scenario
    trials: AnchorTrials

    @property
    def radius(self) -> float:
        """Radius of the mooring at its mean [m]."""
        return float(self.moor.radius)

    @property
    def line_length(self) -> float:
        """Length of the line at its mean [m]."""
        return float(self.moor.line_length)

    @property
    def design_layers(self) -> tuple[DesignLayer, ...]:
        """Thickness and worst current of each layer."""
        speeds, thicknesses = design_current(self.means, self.moor)
        return tuple(DesignLayer(float(h), float(v)) for h, v in zip(thicknesses, speeds, strict=True))

    @property
    def required_velocity(self) -> float:
        """Terminal velocity needed over the ground (Briggs et al., Eq. 1) [m/s]."""
        speeds, thicknesses = design_current(self.means, self.moor)
        return float(required_terminal_velocity(speeds, thicknesses, self.radius))

    @property
    def vector_velocity(self) -> float | None:
        """The same with the layers' own directions; None where the design current has none [m/s]."""
        speeds, thicknesses = design_current(self.means, self.moor)
        given = self.means.mooring.site.current
        if not isinstance(given, tuple) or not given:
            return None
        toward = np.array([float(layer.toward) for layer in given])
        return float(required_terminal_velocity_vector(speeds, toward, thicknesses, self.radius))

    @property
    def _hooks(self) -> DescentHooks:
        return DescentHooks(self.means.descent_effects)

    def sized(self, weight: float) -> SizedAnchor:
        """Anchor of a wet weight [N]: its construction, nominal dive and probabilities."""
        design = self._design(weight)
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
        speed = self._balanced_speed(weight)
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

    def probable(self, required: float, worst_case: float) -> ProbableAnchor:
        """Lightest anchor that reaches a probability, searched from the worst-case weight [N]."""
        start = worst_case + max(float(self.means.mooring.vehicle.net_buoyancy), 0.0)
        found = lightest_anchor(self.trials.probabilities, required, start, self.line_length)
        anchor = self.sized(found.weight) if found.weight is not None else None
        heavier = self._buildable(anchor, required) if anchor is not None else None
        return ProbableAnchor(
            required,
            heavier or anchor,
            found.reason,
            found.best,
            found.line_length,
            found.line_weight,
            found.weight if heavier is not None else None,
        )

    def _buildable(self, anchor: SizedAnchor, required: float) -> SizedAnchor | None:
        """Lightest heavier anchor that the parts can make, if that one is impossible and this one does too."""
        if anchor.buildable is None or anchor.buildable[0] <= anchor.wet_weight:
            return None
        weight = anchor.buildable[0]
        return self.sized(weight) if self.trials.probabilities(weight).good.value >= required else None

    def notes(self, anchor: SizedAnchor) -> tuple[str, ...]:
        """Sentences on where the model leaves its range for an anchor."""
        fineness = anchor.design.length / (2.0 * anchor.design.problem.radius) if anchor.design else None
        notes = range_notes(self.means.vehicle_drag, anchor.terminal_velocity, fineness)
        if anchor.profile.record.parted[0]:
            load = anchor.snatch["snatch_tension_n"]
            notes = (*notes, f"The line parts in the nominal dive: the snatch loads it with {load:.0f} N.")
        if words := flooding_notice(self.means, self.moor, anchor.wet_weight):
            notes = (*notes, words)
        buoyancy = float(self.means.mooring.vehicle.net_buoyancy)
        if anchor.wet_weight > buoyancy:
            return notes
        note = (
            f"The anchor's {anchor.wet_weight:.2f} N do not overcome the vehicle's net buoyancy of {buoyancy:.2f} N, "
            "which Eq. 15 leaves out; `carry_net_buoyancy: true` in the mooring adds it."
        )
        return (note, *notes)

    def _design(self, weight: float) -> AnchorDesign | None:
        if self.means.mooring.anchor.construction is None:
            return None
        return solve_anchor(anchor_problem(self.means), weight)

    def _drag(self, speed: float) -> DragBuildUp:
        """Drag by its sources at a speed through the water, with the effects' factor."""
        descent = SteadyDescent.at(speed, self._hooks, float(self.means.mooring.depth))
        parts = self.means.vehicle_drag.build_up(speed, self._anchor_drag)
        factor = float(descent.drag_factor)
        return replace(parts, **{name: float(value) * factor for name, value in vars(parts).items()})

    def _balanced_speed(self, weight: float) -> float:
        """Speed through the water at which the drag balances the wet weight (Eq. 15, or with the buoyancy) [m/s]."""
        descent = SteadyDescent.at(self.required_velocity, self._hooks, float(self.means.mooring.depth))
        pull = weight * float(descent.weight_factor) - float(descent.lift)
        pull -= float(self.means.mooring.vehicle.net_buoyancy) if self.moor.carry_net_buoyancy else 0.0
        factor = float(descent.drag_factor)
        return float(terminal_velocity(lambda v: factor * (self.means.vehicle_drag(v) + self._anchor_drag(v)), pull))

    @property
    def _anchor_drag(self) -> QuadraticDrag:
        anchor = self.means.mooring.anchor
        return anchor_drag(anchor.diameter, anchor.drag_coefficient, self.means.water.density)
