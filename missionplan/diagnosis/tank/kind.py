"""Tank data as a kind of data: bound to a mission, with what that knows already, residuals and causes."""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Self

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.datasets.tank import DragSettings, OscillationSettings, TankData, ThrusterSettings, read_tank_data
from missionplan.diagnosis.coordinates import coordinates_of
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.given import GivenEffect
from missionplan.diagnosis.given.priors import check_together, given_priors
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.learned_data import as_then, unlearned
from missionplan.diagnosis.tank.forward import (
    Nuisance,
    TankForward,
    decimated,
    drag_forward,
    drag_reynolds,
    full_size_added_mass,
    noise_sd,
    oscillation_forward,
    row_blocks,
    tank_effects,
    thruster_forward,
)
from missionplan.diagnosis.tank.model import TankModel
from missionplan.effects import CATALOGUE, Effect, exclusive_groups
from missionplan.effects.info import TankRecord, VehicleKey
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.montecarlo.distributions import mean_of, sd_of
from missionplan.physics.drag import disc_area
from missionplan.results.learned import PlanGain
from missionplan.results.learned.evidence import ParameterEstimate
from missionplan.studies.identification import TURN, TransientRun


def vehicle_keys(mission: Mission, best: CauseFit) -> dict[str, VehicleKey]:
    """Return the key of the vehicle's file that states an effect found, by the effect; none of those carried so far."""
    carried = {entry.effect for entry in mission.effect_list.known}
    names = {estimate.effect for estimate in (*best.given, *best.estimates)} - carried
    return {name: CATALOGUE[name].vehicle_key for name in names if CATALOGUE[name].vehicle_key}


def _drag(
    vehicle: Vehicle,
    settings: DragSettings,
    estimates: Mapping[VehicleKey, ParameterEstimate],
    calibration: Mapping[str, float],
    data: TankData,
) -> dict[str, object]:
    """The vehicle's ``drag``: its coefficient times the bias, and the exponent about the middle of the speeds towed."""
    drag = vehicle.drag
    level = mean_of(drag.coefficient) if drag is not None else calibration["drag_coefficient"]
    area = drag.area if drag is not None else settings.reference_area * settings.scale**2
    bias, change = estimates.get("drag.coefficient"), estimates.get("drag.exponent")
    mean = float(f"{level * (1.0 + (bias.value if bias is not None else 0.0)):.5g}")
    sd = level * bias.sd if bias is not None else 0.0
    coefficient = {"mean": mean, "sd": float(f"{sd:.3g}")} if sd else mean
    section: dict[str, object] = {"coefficient": coefficient, "area": f"{area:.6g} m^2"}
    power = mean_of(drag.exponent) if drag is not None else 0.0
    exponent: float | dict[str, float] = power
    if change is not None:
        exponent = {"mean": float(f"{power + change.value:.4g}"), "sd": float(f"{change.sd:.3g}")}
    if not exponent:  # the drag does not depend on the Reynolds number
        return section
    length = drag.length if drag is not None else None
    if length is None:
        length = settings.reference_length * settings.scale
    at_reynolds = drag_reynolds(data, settings, vehicle)
    return {**section, "exponent": exponent, "at_reynolds": at_reynolds, "length": f"{length:.6g} m"}


MASS_FACTORS = (1e-4, 1e4)
"""Least and largest mass of the flow over ρ A_p D at which the model is evaluated: no effect's parameter is beyond."""


def _thrust(run: TransientRun, water_mass: float, values: Array, effects: Sequence[Effect]) -> Array:
    """Predict the thrust of a run, shape (N, m) [N]: quasi-steady, or with a mass of the flow in the disc.

    The flow is (1 + a)(1 - w) times the speed (Blanke, Lindegaard & Fossen 2000). `water_mass`: of a cylinder of water
    with the propeller's diameter and as long [kg].
    """
    factors = [np.asarray(effect.flow_mass_factor()) for effect in tank_effects(effects)]
    if not factors:
        return np.stack([run.quasi_steady(pair) for pair in values.T], axis=1)
    masses = np.broadcast_to(water_mass * np.clip(sum(factors), *MASS_FACTORS), values.shape[1:])
    constants = (np.array([*pair, mass]) for pair, mass in zip(values.T, masses, strict=True))
    return np.stack([run.axial_flow(triple) for triple in constants], axis=1)


