"""Which anchor? From the worst current to an anchor one can build, the dive it gives, and how often that is enough."""

import time
from dataclasses import dataclass, replace

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.phases import MoorPhase
from missionplan.montecarlo.parallel_blocks import Backend
from missionplan.phases.mooring.forces import DescentHooks, SteadyDescent
from missionplan.phases.mooring.profile import descent_profile
from missionplan.physics.anchor import AnchorDesign, solve_anchor
from missionplan.physics.anchor_remedies import buildable_weights, find_remedies
from missionplan.physics.mooring import required_terminal_velocity, required_terminal_velocity_vector
from missionplan.physics.vehicle_drag import DragBuildUp, QuadraticDrag, anchor_drag, range_notes, terminal_velocity
from missionplan.results.anchor import AnchorSizing, DesignLayer, ProbableAnchor, SizedAnchor
from missionplan.results.base import Provenance
from missionplan.scenario.anchor_weight import anchor_problem, design_current, worst_case_weight
from missionplan.scenario.scenario import STILL_WATER, Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.anchor.search import lightest_anchor
from missionplan.studies.anchor.trials import AnchorTrials, FanOut, dive_with, start_of


def size_anchor(
    mission: Mission,
    *,
    probability: float | None = None,
    phase: str | None = None,
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    backend: Backend = "loky",
    scheduler: str | None = None,
) -> AnchorSizing:
    """Size the anchor of a mooring.

    Parameters
    ----------
    mission : Mission
    probability : float, optional
        Also find the lightest anchor that stays within the radius, without the vehicle striking, so often.
    phase : str, optional
        Name of the mooring; default: the first.
    trials, seed : int, optional
        Default: the mission's.
    jobs, backend, scheduler
        See `run_blocks`.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs, or the probability is not between 0 and 1.
    """
    started = time.perf_counter()
    moor = _mooring(mission, phase)
    if probability is not None and not 0.0 < probability < 1.0:
        raise InputError([Problem(f"given {probability:g}, expected between 0 and 1", key="--probability")])
    count, seed = trials or mission.monte_carlo.trials, mission.monte_carlo.seed if seed is None else seed
    recorded = recorded_current(mission)
    fan_out = FanOut(jobs, backend, scheduler)
    study = _Study(
        moor, Scenario.at_means(mission, recorded), AnchorTrials(mission, moor, recorded, count, seed, fan_out)
    )
    try:
        weight = worst_case_weight(study.means, moor)
        anchor = study.sized(weight)
        probable = study.probable(probability, weight) if probability is not None else None
    except ValueError as error:
        raise InputError([Problem(str(error), mission.file, key="vehicle.anchor")]) from error
    speeds, thicknesses = design_current(study.means, moor)
    options = {"probability": probability, "phase": phase, "jobs": jobs, "backend": backend, "scheduler": scheduler}
    return AnchorSizing(
        provenance=Provenance(
            command="size-anchor",
            mission=mission.name,
            file=mission.file,
            seed=seed,
            trials=count,
            options=options,
            elapsed_s=time.perf_counter() - started,
            data=mission.raw,
            notices=mission.notices(),
        ),
        phase=moor.name,
        radius=study.radius,
        depth=float(study.means["site.depth"]),
        line_length=float(study.means[f"{moor.name}.line_length"]),
        layers=tuple(DesignLayer(float(h), float(v)) for h, v in zip(thicknesses, speeds, strict=True)),
        required_velocity=study.required_velocity,
        vector_velocity=study.vector_velocity,
        anchor=anchor,
        probable=probable,
        notes=study.notes(anchor),
    )


