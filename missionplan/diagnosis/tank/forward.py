"""Rows of tank data as they are fitted, and their forward model: the base model of a measurement and its catalogue.

Measurements are towed drag, free oscillation and thrusters, seen with effects.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.datasets.tank import DragSettings, OscillationSettings, TankData, ThrusterSettings
from missionplan.effects import CATALOGUE, Effect, EffectInfo, TankEffect
from missionplan.effects.info import TankKind, TankRecord
from missionplan.errors import InputError, Problem
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.montecarlo.distributions import mean_of
from missionplan.phases.hooks import DescentEffect
from missionplan.physics import tank as osc
from missionplan.physics import tunnel_thruster as tt
from missionplan.physics.drag import disc_area, drag_force, reynolds_number
from missionplan.results.learned.evidence import Causes
from missionplan.studies.identification.oscillation import starting_values

Predict = Callable[[Array, Sequence[Effect]], Array]
"""From nuisance parameters, shape (q, m), and effects with parameters of shape (m,) to the data, shape (N, m)."""

UNSTATED_NOISE = 0.03
"""Initial noise of a sensor that states none, of the root mean square of the data."""

ROUNDING = 1e-8
"""Least noise of a sensor, of the root mean square of the data."""


@dataclass(frozen=True)
class Nuisance:
    """A constant of the base model that is fitted under any set of causes, with its normal prior."""

    name: str
    centre: float
    sd: float


@dataclass(frozen=True)
class TankForward:
    """A kind of tank data with its base model."""

    kind: TankKind
    """Kind of the data."""
    record: TankRecord
    """What they hold, as far as it decides which effects they could show."""
    quantity: str
    """Column that is explained."""
    y: Array
    sd: Array
    """Data and the sensor's standard deviation [SI], shape (N,)."""
    stated: bool
    """Whether that deviation was stated; else its size is fitted, from a rough guess."""
    nuisances: tuple[Nuisance, ...]
    """Fitted under any set of causes."""
    predict: Predict
    """The model of the data."""
    axes: Mapping[str, Array]
    """Axis → where each datum lies."""
    groups: NDArray[np.str_]
    """Runs, or blocks in the order of the record, for predictions of what was held out, shape (N,)."""
    starts: Mapping[tuple[str, str], tuple[float, ...]] = field(default_factory=dict)
    """Effect and parameter → coordinates from which its fit starts, where the data tell of some."""
    designs: tuple[tuple[str, "TankForward"], ...] = ()
    """Further measurements in words, and the model of each."""

    @property
    def candidates(self) -> Causes:
        """Effects that the data could show."""
        return tuple(info.id for info in effects_seen_in(self.kind) if not info.lacking_in_tank(self.record))

    @property
    def untestable(self) -> dict[str, str]:
        """Effects that data of this kind could show but these could not, and why."""
        reasons = {info.id: info.lacking_in_tank(self.record) for info in effects_seen_in(self.kind)}
        return {name: reason for name, reason in reasons.items() if reason}


def effects_seen_in(kind: TankKind) -> tuple[EffectInfo, ...]:
    """Effects of the catalogue that a kind of tank data could show."""
    return tuple(info for info in CATALOGUE.values() if kind in info.tank)


def tank_effects(effects: Sequence[Effect]) -> list[TankEffect]:
    """Those that act in a tank only."""
    return [effect for effect in effects if isinstance(effect, TankEffect)]


def descent_effects(effects: Sequence[Effect]) -> list[DescentEffect]:
    """Those that act on a descent too."""
    return [effect for effect in effects if isinstance(effect, DescentEffect)]


def product(factors: Sequence[Array | float]) -> Array | float:
    """Product of the factors; 1 of none."""
    return math.prod(factors) if factors else 1.0


def noise_sd(y: Array, stated: float | None) -> tuple[Array, bool]:
    """Standard deviation of each datum, and whether it was stated: else a guess from the size of the data.

    A stated one is at least `ROUNDING`: no model is computed better.
    """
    size = max(float(np.sqrt(np.mean(y**2))), 1e-12)
    if stated is not None:
        return np.full_like(y, max(stated, ROUNDING * size)), True
    return np.full_like(y, UNSTATED_NOISE * size), False


MAX_ROWS = 600
"""Rows that are kept of a longer record, evenly."""
BLOCKS = 8
"""Blocks into which a record is divided."""
MAX_SINGLE_ROWS = 12
"""Up to so many rows each is a block by itself."""