UNITS = {"force_n": ("the drag", "N"), "displacement_m": ("the displacement", "m"), "thrust_n": ("the thrust", "N")}


@dataclass(frozen=True)
class TankKind(DataKind):
    """Drag, free oscillations, thrusters and propeller transients."""

    kind: str
    mission: Mission
    data: TankData
    model: TankModel

    @classmethod
    def bind(cls, kind: str, folder: Path, mission: Mission, seed: int) -> Self:
        """Read the data and bind the base model of their kind to them."""
        data = unlearned(decimated(read_tank_data(folder)), mission)
        then = as_then(data, mission, data.date)
        forward = tank_forward(data, then)
        effects = [CATALOGUE[name] for name in forward.candidates]
        priors = given_priors(then, effects)
        check_together(priors, then, "tank")
        mission_effects = {entry.effect for entry in then.effect_list.known}
        for info in effects:  # stated by a key of the vehicle file: no change on its mean, with its uncertainty
            if info.vehicle_key and info.id not in mission_effects and then.vehicle is not None:
                sd = _uncertainty(info.vehicle_key, data, then.vehicle)
                if sd != 0.0:
                    (parameter,) = info.parameters.values()
                    spike = np.array([(parameter.tank_spike or parameter.spike) ** 2])
                    stated = GivenEffect(info.id, coordinates_of(info), np.zeros(1), np.array([[sd**2]]), spike)
                    priors = (*priors, stated)
        return cls(kind, then, data, TankModel(forward, given=priors, alternatives=exclusive_groups("tank")))

    def residual_table(self, base: CauseFit, best: CauseFit) -> pd.DataFrame:
        """Return one row a datum: where it lies, what was measured, both models' values, what is left of each [SI]."""
        forward, before = self.model.forward, self.model.plain_residuals()
        after = best.state.residuals if best.causes else before
        return pd.DataFrame(
            {
                "group": forward.groups,
                **{f"at_{name}": values for name, values in forward.axes.items()},
                forward.quantity: forward.y,
                "base": forward.y - before,
                "extended": forward.y - after,
                "residual_base": before,
                "residual_extended": after,
            }
        )

    def misfit(self, residuals: pd.DataFrame) -> str:
        """Describe the root mean square of the residuals beside the sensor's noise."""
        forward = self.model.forward
        rms, size = (float(np.sqrt(np.mean(np.square(values)))) for values in (residuals["residual_base"], forward.y))
        stated = f", {rms / float(np.median(forward.sd)):.1f} times the stated noise" if forward.stated else ""
        name, unit = UNITS[forward.quantity]
        return f"The base model misses {name} by {rms:.3g} {unit} rms, {100.0 * rms / size:.1f} % of it{stated}."

    def shares_explained(self, base: CauseFit, fits: Sequence[CauseFit], residuals: pd.DataFrame) -> list[float]:
        """Return the share of the squared residuals that goes with each fit."""
        before = float(np.sum(residuals["residual_base"] ** 2))
        after = (float(np.sum(fit.state.residuals**2)) for fit in fits)
        return [float(np.clip(1.0 - remainder / max(before, 1e-30), 0.0, 1.0)) for remainder in after]

    def extended_mission(self, best: CauseFit) -> dict[str, object]:
        """Write what keys of the vehicle file state of the causes into the mission's data, at full size.

        As an effect it would act on a descent's anchor too. A mission without a vehicle carries nothing of that kind.
        """
        mission, settings, extended = self.mission, self.data.settings, dict(self.mission.raw)
        keys = vehicle_keys(mission, best)
        estimates = {
            keys[estimate.effect]: estimate for estimate in (*best.given, *best.estimates) if estimate.effect in keys
        }
        section = extended.get("vehicle")
        if not estimates or mission.vehicle is None or not isinstance(section, dict):
            return extended
        vehicle = copy.deepcopy(section)
        if isinstance(settings, DragSettings):
            vehicle["drag"] = _drag(mission.vehicle, settings, estimates, best.calibration, self.data)
        if isinstance(settings, OscillationSettings) and "added_mass.surge" in estimates:
            estimate = estimates["added_mass.surge"]
            surge, sd = full_size_added_mass(settings, mission.vehicle, estimate.value, estimate.sd)
            added_mass = dict(vehicle.get("added_mass") or {})
            vehicle["added_mass"] = added_mass | {"surge": {"mean": f"{surge:.5g} kg", "sd": f"{sd:.3g} kg"}}
        extended["vehicle"] = vehicle
        return extended

    def carried(self, best: CauseFit, scale: float) -> CauseFit:
        """Return a fit without the causes that keys of the vehicle state."""
        return replace(best, posterior=best.posterior.without(vehicle_keys(self.mission, best)))

    def plan_gain(self, base: Mission, extended: Mapping[str, object], *, seed: int, jobs: int) -> PlanGain:
        """Compare the anchors chosen, where the mission has a mooring and an anchor."""
        vehicle = self.mission.vehicle
        if not (self.mission.moors and vehicle and vehicle.anchor):
            return PlanGain(reason="no mooring's anchor, whose choice the tank's data could change")
        return super().plan_gain(base, extended, seed=seed, jobs=jobs)