def worst_case_anchor(mission: Mission) -> float:
    """Wet weight that `size_anchor` gives the mission's first mooring for the worst current, nothing tried [N].

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    moor = _mooring(mission, None)
    means = Scenario.at_means(mission, recorded_current(mission))
    try:
        return float(worst_case_weight(means, moor))
    except ValueError as error:
        raise InputError([Problem(str(error), mission.file, key="vehicle.anchor")]) from error


def _mooring(mission: Mission, name: str | None) -> MoorPhase:
    """The mooring to size for, once all that a descent needs is there.

    Raises
    ------
    InputError
        With everything that is missing.
    """
    moors = {moor.name: moor for moor in mission.moors}
    problems = [] if moors else [("phases", "there is no mooring to size an anchor for")]
    if name is not None and moors and name not in moors:
        problems.append(("--phase", f"given {name!r}, expected a mooring: {', '.join(moors)}"))
    vehicle, site = mission.vehicle, mission.site
    needed = {
        "vehicle": vehicle,
        "vehicle.mass": vehicle and vehicle.mass,
        "vehicle.anchor": vehicle and vehicle.anchor,
        "site": site,
        "site.depth": site and site.depth,
        "site.water": site and site.water,
    }
    problems += [(key, "missing; sizing an anchor needs it") for key, value in needed.items() if value is None]
    if vehicle and vehicle.anchor and vehicle.anchor.construction is None and vehicle.anchor.flooded_mass is None:
        problems.append(("vehicle.anchor.flooded_mass", "missing; needed where the anchor has no `construction`"))
    if problems:
        raise InputError([Problem(message, mission.file, key=key) for key, message in problems])
    return moors[name] if name is not None else next(iter(moors.values()))


@dataclass(frozen=True)
class _Study:
    """A mooring at the mission's means, and its trials."""

    moor: MoorPhase
    means: Scenario
    trials: AnchorTrials

    @property
    def radius(self) -> float:
        return float(self.means[f"{self.moor.name}.radius"])

    @property
    def required_velocity(self) -> float:
        """Over the ground, Eq. 1 [m/s]."""
        speeds, thicknesses = design_current(self.means, self.moor)
        return float(required_terminal_velocity(speeds, thicknesses, self.radius))

    @property
    def vector_velocity(self) -> float | None:
        """The same with the layers' own directions; None where the design current has none [m/s]."""
        speeds, thicknesses = design_current(self.means, self.moor)
        paths = [f"site.current[{index}].toward" for index in range(len(speeds))]
        if any(path not in self.means.draws for path in paths):
            return None
        toward = np.array([float(self.means[path]) for path in paths])
        return float(required_terminal_velocity_vector(speeds, toward, thicknesses, self.radius))

    @property
    def _hooks(self) -> DescentHooks:
        return DescentHooks(self.means.descent_effects)

    def sized(self, weight: float) -> SizedAnchor:
        """Build the anchor of a wet weight [N], dive with it, and try it many times."""
        design = self._design(weight)
        wrong = design is not None and not design.feasible
        dive = dive_with(self.means, self.moor, weight)
        place, t_start = start_of(self.means, self.moor)
        profile = descent_profile(
            dive,
            effects=self.means.descent_effects,
            release_time=float(self.means[f"{self.moor.name}.release_time"]),
            current=self.means.current or STILL_WATER,
            position=place,
            t_start=t_start,
        )
        speed = self._balanced_speed(weight)
        return SizedAnchor(
            wet_weight=weight,
            terminal_velocity=speed,
            drag=self._drag(speed),
            design=design,
            remedies=find_remedies(design) if design is not None else (),
            buildable=buildable_weights(design.problem) if design is not None and wrong else None,
            dive=dive,
            profile=profile,
            probabilities=self.trials.probabilities(weight),
        )

    def probable(self, required: float, worst_case: float) -> ProbableAnchor:
        """Find the lightest anchor that reaches a probability."""
        line = float(self.means[f"{self.moor.name}.line_length"])
        start = worst_case + max(float(self.means["vehicle.net_buoyancy"]), 0.0)
        found = lightest_anchor(self.trials.probabilities, required, start, line)
        anchor = self.sized(found.weight) if found.weight is not None else None
        return ProbableAnchor(required, anchor, found.reason, found.best, found.line_length, found.line_weight)

    def notes(self, anchor: SizedAnchor) -> tuple[str, ...]:
        """Say where the model leaves its range."""
        fineness = anchor.design.length / (2.0 * anchor.design.problem.radius) if anchor.design else None
        notes = range_notes(self.means.vehicle_drag, anchor.terminal_velocity, fineness)
        buoyancy = float(self.means["vehicle.net_buoyancy"])
        if anchor.wet_weight > buoyancy:
            return notes
        light = (
            f"The anchor's {anchor.wet_weight:.2f} N do not overcome the vehicle's net buoyancy of {buoyancy:.2f} N, "
            "which Eq. 15 leaves out; `carry_net_buoyancy: true` in the mooring adds it."
        )
        return (light, *notes)

    def _design(self, weight: float) -> AnchorDesign | None:
        anchor = self.means.mission.vehicle.anchor if self.means.mission.vehicle else None
        if anchor is None or anchor.construction is None:
            return None
        return solve_anchor(anchor_problem(self.means), weight)

    def _drag(self, speed: float) -> DragBuildUp:
        """Drag by its sources at a speed through the water, with the effects' factor."""
        sink = SteadyDescent.at(speed, self._hooks, float(self.means["site.depth"]))
        parts = self.means.vehicle_drag.build_up(speed, self._anchor_drag)
        factor = float(sink.drag_factor)
        return replace(parts, **{name: float(value) * factor for name, value in vars(parts).items()})

    def _balanced_speed(self, weight: float) -> float:
        """Speed through the water at which the drag balances the wet weight (Eq. 15, or with the buoyancy) [m/s]."""
        sink = SteadyDescent.at(self.required_velocity, self._hooks, float(self.means["site.depth"]))
        pull = weight * float(sink.weight_factor) - float(sink.lift)
        pull -= float(self.means["vehicle.net_buoyancy"]) if self.moor.carry_net_buoyancy else 0.0
        factor = float(sink.drag_factor)
        return float(terminal_velocity(lambda v: factor * (self.means.vehicle_drag(v) + self._anchor_drag(v)), pull))

    @property
    def _anchor_drag(self) -> QuadraticDrag:
        path = "vehicle.anchor"
        diameter, coefficient = self.means[f"{path}.diameter"], self.means[f"{path}.drag_coefficient"]
        return anchor_drag(diameter, coefficient, self.means.water.density)