def decimated(data: TankData) -> TankData:
    """Return every nth row of a long record, with a note of it."""
    count = len(next(iter(data.columns.values())))
    step = -(-count // MAX_ROWS)
    if step == 1:
        return data
    note = f"{count} rows: every {step}th is used"
    return replace(
        data,
        columns={name: column[::step] for name, column in data.columns.items()},
        labels={name: column[::step] for name, column in data.labels.items()},
        notices=(*data.notices, note),
    )


def row_blocks(count: int) -> NDArray[np.str_]:
    """Name of each row's block: rows one by one where they are few, else even blocks in their order."""
    if count <= MAX_SINGLE_ROWS:
        return np.array([f"row {k + 1}" for k in range(count)])
    ends = np.linspace(0, count, BLOCKS + 1).astype(int)
    names = [f"rows {a + 1} to {b}" for a, b in itertools.pairwise(ends.tolist())]
    return np.repeat(names, np.diff(ends))


def _drag(
    unit: Array, reynolds_ratio: Array, coefficient: float | None, values: Array, effects: Sequence[Effect]
) -> Array:
    """Predict the force ½ρA C_D U², shape (N, m) [N].

    `unit`, (N,): force for a coefficient of 1. `reynolds_ratio`, (N,): Reynolds numbers over the one at which the
    coefficient is stated. `coefficient`: C_D of the vehicle file; None where it is fitted.
    """
    level: Scalars = values[0] if coefficient is None else coefficient
    factors = [effect.drag_factor(reynolds_ratio[:, None]) for effect in tank_effects(effects)]
    bias = [np.asarray(effect.lone_drag_factor()) for effect in descent_effects(effects)]
    return np.asarray(unit[:, None] * level * product([*factors, *bias]))


def drag_forward(
    data: TankData, settings: DragSettings, vehicle: Vehicle | None, speed_factor: float = 1.0
) -> TankForward:
    """Bind the model of the drag: the vehicle's where its file has one, else with a coefficient to fit.

    `data`: the runs. `settings`: of the data set. `vehicle`: of the mission. `speed_factor`: on the speeds towed, for a
    further measurement.
    """
    speed, force = speed_factor * data.columns["speed_m_s"], data.columns["force_n"]
    drag = vehicle.drag if vehicle is not None else None
    coefficient = mean_of(drag.coefficient) if drag is not None else None
    # force for a coefficient of 1, and Reynolds numbers over the one at which the coefficient is stated
    exponent = mean_of(drag.exponent) if drag is not None else 0.0
    area = settings.reference_area if drag is None else drag.area / settings.scale**2
    reynolds = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))
    stated_at = drag_reynolds(data, settings, vehicle)
    unit = np.asarray(
        drag_force(speed, osc.reynolds_drag_coefficient(reynolds, 1.0, exponent, stated_at), area, data.density)
    )
    sd, stated = noise_sd(force, settings.noise.force)
    by_run = data.columns.get("force_sd_n")
    if by_run is not None and np.all(by_run > 0.0):
        sd, stated = by_run, True
    fitted = speed_factor**2 * float(unit @ force / (unit @ unit))  # the force is that of the speeds towed
    constant = Nuisance("drag_coefficient", fitted, abs(fitted))
    return TankForward(
        kind="drag",
        record=TankRecord(has_vehicle_drag=coefficient is not None),
        quantity="force_n",
        y=force,
        sd=sd,
        stated=stated,
        nuisances=(constant,) if coefficient is None else (),
        predict=partial(_drag, unit, reynolds / stated_at, coefficient),
        axes={"speed": speed},
        groups=row_blocks(len(force)),
    )


def drag_reynolds(data: TankData, settings: DragSettings, vehicle: Vehicle | None) -> float:
    """Re₀ at which the coefficient is stated: the vehicle's, else the geometric mean of those towed, to two figures."""
    if vehicle is not None and vehicle.drag is not None and vehicle.drag.at_reynolds is not None:
        return vehicle.drag.at_reynolds
    towed = reynolds_number(data.columns["speed_m_s"], settings.reference_length, data.viscosity)
    return float(f"{np.exp(np.mean(np.log(towed))):.2g}")


MIN_MASS_FACTOR = 0.05
"""Least factor of effects on the oscillating mass at which the model is evaluated."""


def oscillation(
    time: Array, stiffness: float, mass: float, larger: float, values: Array, effects: Sequence[Effect]
) -> Array:
    """Predict the displacement of a mass on springs with linear damping, shape (N, m) [m] (Avila et al., sect. 4.2).

    `time`, (N,) [s]. `stiffness`, `mass`: of the springs [N/m], and oscillating [kg]. `larger`: factor on displacement
    and velocity at the release, for a further measurement.
    """
    start, velocity, offset, log_rate = values
    masses = [np.asarray(effect.mass_factor()) for effect in descent_effects(effects)]
    moved = mass * np.maximum(product(masses), MIN_MASS_FACTOR)
    frequency = np.broadcast_to(osc.natural_frequency(stiffness, moved), np.shape(start))
    damping = sum((effect.damping() for effect in tank_effects(effects)), 0.0)
    swing = osc.displacement(time, larger * start, larger * velocity, frequency, np.exp(log_rate), damping)
    return np.asarray(offset + swing)


