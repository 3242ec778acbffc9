"""What the tank's measurements would be: the base model of each kind, with the effects it may lack."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.datasets.tank import (
    DragSettings,
    OscillationSettings,
    PropellerSettings,
    TankData,
    ThrusterSettings,
)
from missionplan.diagnosis.tank.data import row_blocks
from missionplan.effects import CATALOGUE, Effect, TankEffect
from missionplan.effects.drag_bias import DragBias
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.montecarlo.distributions import mean_of
from missionplan.phases.hooks import DescentEffect
from missionplan.physics import oscillation as osc
from missionplan.physics import tunnel_thruster as tt
from missionplan.physics.drag import disc_area, drag_force, reynolds_number
from missionplan.physics.tank import reynolds_drag_coefficient
from missionplan.studies.identification.oscillation import starting_values
from missionplan.studies.identification.propeller import TURN, TransientRun

Predict = Callable[[Array, Sequence[Effect]], Array]
"""From nuisances, shape (q, m), and effects with parameters of shape (m,) to the data, shape (N, m)."""

AT_REST = 0.01
"""Speeds below this count as bollard pull [m/s]."""
ASSUMED_NOISE_SHARE = 0.03
"""Noise of a sensor that states none, as a share of the data's root mean square: where the fit of it begins."""


@dataclass(frozen=True)
class Nuisance:
    """A constant of the base model that is fitted under any set of causes: its normal prior, wide."""

    name: str
    centre: float
    sd: float


@dataclass(frozen=True)
class TankForward:
    """A kind of tank data with its base model.

    Attributes
    ----------
    quantity : str
        Column that is explained.
    y, sd : array, shape (N,)
        Data and the sensor's standard deviation [SI].
    stated : bool
        Whether that deviation was stated; else its size is fitted from far off.
    nuisances : tuple of Nuisance
        Fitted under any set.
    predict : callable
        The model of the data.
    candidates : tuple of str
        Effects that the data could show.
    untestable : mapping
        Those that they could not, and why.
    axes : mapping
        Axis → where each datum lies.
    groups : array of str, shape (N,)
        Runs, or blocks in the order of the record, for predictions of what was held out.
    guesses : mapping
        Parameter → coordinates where its fit starts.
    designs : tuple
        Further measurements in words, and the model of each.
    """

    quantity: str
    y: Array
    sd: Array
    stated: bool
    nuisances: tuple[Nuisance, ...]
    predict: Predict
    candidates: tuple[str, ...]
    untestable: Mapping[str, str]
    axes: Mapping[str, Array]
    groups: NDArray[np.str_]
    guesses: Mapping[tuple[str, str], tuple[float, ...]]
    designs: tuple[tuple[str, "TankForward"], ...] = ()


def tank_forward(data: TankData, mission: Mission) -> TankForward:
    """Bind the base model of a kind of tank data, with the mission's vehicle where it says something of it.

    Raises
    ------
    InputError
        When the data hold as many unknowns as numbers.
    """
    settings, vehicle = data.settings, mission.vehicle
    if isinstance(settings, DragSettings):
        plain = _drag(data, settings, vehicle, 1.0)
        return replace(plain, designs=(("the same runs at twice the speeds", _drag(data, settings, vehicle, 2.0)),))
    if isinstance(settings, OscillationSettings):
        plain = _oscillation(data, settings, vehicle, 1.0)
        larger = _oscillation(data, settings, vehicle, 3.0)
        return replace(plain, designs=(("a release from three times the displacement", larger),))
    if isinstance(settings, ThrusterSettings):
        return _thruster(data, settings)
    return _propeller(data, settings)


def _scatter(data: TankData, y: Array, noise: float | None) -> tuple[Array, bool]:
    if noise is not None:
        return np.full_like(y, noise), True
    return np.full_like(y, ASSUMED_NOISE_SHARE * max(float(np.sqrt(np.mean(y**2))), 1e-12)), False


def _of_tank(effects: Sequence[Effect]) -> list[TankEffect]:
    return [effect for effect in effects if isinstance(effect, TankEffect)]


def _product(factors: Sequence[Array | float]) -> Array | float:
    return math.prod(factors) if factors else 1.0


