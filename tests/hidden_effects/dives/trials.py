"""Descent trials without effects: craft, site, dives and nuisances."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .catalogue import DiveConditions
from .drag import GRAVITY, Craft
from .dynamics import Dive, DiveEffect

RELEASE_SD, ZERO_SD, DRAG_SD, WEIGHT_SD = 0.1, 0.05, 0.025, 0.012
"""Scatter from dive to dive at scale 1: separation [s], depth zero [m], drag, weight."""
WATERS = ((1025.0, 1.19e-6), (999.0, 1.14e-6), (1010.0, 1.02e-6))
"""Density [kg/m³] and kinematic viscosity [m²/s]: sea, lake, estuary."""
NEED_SEVERAL_LINES = {"line-payout", "clock-offset", "line-drag"}


@dataclass(frozen=True)
class Plan:
    """Everything about the dives except effects and noise."""

    craft: Craft
    site_depth: float
    dives: tuple[Dive, ...]
    states_depth: bool
    vehicle_form: str


@dataclass(frozen=True)
class Nuisances:
    """Nuisances of one data set; standard normals times the scatter are drawn per dive."""

    scale: float
    sensor: float
    resolution: float
    swell: float
    swell_time: float


def draw_plan(rng: np.random.Generator, scenario: str, wanted: Sequence[str]) -> Plan:
    """Draw craft, site and dives: 3 to 8 dives with two or three weights and line lengths."""
    craft = _draw_craft(rng)
    middle = craft.net_buoyancy + craft.drag(rng.uniform(1.1, 1.6))
    spread = rng.uniform(1.5, 2.4)
    weights = middle * spread ** np.linspace(-0.5, 0.5, int(rng.integers(2, 4)))
    base_line = rng.uniform(3.0, 5.0)
    vary = scenario != "tie" and (bool(NEED_SEVERAL_LINES & set(wanted)) or rng.random() < 0.6)
    lines = base_line * np.array([1.0, 2.0, 3.0][: int(rng.integers(2, 4))]) if vary else np.array([base_line])
    count = int(rng.integers(4 if scenario in ("pair", "outside") else 3, 9))
    site = round(rng.uniform(18.0, 42.0) + (lines[-1] - lines[0]), 1)
    states_depth = rng.random() < 0.6
    dives = []
    for k in range(count):
        depth = round(site + (rng.uniform(-2.0, 4.0) if states_depth else 0.0), 1)
        line = lines[(k // len(weights) + k) % len(lines)]
        dives.append(Dive(round(float(weights[k % len(weights)]), 2), round(float(line), 1), depth, number=k))
    order = rng.permutation(count)
    shuffled = tuple(replace(dives[j], number=i) for i, j in enumerate(order))
    return Plan(craft, site, shuffled, states_depth, str(rng.choice(["inline", "file"])))


def _draw_craft(rng: np.random.Generator) -> Craft:
    diameter = rng.uniform(0.11, 0.135)
    length = diameter * rng.uniform(8.0, 10.5)
    form_factor: str | float = str(rng.choice(["briggs", "hoerner"]))
    if rng.random() < 0.3:
        form_factor = round(rng.uniform(1.8, 2.8), 2)
    hull = np.pi * diameter**2 / 4.0 * (length - diameter / 3.0)
    buoyancy = rng.uniform(0.4, 1.2)
    density, viscosity = WATERS[rng.integers(3)]
    anchor = rng.uniform(0.10, 0.13)
    chord = rng.uniform(0.08, 0.12)
    sail = (round(chord, 3), round(chord * rng.uniform(0.8, 1.2), 3), round(0.15 * chord, 4))
    return Craft(
        length=round(length, 3),
        diameter=round(diameter, 4),
        form_factor=form_factor,
        sail=sail if rng.random() < 0.7 else None,
        appendage_factor=round(rng.uniform(1.1, 1.3), 2),
        mass=round(density * hull - buoyancy / GRAVITY, 2),
        net_buoyancy=round(buoyancy, 2),
        anchor_diameter=round(anchor, 3),
        anchor_drag_coefficient=round(rng.uniform(0.18, 0.35), 2),
        anchor_flooded_mass=round(rng.uniform(2.2, 3.2), 2),
        density=density,
        viscosity=viscosity,
    )


def draw_nuisances(rng: np.random.Generator, scenario: str) -> Nuisances:
    """Draw the nuisances; those of controls are half to twice the usual size."""
    scale = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0)))) if scenario == "control" else rng.uniform(0.5, 1.3)
    sensor = float(np.exp(rng.uniform(np.log(0.01), np.log(0.06))))
    resolution = float(rng.choice([0.0, 0.01, 0.02, 0.05]))
    return Nuisances(scale, sensor, resolution, scale * rng.uniform(0.002, 0.012), rng.uniform(2.0, 5.0))


def conditions_of(plan: Plan) -> DiveConditions:
    """Return the conditions that the effects' builders depend on."""
    weights = [dive.wet_weight for dive in plan.dives]
    slow, fast = plan.craft.terminal_speed(min(weights)), plan.craft.terminal_speed(max(weights))
    ways = [dive.site_depth - dive.line for dive in plan.dives]
    lines = tuple(dive.line for dive in plan.dives)
    return DiveConditions(min(weights), slow, fast, min(ways), max(ways) / slow + 6.0, lines)


def turbulence(rng: np.random.Generator, sd: float, time: float) -> DiveEffect:
    """Vertical velocity with the spectrum of an Ornstein–Uhlenbeck process: forty smooth harmonics."""
    edges = np.concatenate([[0.0], np.geomspace(0.02, 12.0, 41)]) / time
    mass = np.diff(np.arctan(edges * time)) / (np.pi / 2.0)
    omega = rng.uniform(edges[:-1], edges[1:])
    size = sd * np.sqrt(2.0 * mass) * np.sqrt(rng.exponential(1.0, omega.size))
    phase = rng.uniform(0.0, 2.0 * np.pi, omega.size)
    return DiveEffect(water=lambda t, z: float(np.dot(size, np.cos(omega * t + phase))))
