"""Free oscillation of a model on springs: displacement against time."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.tank import OscillationSettings, TankData
from missionplan.diagnosis.tank.forward import (
    Nuisance,
    TankForward,
    descent_effects,
    effects_seen_in,
    noise_sd,
    product,
    row_blocks,
    tank_effects,
)
from missionplan.effects import Effect
from missionplan.effects.info import TankRecord
from missionplan.errors import InputError, Problem
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.montecarlo.distributions import mean_of
from missionplan.physics import tank as osc
from missionplan.studies.identification.oscillation import starting_values

MIN_MASS_FACTOR = 0.05
"""Least factor of effects on the oscillating mass at which the model is evaluated."""


@dataclass(frozen=True)
class OscillationModel:
    """Mass in air and added mass of the vehicle file on its springs, with linear damping (Avila et al., section 4.2).

    Attributes
    ----------
    stiffness, mass : float
        Of the springs [N/m], and oscillating [kg].
    """

    time: Array
    """[s], shape (N,)."""
    stiffness: float
    mass: float
    release_factor: float
    """Factor on displacement and velocity at the release, for a further measurement."""

    def __call__(self, values: Array, effects: Sequence[Effect]) -> Array:
        """Predict the displacement, shape (N, m) [m]."""
        start, velocity, offset, log_rate = values
        masses = [np.asarray(effect.mass_factor()) for effect in descent_effects(effects)]
        mass = self.mass * np.maximum(product(masses), MIN_MASS_FACTOR)
        frequency = np.broadcast_to(osc.natural_frequency(self.stiffness, mass), np.shape(start))
        damping = sum((effect.damping() for effect in tank_effects(effects)), 0.0)
        larger = self.release_factor
        swing = osc.displacement(self.time, larger * start, larger * velocity, frequency, np.exp(log_rate), damping)
        return np.asarray(offset + swing)


def oscillation_forward(
    data: TankData, settings: OscillationSettings, vehicle: Vehicle | None, release_factor: float = 1.0
) -> TankForward:
    """Bind the model of a record of displacement.

    Parameters
    ----------
    data : TankData
        The record.
    settings : OscillationSettings
        Of the data set.
    vehicle : Vehicle or None
        Of the mission.
    release_factor : float
        Factor on the displacement at the release, for a further measurement.

    Raises
    ------
    InputError
        When the data are frequencies alone, as many numbers as unknowns.
    """
    if "displacement_m" not in data.columns:
        words = "a frequency of each mode is one number for one unknown: nothing is left to test a model by"
        raise InputError([Problem(words, data.settings.file, hint="`missionplan identify` finds the added masses")])
    time, record = data.columns["t_s"], data.columns["displacement_m"]
    mass, stiffness = base_mass(settings, vehicle), settings.stiffness
    begin = {parameter.name: parameter.start for parameter in starting_values(time, record)}
    heavier = stiffness / (2.0 * math.pi * begin["frequency"]) ** 2 / mass - 1.0
    sd, stated = noise_sd(record, settings.noise.displacement)
    return TankForward(
        kind="free-oscillation",
        record=TankRecord(),
        quantity="displacement_m",
        y=record,
        sd=sd,
        stated=stated,
        nuisances=_nuisances(begin, float(np.std(record))),
        predict=OscillationModel(time, stiffness, mass, release_factor),
        axes={"time": time},
        groups=row_blocks(len(time)),
        starts=_starts_of_mass(heavier),
    )


def _starts_of_mass(heavier: float) -> dict[tuple[str, str], tuple[float, ...]]:
    """For each strength that adds to the oscillating mass, where it alone gives the measured frequency.

    Parameters
    ----------
    heavier : float
        By which the oscillating mass is then larger, relative to the base model's.
    """
    found: dict[tuple[str, str], tuple[float, ...]] = {}
    for info in effects_seen_in("free-oscillation"):
        for name in info.parameters:
            for effect in descent_effects([info.make({name: 1.0})]):
                added = float(np.asarray(effect.mass_factor())) - 1.0
                if added:
                    found[info.id, name] = (heavier / added,)
    return found


def _nuisances(begin: dict[str, float], spread: float) -> tuple[Nuisance, ...]:
    """Release, rest position and linear damping, about starting values; standard deviation of the record [m]."""
    return (
        Nuisance("start_m", begin["start"], 3.0 * spread),
        Nuisance("start_velocity_m_s", begin["start_velocity"], 6.0 * math.pi * begin["frequency"] * spread),
        Nuisance("offset_m", begin["offset"], spread),
        Nuisance("log_linear_rate", math.log(begin["linear_rate"]), 1.5),
    )


def base_mass(settings: OscillationSettings, vehicle: Vehicle | None) -> float:
    """Mass in air, and the added mass in surge that the vehicle file already has, at the tank's scale [kg]."""
    known = vehicle.added_mass.surge if vehicle is not None and vehicle.added_mass is not None else None
    return settings.mass + (mean_of(known) / settings.scale**3 if known is not None else 0.0)


def full_size_added_mass(
    settings: OscillationSettings, vehicle: Vehicle | None, fraction: float, sd: float
) -> tuple[float, float]:
    """Added mass in surge at full size, and its standard deviation [kg], of a mass larger by a fraction.

    Parameters
    ----------
    settings : OscillationSettings
        Of the data set.
    vehicle : Vehicle or None
        Of the mission.
    fraction, sd : float
        By which the oscillating mass is larger than the base model's, and its standard deviation.
    """
    base = base_mass(settings, vehicle)
    return (base * (1.0 + fraction) - settings.mass) * settings.scale**3, base * sd * settings.scale**3