def _drag(data: TankData, settings: DragSettings, vehicle: Vehicle | None, faster: float) -> TankForward:
    """Force against speed: ½ρAC_D U² with C_D constant, the vehicle's where its file has one."""
    known = vehicle.drag if vehicle is not None else None
    speed, force = faster * data.columns["speed_m_s"], data.columns["force_n"]
    reynolds = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))
    middle = drag_reynolds(data, settings, vehicle)
    exponent = mean_of(known.exponent) if known is not None else 0.0
    area = settings.reference_area if known is None else known.area / settings.scale**2
    unit = np.asarray(drag_force(speed, reynolds_drag_coefficient(reynolds, 1.0, exponent, middle), area, data.density))
    given = data.columns.get("force_sd_n")
    sd, stated = _scatter(data, force, settings.noise.force)
    if given is not None and np.all(given > 0.0):
        sd, stated = given, True
    fitted = float(unit @ force / (unit @ unit)) if known is None else mean_of(known.coefficient)

    def predict(values: Array, effects: Sequence[Effect]) -> Array:
        coefficient: Scalars = values[0] if known is None else fitted
        factors = [effect.drag_factor((reynolds / middle)[:, None]) for effect in _of_tank(effects)]
        bias = [np.asarray(effect.lone_drag_factor()) for effect in effects if isinstance(effect, DragBias)]
        return np.asarray(unit[:, None] * coefficient * _product([*factors, *bias]))

    return TankForward(
        "force_n",
        force,
        sd,
        stated,
        (Nuisance("drag_coefficient", fitted, abs(fitted)),) if known is None else (),
        predict,
        ("reynolds-drag",) if known is None else ("drag-bias", "reynolds-drag"),
        {"drag-bias": "the vehicle file has no drag from a tank to lay the data against"} if known is None else {},
        {"speed": speed},
        row_blocks(len(force)),
        {},
    )


def drag_reynolds(data: TankData, settings: DragSettings, vehicle: Vehicle | None) -> float:
    """Re₀ at which the coefficient is stated: the vehicle's, else the geometric mean of those towed, to two figures."""
    if vehicle is not None and vehicle.drag is not None and vehicle.drag.at_reynolds is not None:
        return vehicle.drag.at_reynolds
    towed = reynolds_number(data.columns["speed_m_s"], settings.reference_length, data.viscosity)
    return float(f"{np.exp(np.mean(np.log(towed))):.2g}")


def _oscillation(data: TankData, settings: OscillationSettings, vehicle: Vehicle | None, larger: float) -> TankForward:
    """Displacement against time: the mass in air on its springs, with linear damping."""
    if "displacement_m" not in data.columns:
        words = "a frequency of each mode is one number for one unknown: nothing is left to test a model by"
        raise InputError([Problem(words, data.settings.file, hint="`missionplan identify` finds the added masses")])
    assert settings.stiffness is not None
    assert settings.mass is not None
    time, record = data.columns["t_s"], data.columns["displacement_m"]
    sd, stated = _scatter(data, record, settings.noise.displacement)
    total, stiffness = base_mass(settings, vehicle), settings.stiffness
    begin = {parameter.name: parameter.start for parameter in starting_values(time, record)}
    spread = float(np.std(record))
    nuisances = (
        Nuisance("start_m", begin["start"], 3.0 * spread),
        Nuisance("start_velocity_m_s", begin["start_velocity"], 6.0 * math.pi * begin["frequency"] * spread),
        Nuisance("offset_m", begin["offset"], spread),
        Nuisance("log_linear_rate", math.log(begin["linear_rate"]), 1.5),
    )

    def predict(values: Array, effects: Sequence[Effect]) -> Array:
        start, velocity, offset, log_rate = values
        masses = [np.asarray(effect.mass_factor()) for effect in effects if isinstance(effect, DescentEffect)]
        frequency = osc.natural_frequency(stiffness, total * np.maximum(_product(masses), 0.05))
        damping = sum((effect.damping() for effect in _of_tank(effects)), 0.0)
        frequency = np.broadcast_to(frequency, np.shape(start))
        swing = osc.displacement(time, larger * start, larger * velocity, frequency, np.exp(log_rate), damping)
        return np.asarray(offset + swing)

    heavier = stiffness / (2.0 * math.pi * begin["frequency"]) ** 2 / total - 1.0
    return TankForward(
        "displacement_m",
        record,
        sd,
        stated,
        nuisances,
        predict,
        ("added-mass", "quadratic-damping"),
        {},
        {"time": time},
        row_blocks(len(time)),
        {("added-mass", "fraction"): (heavier,)},
    )