def oscillation_forward(
    data: TankData, settings: OscillationSettings, vehicle: Vehicle | None, release_factor: float = 1.0
) -> TankForward:
    """Bind the model of a record of displacement.

    `data`: the record. `settings`: of the data set. `vehicle`: of the mission. `release_factor`: on the displacement at
    the release, for a further measurement. Raises InputError when the data are frequencies alone, as many numbers as
    unknowns.
    """
    if "displacement_m" not in data.columns:
        words = "a frequency of each mode is one number for one unknown: nothing is left to test a model by"
        raise InputError([Problem(words, data.settings.file, hint="`missionplan identify` finds the added masses")])
    time, record = data.columns["t_s"], data.columns["displacement_m"]
    mass, stiffness = base_mass(settings, vehicle), settings.stiffness
    begin = {parameter.name: parameter.start for parameter in starting_values(time, record)}
    heavier = stiffness / (2.0 * math.pi * begin["frequency"]) ** 2 / mass - 1.0
    (sd, stated), spread = noise_sd(record, settings.noise.displacement), float(np.std(record))
    # for each strength that adds to the oscillating mass, where it alone gives the measured frequency
    starts: dict[tuple[str, str], tuple[float, ...]] = {}
    for info in effects_seen_in("free-oscillation"):
        for name in info.parameters:
            for effect in descent_effects([info.make({name: 1.0})]):
                added = float(np.asarray(effect.mass_factor())) - 1.0
                if added:
                    starts[info.id, name] = (heavier / added,)
    return TankForward(
        kind="free-oscillation",
        record=TankRecord(),
        quantity="displacement_m",
        y=record,
        sd=sd,
        stated=stated,
        nuisances=(
            Nuisance("start_m", begin["start"], 3.0 * spread),
            Nuisance("start_velocity_m_s", begin["start_velocity"], 6.0 * math.pi * begin["frequency"] * spread),
            Nuisance("offset_m", begin["offset"], spread),
            Nuisance("log_linear_rate", math.log(begin["linear_rate"]), 1.5),
        ),
        predict=partial(oscillation, time, stiffness, mass, release_factor),
        axes={"time": time},
        groups=row_blocks(len(time)),
        starts=starts,
    )


def base_mass(settings: OscillationSettings, vehicle: Vehicle | None) -> float:
    """Mass in air, and the added mass in surge that the vehicle file already has, at the tank's scale [kg]."""
    surge = vehicle.added_mass.surge if vehicle is not None and vehicle.added_mass is not None else None
    return settings.mass + (mean_of(surge) / settings.scale**3 if surge is not None else 0.0)


def full_size_added_mass(
    settings: OscillationSettings, vehicle: Vehicle | None, fraction: float, sd: float
) -> tuple[float, float]:
    """Added mass in surge at full size, and its standard deviation [kg], of a mass larger by a fraction.

    `settings`: of the data set. `vehicle`: of the mission. `fraction`, `sd`: by which the oscillating mass is larger
    than the base model's, and its standard deviation.
    """
    base = base_mass(settings, vehicle)
    return (base * (1.0 + fraction) - settings.mass) * settings.scale**3, base * sd * settings.scale**3


AT_REST = 0.01
"""Speeds below this count as bollard pull [m/s]."""


def _thrust(
    command: Array, speed: Array, area: float, density: float, values: Array, effects: Sequence[Effect]
) -> Array:
    """Predict the thrust cV|V|, one constant c for both directions whatever the speed, shape (N, m) [N].

    `command`, `speed`, (N,): shaft rate [1/s] or voltage [V], and the vehicle's speed [m/s]. `area`: cross-section of
    the tunnel [m²]; nan where it is not known. `density`: of the water [kg/m³].
    """
    static = values[0] * (command * np.abs(command))[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        jet = np.asarray(tt.jet_speed(static, area, density))
        ratio = np.where(jet > 0.0, np.abs(speed)[:, None] / np.where(jet > 0.0, jet, 1.0), 0.0)
    factors = [effect.thrust_factor(command[:, None], ratio) for effect in tank_effects(effects)]
    return np.asarray(static * product(factors))


def thruster_forward(data: TankData, settings: ThrusterSettings) -> TankForward:
    """Bind the model of a thruster's thrust."""
    thrust = data.columns["thrust_n"]
    command = data.columns["voltage_v"] if "voltage_v" in data.columns else data.columns["rpm"] / 60.0
    speed = data.columns.get("speed_m_s", np.zeros_like(thrust))
    area = float(disc_area(settings.geometry.diameter)) if settings.geometry is not None else math.nan
    squared = command * np.abs(command)
    constant = float(squared @ thrust / max(float(squared @ squared), 1e-30))
    (sd, stated), runs = noise_sd(thrust, settings.noise.thrust), data.labels.get("run", [])
    return TankForward(
        kind="thruster",
        record=TankRecord(
            has_both_signs=bool(np.any(command < 0.0) and np.any(command > 0.0)),
            has_jet_speed="voltage_v" not in data.columns and settings.geometry is not None,
            is_under_way=bool(np.any(np.abs(speed) > AT_REST)),
        ),
        quantity="thrust_n",
        y=thrust,
        sd=sd,
        stated=stated,
        nuisances=(Nuisance("thrust_constant", constant, abs(constant)),),
        predict=partial(_thrust, command, speed, area, data.density),
        axes={"command": command} | ({"speed": speed} if np.ptp(speed) > 0.0 else {}),
        # runs where the rows name more than two, else blocks of rows
        groups=np.array(runs) if len(set(runs)) > 2 else row_blocks(len(thrust)),
    )
