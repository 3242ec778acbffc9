"""Files of a descent case: the log of the dives and the base mission."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .dynamics import Array, Dive, DiveEffect, simulate_dive
from .strength import read_depth
from .trials import DRAG_SD, RELEASE_SD, WEIGHT_SD, ZERO_SD, Nuisances, Plan, turbulence


@dataclass(frozen=True)
class _Logger:
    """Sampling of a data set, the same for all its dives."""

    rate: float
    uneven: float
    missing: float
    goes_on: bool
    early: float
    with_pitch: bool
    blanks: bool

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> "_Logger":
        return cls(
            rate=rng.uniform(2.0, 10.0),
            uneven=rng.uniform(0.0, 0.35),
            missing=rng.choice([0.0, 0.02, 0.1]),
            goes_on=rng.random() < 0.6,
            early=rng.uniform(1.0, 5.0) if rng.random() < 0.2 else 0.0,
            with_pitch=rng.random() < 0.3,
            blanks=rng.random() < 0.2,
        )

    def times(self, rng: np.random.Generator, end: float) -> Array:
        """Sampling times of one dive, uneven and with gaps [s]."""
        grid = np.arange(-self.early, end, 1.0 / self.rate)
        t = grid + rng.uniform(-self.uneven, self.uneven, grid.size) / self.rate
        return t[(rng.random(t.size) >= self.missing) & (t >= -self.early)]


def measure(plan: Plan, noise: Nuisances, effects: Sequence[DiveEffect], rng: np.random.Generator):
    """Simulate the dives with their nuisances and log them: header, rows, and ``dataset.yaml``."""
    case_rng, *streams = rng.spawn(1 + len(plan.dives))
    logger = _Logger.drawn(case_rng)
    header = ["run", "t_s", "depth_m"] + (["pitch_deg"] if logger.with_pitch else [])
    rows = []
    for dive, stream in zip(plan.dives, streams, strict=True):
        rows += _log_dive(plan, dive, noise, effects, logger, stream)
    runs: dict[str, Any] = {}
    for dive in plan.dives:
        run = {"anchor_wet_weight": f"{dive.wet_weight} N", "line_length": f"{dive.line} m"}
        runs[f"dive-{dive.number + 1}"] = run | ({"depth": f"{dive.site_depth} m"} if plan.states_depth else {})
    stated: dict[str, Any] = {"kind": "descent", "name": "Dive trials", "file": "dives.csv", "runs": runs}
    if case_rng.random() < 0.6:
        stated["noise"] = {"depth": f"{noise.sensor:.3f} m"}
    return header, rows, stated | {"source": "made up"}


def _log_dive(
    plan: Plan,
    dive: Dive,
    noise: Nuisances,
    effects: Sequence[DiveEffect],
    logger: _Logger,
    stream: np.random.Generator,
) -> list[list[str]]:
    z = stream.standard_normal(4) * noise.scale * np.array([RELEASE_SD, ZERO_SD, DRAG_SD, WEIGHT_SD])
    real = replace(dive, drag_factor=1.0 + z[2], wet_weight=dive.wet_weight * (1.0 + z[3]))
    swell = turbulence(stream, noise.swell, noise.swell_time)
    track = simulate_dive(plan.craft, real, (*effects, swell), 90.0)
    late = z[0] + sum(effect.delay(real.line, real.number) for effect in effects if effect.delay)
    end = track.t_touchdown if np.isfinite(track.t_touchdown) else 80.0
    end += stream.uniform(1.5, 8.0) if logger.goes_on else -stream.uniform(0.02, 0.12) * end
    t = logger.times(stream, end)
    depth = read_depth(track, real, effects, t, z[0]) + z[1] + noise.sensor * stream.standard_normal(t.size)
    if noise.resolution:
        depth = noise.resolution * np.round(depth / noise.resolution)
    since = np.maximum(t - late - track.t_taut, 0.0)
    pitch = np.round(_pitch(effects, since) + 2.0 * stream.standard_normal(t.size), 1)
    rows = []
    for k in range(t.size):
        lost = logger.blanks and stream.random() < 0.01
        row = [f"dive-{dive.number + 1}", f"{t[k]:.2f}", "" if lost else f"{depth[k]:.3f}"]
        rows.append(row + ([f"{pitch[k]:.1f}"] if logger.with_pitch else []))
    return rows


def _pitch(effects: Sequence[DiveEffect], since: Array) -> Array:
    """Pitch, nose down positive: level until the line is taut, then nose down, or as an effect has it [deg]."""
    slope = 90.0 * np.exp(-since / 0.4)
    for effect in effects:
        if effect.pitch:
            other = effect.pitch(since)
            slope = np.where(np.abs(other) > np.abs(slope), other, slope)
    return 90.0 - np.abs(slope)


def mission_files(plan: Plan, rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Any] | None]:
    """Return the base mission, with the vehicle inline (then None) or in a second file."""
    craft, first = plan.craft, plan.dives[0]
    inline = plan.vehicle_form == "inline"
    vehicle = _vehicle(plan)
    current = {
        "down_to": f"{plan.site_depth} m",
        "speed": {"mean": f"{rng.uniform(0.1, 0.6):.2f} m/s", "sd": "0.1 m/s"},
        "toward": "60 deg",
    }
    moor = {
        "radius": "25 m",
        "anchor_wet_weight": f"{first.wet_weight} N",
        "line_length": f"{first.line} m",
        "release_time": {"mean": "2 s", "sd": "0.5 s", "low": "0 s"},
    }
    mission = {
        "name": "Mooring trial",
        "vehicle": vehicle if inline else "vehicle.yaml",
        "site": {
            "depth": f"{plan.site_depth} m",
            "water": {"density": f"{craft.density} kg/m^3", "viscosity": f"{craft.viscosity:.3e} m^2/s"},
            "current": [current],
        },
        "phases": [{"moor": moor}],
        "monte_carlo": {"trials": 2000, "seed": 1},
    }
    return mission, None if inline else vehicle


def _vehicle(plan: Plan) -> dict[str, Any]:
    craft = plan.craft
    hull = {"length": f"{craft.length} m", "diameter": f"{craft.diameter} m", "form_factor": craft.form_factor}
    vehicle: dict[str, Any] = {"name": "Trial vehicle", "hull": hull}
    if craft.sail is not None:
        names = ("chord", "span", "thickness")
        vehicle["sail"] = {name: f"{value} m" for name, value in zip(names, craft.sail, strict=True)}
    return vehicle | {
        "appendage_factor": craft.appendage_factor,
        "mass": f"{craft.mass} kg",
        "net_buoyancy": f"{craft.net_buoyancy} N",
        "anchor": {
            "diameter": f"{craft.anchor_diameter} m",
            "drag_coefficient": craft.anchor_drag_coefficient,
            "overlap_volume": "0.3 L",
            "flooded_mass": f"{craft.anchor_flooded_mass} kg",
        },
        "energy": {"hotel": "8 W", "propulsive_efficiency": 0.45, "capacity": "60 W*h"},
    }