def tank_forward(data: TankData, mission: Mission) -> TankForward:
    """Bind the base model of a kind of tank data, with the constants that the mission's vehicle file has.

    Raises InputError when the data hold as many unknowns as numbers, or nothing but zeros.
    """
    settings, vehicle = data.settings, mission.vehicle
    if isinstance(settings, DragSettings):
        forward, faster = (drag_forward(data, settings, vehicle, factor) for factor in (1.0, 2.0))
        forward = replace(forward, designs=(("the same runs at twice the speeds", faster),))
    elif isinstance(settings, OscillationSettings):
        forward, larger = (oscillation_forward(data, settings, vehicle, factor) for factor in (1.0, 3.0))
        forward = replace(forward, designs=(("a release from three times the displacement", larger),))
    elif isinstance(settings, ThrusterSettings):
        forward = thruster_forward(data, settings)
    else:
        run = TransientRun(data, settings.geometry)
        thrust = data.columns["thrust_n"]
        diameter = settings.geometry.diameter
        unit = data.density * diameter**4 / TURN**2
        level, slope = 0.4 * unit, -0.8 * unit * TURN / diameter
        sd, stated = noise_sd(thrust, settings.noise.thrust)
        forward = TankForward(
            kind="propeller-transient",
            record=TankRecord(),
            quantity="thrust_n",
            y=thrust,
            sd=sd,
            stated=stated,
            nuisances=(
                Nuisance("thrust_nn_n_s2", level, 2.0 * level),
                Nuisance("thrust_nu_kg", slope, 3.0 * abs(slope)),
            ),
            predict=partial(_thrust, run, data.density * float(disc_area(diameter)) * diameter),
            axes={"time": run.time, "speed": run.speed},
            groups=row_blocks(len(thrust)),
        )
    if not np.any(forward.y):
        words = f"{forward.quantity} is 0 in every row: there is nothing to explain"
        raise InputError([Problem(words, settings.file)])
    return forward


def _uncertainty(key: VehicleKey, data: TankData, vehicle: Vehicle) -> float:
    """Standard deviation of an effect's one parameter by the key that states it; 0 where the key is a number."""
    settings = data.settings
    if isinstance(settings, DragSettings) and vehicle.drag is not None:
        if key == "drag.coefficient":
            return sd_of(vehicle.drag.coefficient) / mean_of(vehicle.drag.coefficient)
        if key == "drag.exponent":
            return sd_of(vehicle.drag.exponent)
    if key == "added_mass.surge" and isinstance(settings, OscillationSettings) and vehicle.added_mass is not None:
        surge = vehicle.added_mass.surge
        return sd_of(surge) / full_size_added_mass(settings, vehicle, 0.0, 1.0)[1] if surge is not None else 0.0
    return 0.0
