"""A propeller's transient: thrust against time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.tank import PropellerSettings, TankData
from missionplan.diagnosis.tank.data import row_blocks
from missionplan.diagnosis.tank.forward import Nuisance, TankForward, noise_sd, tank_effects
from missionplan.effects import Effect
from missionplan.effects.info import TankRecord
from missionplan.physics.drag import disc_area
from missionplan.studies.identification.identify import TURN, TransientRun

MASS_FACTORS = (1e-4, 1e4)
"""Least and largest mass of the flow over ρ A_p D at which the model is evaluated: no effect's parameter is beyond."""


@dataclass(frozen=True)
class PropellerModel:
    """Quasi-steady thrust, the flow in the disc (1 + a)(1 - w) times the speed (Blanke, Lindegaard & Fossen 2000)."""

    run: TransientRun
    """The measured run."""
    water_mass: float
    """Mass of a cylinder of water with the propeller's diameter and as long [kg]."""

    def __call__(self, values: Array, effects: Sequence[Effect]) -> Array:
        """Predict the thrust, shape (N, m) [N]."""
        factors = [np.asarray(effect.flow_mass_factor()) for effect in tank_effects(effects)]
        if not factors:
            return np.stack([self.run.quasi_steady(pair) for pair in values.T], axis=1)
        masses = np.broadcast_to(self.water_mass * np.clip(sum(factors), *MASS_FACTORS), values.shape[1:])
        constants = (np.array([*pair, mass]) for pair, mass in zip(values.T, masses, strict=True))
        return np.stack([self.run.axial_flow(each) for each in constants], axis=1)


def propeller_forward(data: TankData, settings: PropellerSettings) -> TankForward:
    """Bind the model of a propeller's thrust.

    Parameters
    ----------
    data : TankData
        The run.
    settings : PropellerSettings
        Of the data set.
    """
    run = TransientRun(data, settings.geometry)
    thrust = data.columns["thrust_n"]
    diameter = settings.geometry.diameter
    unit = data.density * diameter**4 / TURN**2
    level, slope = 0.4 * unit, -0.8 * unit * TURN / diameter
    sd, stated = noise_sd(thrust, settings.noise.thrust)
    return TankForward(
        kind="propeller-transient",
        record=TankRecord(),
        quantity="thrust_n",
        y=thrust,
        sd=sd,
        stated=stated,
        nuisances=(Nuisance("thrust_nn_n_s2", level, 2.0 * level), Nuisance("thrust_nu_kg", slope, 3.0 * abs(slope))),
        predict=PropellerModel(run, data.density * float(disc_area(diameter)) * diameter),
        axes={"time": run.time, "speed": run.speed},
        groups=row_blocks(len(thrust)),
    )
