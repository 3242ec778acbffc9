"""A tunnel thruster: thrust against command, at rest and under way."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.tank import TankData, ThrusterSettings
from missionplan.diagnosis.tank.forward import Nuisance, TankForward, noise_sd, product, row_blocks, tank_effects
from missionplan.effects import Effect
from missionplan.effects.info import TankRecord
from missionplan.physics import tunnel_thruster as tt
from missionplan.physics.drag import disc_area

AT_REST = 0.01
"""Speeds below this count as bollard pull [m/s]."""


@dataclass(frozen=True)
class ThrusterModel:
    """Thrust cV|V| with one constant c for both directions, whatever the vehicle's speed.

    Attributes
    ----------
    command, speed : array, shape (N,)
        Shaft rate [1/s] or voltage [V], and the vehicle's speed [m/s].
    """

    command: Array
    speed: Array
    area: float
    """Cross-section of the tunnel [m²]; nan where it is not known."""
    density: float
    """Of the water [kg/m³]."""

    @property
    def squared_command(self) -> Array:
        """V|V|, shape (N,)."""
        return self.command * np.abs(self.command)

    def __call__(self, values: Array, effects: Sequence[Effect]) -> Array:
        """Predict the thrust, shape (N, m) [N]."""
        static = values[0] * self.squared_command[:, None]
        with np.errstate(invalid="ignore", divide="ignore"):
            jet = np.asarray(tt.jet_speed(static, self.area, self.density))
            ratio = np.where(jet > 0.0, np.abs(self.speed)[:, None] / np.where(jet > 0.0, jet, 1.0), 0.0)
        factors = [effect.thrust_factor(self.command[:, None], ratio) for effect in tank_effects(effects)]
        return np.asarray(static * product(factors))


def thruster_forward(data: TankData, settings: ThrusterSettings) -> TankForward:
    """Bind the model of a thruster's thrust.

    Parameters
    ----------
    data : TankData
        The rows.
    settings : ThrusterSettings
        Of the data set.
    """
    thrust = data.columns["thrust_n"]
    command = data.columns["voltage_v"] if "voltage_v" in data.columns else data.columns["rpm"] / 60.0
    speed = data.columns.get("speed_m_s", np.zeros_like(thrust))
    area = float(disc_area(settings.geometry.diameter)) if settings.geometry is not None else math.nan
    model = ThrusterModel(command, speed, area, data.density)
    squared = model.squared_command
    constant = float(squared @ thrust / max(float(squared @ squared), 1e-30))
    sd, stated = noise_sd(thrust, settings.noise.thrust)
    return TankForward(
        kind="thruster",
        record=_record(data, settings, command, speed),
        quantity="thrust_n",
        y=thrust,
        sd=sd,
        stated=stated,
        nuisances=(Nuisance("thrust_constant", constant, abs(constant)),),
        predict=model,
        axes={"command": command} | ({"speed": speed} if np.ptp(speed) > 0.0 else {}),
        groups=_groups(data),
    )


def _record(data: TankData, settings: ThrusterSettings, command: Array, speed: Array) -> TankRecord:
    """What the rows hold."""
    return TankRecord(
        has_both_signs=bool(np.any(command < 0.0) and np.any(command > 0.0)),
        has_jet_speed="voltage_v" not in data.columns and settings.geometry is not None,
        is_under_way=bool(np.any(np.abs(speed) > AT_REST)),
    )


def _groups(data: TankData) -> NDArray[np.str_]:
    """Runs where the rows name more than two, else blocks of rows."""
    runs = data.labels.get("run", [])
    return np.array(runs) if len(set(runs)) > 2 else row_blocks(len(data.columns["thrust_n"]))