def base_mass(settings: OscillationSettings, vehicle: Vehicle | None) -> float:
    """Mass in air, and the added mass in surge that the vehicle file already has, at the tank's scale [kg]."""
    assert settings.mass is not None
    known = vehicle.added_mass.surge if vehicle is not None and vehicle.added_mass is not None else None
    return settings.mass + (mean_of(known) / settings.scale**3 if known is not None else 0.0)


def _thruster(data: TankData, settings: ThrusterSettings) -> TankForward:
    """Thrust against command: cV|V| with one constant for both directions, whatever the speed."""
    volts = "voltage_v" in data.columns
    command = data.columns["voltage_v"] if volts else data.columns["rpm"] / 60.0
    thrust = data.columns["thrust_n"]
    speed = data.columns.get("speed_m_s", np.zeros_like(thrust))
    sd, stated = _scatter(data, thrust, settings.noise.thrust)
    squared = command * np.abs(command)
    constant = float(squared @ thrust / max(float(squared @ squared), 1e-30))
    untestable = {}
    if np.all(command >= 0.0) or np.all(command <= 0.0):
        untestable["thrust-asymmetry"] = "the commands have one sign"
    if volts or settings.geometry is None:
        untestable["jet-suction"] = "it needs the shaft rate (rpm) and the tunnel's diameter (geometry)"
    elif np.all(np.abs(speed) <= AT_REST):
        untestable["jet-suction"] = "there is no row under way"
    area = float(disc_area(settings.geometry.diameter)) if settings.geometry is not None else math.nan

    def predict(values: Array, effects: Sequence[Effect]) -> Array:
        static = values[0] * squared[:, None]
        with np.errstate(invalid="ignore", divide="ignore"):
            jet = np.asarray(tt.jet_speed(static, area, data.density))
            ratio = np.where(jet > 0.0, np.abs(speed)[:, None] / np.where(jet > 0.0, jet, 1.0), 0.0)
        factors = [effect.thrust_factor(command[:, None], ratio) for effect in _of_tank(effects)]
        return np.asarray(static * _product(factors))

    runs = data.labels.get("run", [])
    named = np.array(runs) if len(set(runs)) > 2 else row_blocks(len(thrust))
    axes = {"command": command} | ({"speed": speed} if np.ptp(speed) > 0.0 else {})
    return TankForward(
        "thrust_n",
        thrust,
        sd,
        stated,
        (Nuisance("thrust_constant", constant, abs(constant)),),
        predict,
        tuple(name for name in ("jet-suction", "thrust-asymmetry") if name not in untestable),
        untestable,
        axes,
        named,
        {},
    )


def _propeller(data: TankData, settings: PropellerSettings) -> TankForward:
    """Thrust against time: quasi-steady, the flow in the disc (1 + a)(1 - w) times the speed."""
    run = TransientRun(data, settings.geometry)
    thrust = data.columns["thrust_n"]
    sd, stated = _scatter(data, thrust, settings.noise.thrust)
    diameter = settings.geometry.diameter
    unit = data.density * diameter**4 / TURN**2
    slug = data.density * float(disc_area(diameter)) * diameter
    level, slope = 0.4 * unit, -0.8 * unit * TURN / diameter

    def predict(values: Array, effects: Sequence[Effect]) -> Array:
        moving = [np.asarray(effect.flow_mass_factor()) for effect in _of_tank(effects)]
        if not moving:
            return np.stack([run.quasi_steady(pair) for pair in values.T], axis=1)
        mass = np.broadcast_to(slug * moving[0], values.shape[1:])
        return np.stack([run.axial_flow(np.array([*pair, m])) for pair, m in zip(values.T, mass, strict=True)], axis=1)

    return TankForward(
        "thrust_n",
        thrust,
        sd,
        stated,
        (Nuisance("thrust_nn_n_s2", level, 2.0 * level), Nuisance("thrust_nu_kg", slope, 3.0 * abs(slope))),
        predict,
        ("axial-flow",),
        {},
        {"time": run.time, "speed": run.speed},
        row_blocks(len(thrust)),
        {("axial-flow", "mass_factor"): (-1.2, 0.0, 1.2)},
    )


def build_effects(effects: Mapping[str, Mapping[str, Scalars]]) -> list[Effect]:
    """Effects from their parameters."""
    return [CATALOGUE[name].make(parameters) for name, parameters in effects.items()]
