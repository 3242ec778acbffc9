"""Drag of a towed model: force against speed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.datasets.tank import DragSettings, TankData
from missionplan.diagnosis.tank.forward import (
    Nuisance,
    TankForward,
    descent_effects,
    noise_sd,
    product,
    row_blocks,
    tank_effects,
)
from missionplan.effects import Effect
from missionplan.effects.info import TankRecord
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.montecarlo.distributions import mean_of
from missionplan.physics.drag import drag_force, reynolds_number
from missionplan.physics.tank import reynolds_drag_coefficient


@dataclass(frozen=True)
class DragModel:
    """Force ½ρA C_D U² with C_D constant, or with the vehicle file's dependence on the Reynolds number."""

    unit: Array
    """Force for a coefficient of 1, shape (N,) [N]."""
    coefficient: float | None
    """Of the vehicle file; None where it is fitted."""
    reynolds_ratio: Array
    """Reynolds numbers over the one at which the coefficient is stated, shape (N,)."""

    def __call__(self, values: Array, effects: Sequence[Effect]) -> Array:
        """Predict the force, shape (N, m) [N]."""
        coefficient: Scalars = values[0] if self.coefficient is None else self.coefficient
        factors = [effect.drag_factor(self.reynolds_ratio[:, None]) for effect in tank_effects(effects)]
        bias = [np.asarray(effect.lone_drag_factor()) for effect in descent_effects(effects)]
        return np.asarray(self.unit[:, None] * coefficient * product([*factors, *bias]))


def drag_forward(
    data: TankData, settings: DragSettings, vehicle: Vehicle | None, speed_factor: float = 1.0
) -> TankForward:
    """Bind the model of the drag: the vehicle's where its file has one, else with a coefficient to fit.

    Parameters
    ----------
    data : TankData
        The runs.
    settings : DragSettings
        Of the data set.
    vehicle : Vehicle or None
        Of the mission.
    speed_factor : float
        Factor on the speeds towed, for a further measurement.
    """
    speed, force = speed_factor * data.columns["speed_m_s"], data.columns["force_n"]
    known = vehicle.drag if vehicle is not None else None
    coefficient = mean_of(known.coefficient) if known is not None else None
    unit, reynolds_ratio = _unit_force(data, settings, vehicle, speed)
    sd, stated = _noise(data, settings)
    fitted = float(unit @ force / (unit @ unit))
    constant = Nuisance("drag_coefficient", fitted, abs(fitted))
    return TankForward(
        kind="drag",
        record=TankRecord(has_vehicle_drag=coefficient is not None),
        quantity="force_n",
        y=force,
        sd=sd,
        stated=stated,
        nuisances=(constant,) if coefficient is None else (),
        predict=DragModel(unit, coefficient, reynolds_ratio),
        axes={"speed": speed},
        groups=row_blocks(len(force)),
    )


def _unit_force(data: TankData, settings: DragSettings, vehicle: Vehicle | None, speed: Array) -> tuple[Array, Array]:
    """Force for a coefficient of 1 [N], and Reynolds numbers over the one at which the coefficient is stated."""
    known = vehicle.drag if vehicle is not None else None
    exponent = mean_of(known.exponent) if known is not None else 0.0
    area = settings.reference_area if known is None else known.area / settings.scale**2
    reynolds = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))
    stated_at = drag_reynolds(data, settings, vehicle)
    coefficient = reynolds_drag_coefficient(reynolds, 1.0, exponent, stated_at)
    return np.asarray(drag_force(speed, coefficient, area, data.density)), reynolds / stated_at


def _noise(data: TankData, settings: DragSettings) -> tuple[Array, bool]:
    """Standard deviation of each force [N], run by run where the table has it; and whether it was stated."""
    by_run = data.columns.get("force_sd_n")
    if by_run is not None and np.all(by_run > 0.0):
        return by_run, True
    return noise_sd(data.columns["force_n"], settings.noise.force)


def drag_reynolds(data: TankData, settings: DragSettings, vehicle: Vehicle | None) -> float:
    """Re₀ at which the coefficient is stated: the vehicle's, else the geometric mean of those towed, to two figures."""
    if vehicle is not None and vehicle.drag is not None and vehicle.drag.at_reynolds is not None:
        return vehicle.drag.at_reynolds
    towed = reynolds_number(data.columns["speed_m_s"], settings.reference_length, data.viscosity)
    return float(f"{np.exp(np.mean(np.log(towed))):.2g}")
