"""Descent data sets: craft, dives, nuisances, sensors, and the strength of what is hidden in them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from .case import Case
from .dive import Array, Dive, Track, Twist, sink
from .dive_effects import CATALOGUE, Scenario
from .dive_outside import OUTSIDE, STUDIED
from .drag import GRAVITY, Craft

RELEASE_SD, ZERO_SD, DRAG_SD, WEIGHT_SD = 0.1, 0.05, 0.025, 0.012
"""Scatter from dive to dive at scale 1: separation [s], depth zero [m], drag, weight."""
SWELL_RATE = 2.2e-4
"""Of the random walk that turbulence of 0.006 m/s over 3 s makes of the depth [m²/s]."""
STRONG = 12.0
"""An effect moves the data by this many standard errors at least, else it is made larger."""
LOUD = 60.0
"""And by no more than about this, beyond which the shape of an effect is measured rather than its kind."""
UNLIKE = 5.0
"""An effect outside the catalogue leaves this misfit to the nearest of the catalogue's, at whatever size."""
BLIND_SHARE = 0.75
"""Share of the effects outside the catalogue that the method's authors have not studied."""
NEAR_TIES = ({"line-payout", "clock-offset"}, {"drag-bias", "depth-scale"}, {"drag-bias", "vertical-current"})
"""Never drawn as a pair: the one can cancel or feign the other."""


@dataclass(frozen=True)
class Plan:
    """Everything about the dives but effects and noise."""

    craft: Craft
    site_depth: float
    dives: tuple[Dive, ...]
    states_depth: bool
    vehicle_form: str


@dataclass(frozen=True)
class Nuisances:
    """Of one data set; standard normals times the scatter are drawn per dive."""

    scale: float
    sensor: float
    resolution: float
    swell: float
    swell_time: float


def draw_plan(rng: np.random.Generator, scenario: str, wanted: Sequence[str]) -> Plan:
    """Draw craft, site and dives: 3 to 8 dives with two or three weights and line lengths."""
    diameter = rng.uniform(0.11, 0.135)
    length = diameter * rng.uniform(8.0, 10.5)
    form_factor: str | float = str(rng.choice(["briggs", "hoerner"]))
    if rng.random() < 0.3:
        form_factor = round(rng.uniform(1.8, 2.8), 2)
    hull = np.pi * diameter**2 / 4.0 * (length - diameter / 3.0)
    buoyancy = rng.uniform(0.4, 1.2)
    density, viscosity = [(1025.0, 1.19e-6), (999.0, 1.14e-6), (1010.0, 1.02e-6)][rng.integers(3)]
    anchor = rng.uniform(0.10, 0.13)
    chord = rng.uniform(0.08, 0.12)
    sail = (round(chord, 3), round(chord * rng.uniform(0.8, 1.2), 3), round(0.15 * chord, 4))
    craft = Craft(
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
    middle = craft.net_buoyancy + craft.drag(rng.uniform(1.1, 1.6))
    spread = rng.uniform(1.5, 2.4)
    weights = middle * spread ** np.linspace(-0.5, 0.5, int(rng.integers(2, 4)))
    base_line = rng.uniform(3.0, 5.0)
    tie = scenario == "tie"
    by_line = {"line-payout", "clock-offset", "line-drag"}
    vary = not tie and (bool(by_line & set(wanted)) or rng.random() < 0.6)
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
    dives = tuple(replace(dives[j], number=i) for i, j in enumerate(order))
    return Plan(craft, site, dives, states_depth, str(rng.choice(["inline", "file"])))


def draw_nuisances(rng: np.random.Generator, scenario: str) -> Nuisances:
    """Controls see nuisances of half to twice the usual size."""
    scale = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0)))) if scenario == "control" else rng.uniform(0.5, 1.3)
    sensor = float(np.exp(rng.uniform(np.log(0.01), np.log(0.06))))
    resolution = float(rng.choice([0.0, 0.01, 0.02, 0.05]))
    return Nuisances(scale, sensor, resolution, scale * rng.uniform(0.002, 0.012), rng.uniform(2.0, 5.0))


def scenario_of(plan: Plan) -> Scenario:
    """What the effects' builders may know."""
    weights = [dive.wet_weight for dive in plan.dives]
    slow, fast = plan.craft.terminal_speed(min(weights)), plan.craft.terminal_speed(max(weights))
    ways = [dive.site_depth - dive.line for dive in plan.dives]
    lines = tuple(dive.line for dive in plan.dives)
    return Scenario(min(weights), slow, fast, min(ways), max(ways) / slow + 6.0, lines)


def turbulence(rng: np.random.Generator, sd: float, time: float) -> Twist:
    """Vertical velocity with the spectrum of an Ornstein–Uhlenbeck process: forty smooth harmonics."""
    edges = np.concatenate([[0.0], np.geomspace(0.02, 12.0, 41)]) / time
    mass = np.diff(np.arctan(edges * time)) / (np.pi / 2.0)
    omega = rng.uniform(edges[:-1], edges[1:])
    size = sd * np.sqrt(2.0 * mass) * np.sqrt(rng.exponential(1.0, omega.size))
    phase = rng.uniform(0.0, 2.0 * np.pi, omega.size)
    return Twist(water=lambda t, z: float(np.dot(size, np.cos(omega * t + phase))))


def read_depth(track: Track, dive: Dive, twists: Sequence[Twist], t: Array, late: float = 0.0) -> Array:
    """Depth that the sensor reads without noise at times ``t`` of the log's clock."""
    late = late + sum(twist.delay(dive.line, dive.number) for twist in twists if twist.delay)
    depth = track.depth
    for twist in twists:
        if twist.reading:
            depth = twist.reading(track.t, depth, dive.number)
    return np.interp(t - late, track.t, depth)


@lru_cache(maxsize=64)
def _undisturbed(craft: Craft, dive: Dive) -> Track:
    return sink(craft, dive, (), 90.0, followed=False)


def strength(plan: Plan, noise: Nuisances, twists: Sequence[Twist]) -> tuple[float, Array]:
    """Standard errors by which effects move noise-free dives, and the whitened displacement.

    The covariance is that of the nuisances at their usual size: white noise averaged over four samples, a random walk
    for turbulence, and the scatter of separation, depth zero, drag and weight from dive to dive.
    """
    pieces = []
    for dive in plan.dives:
        base = _undisturbed(plan.craft, dive)
        other = sink(plan.craft, dive, twists, 90.0, followed=False)
        t = np.linspace(0.3, 0.97 * min(base.t_touchdown, other.t_touchdown, 85.0), 40)
        y = read_depth(base, dive, (), t)
        heavier = replace(dive, wet_weight=dive.wet_weight * (1.0 + WEIGHT_SD))
        draggier = replace(dive, drag_factor=1.0 + DRAG_SD)
        columns = [read_depth(base, dive, (), t, RELEASE_SD) - y, np.full(t.size, ZERO_SD)]
        columns += [read_depth(_undisturbed(plan.craft, run), run, (), t) - y for run in (heavier, draggier)]
        jacobian = np.array(columns)
        white = noise.sensor**2 / 4.0 + noise.resolution**2 / 12.0 + 1e-5
        covariance = white * np.eye(t.size) + SWELL_RATE * np.minimum.outer(t, t) + jacobian.T @ jacobian
        factor = np.linalg.cholesky(covariance)
        pieces.append(np.linalg.solve(factor, read_depth(other, dive, twists, t) - y))
    whitened = np.concatenate(pieces)
    return float(np.linalg.norm(whitened)), whitened


def _build(name: str, severity: float, scale: float, shape: int, scenario: Scenario):
    cause = (CATALOGUE | OUTSIDE)[name]
    size = scale * cause.low * (cause.high / cause.low) ** severity
    twist, parameters = cause.build(size, np.random.default_rng(shape), scenario)
    return twist, {f"{name}.{key}": float(value) for key, value in parameters.items()}, float(size)


@dataclass(frozen=True)
class Hidden:
    """Effects as drawn: twists, comparable parameters, sizes, and how far they move the data."""

    twists: tuple[Twist, ...]
    parameters: dict[str, float]
    sizes: dict[str, float]
    strength: float


def hide(
    plan: Plan, noise: Nuisances, names: Sequence[str], rng: np.random.Generator, scale: float, late: bool
) -> Hidden | None:
    """Draw the effects' sizes, enlarging what is not clearly above the nuisances.

    None if the largest is not, or if ``late`` and a clock's offset is of the sign that no pay-out can have.
    """
    scenario = scenario_of(plan)
    severity = {name: rng.uniform(0.0, 0.9 if len(names) == 1 else 0.6) for name in names}
    shape = {name: int(rng.integers(2**32)) for name in names}
    if late and any(
        _build(name, 0.5, 1.0, shape[name], scenario)[1].get("clock-offset.time", 1.0) < 0 for name in names
    ):
        return None
    enlarged = False
    while names:
        built = {name: _build(name, severity[name], 1.0, shape[name], scenario) for name in names}
        twists = {name: built[name][0] for name in names}
        total, far = strength(plan, noise, tuple(twists.values()))
        weak = [name for name in names if not _stands_out(plan, noise, names, twists, name, far, total)]
        if not weak:
            if len(names) == 1 and not enlarged and severity[names[0]] > -1.0 and total > LOUD:
                severity[names[0]] -= 0.25
                continue
            break
        if any(severity[name] >= 1.0 for name in weak):
            return None
        severity |= {name: min(1.0, severity[name] + 0.34) for name in weak}
        enlarged = True  # and not made smaller again: what is unlike the catalogue may have to be loud
    built = {name: _build(name, severity[name], scale, shape[name], scenario) for name in names}
    twists = tuple(item[0] for item in built.values())
    reached = 0.0
    if names:
        reached = total if scale == 1.0 else strength(plan, noise, twists)[0]
    parameters = {key: value for item in built.values() for key, value in item[1].items()}
    return Hidden(twists, parameters, {name: item[2] for name, item in built.items()}, reached)


def _stands_out(plan, noise, names, twists, name, far: Array, total: float) -> bool:
    """Alone: strong enough. In a pair: the other, at whatever size, leaves clear misfit without it."""
    if len(names) == 1:
        return total >= STRONG and (name in CATALOGUE or unlike_catalogue(plan, noise, twists[name]) >= UNLIKE)
    other = next(each for each in names if each != name)
    return _left(far, strength(plan, noise, (twists[other],))[1]) >= 0.6 * STRONG


def _left(far: Array, rival: Array) -> float:
    """What a rival, scaled to fit best, leaves of a displacement [standard errors]."""
    share = float(rival @ far) / max(float(rival @ rival), 1e-12)
    return float(np.linalg.norm(far - share * rival))


def unlike_catalogue(plan: Plan, noise: Nuisances, twist: Twist) -> float:
    """Misfit that the nearest single cause of the catalogue leaves of an effect [standard errors]."""
    far = strength(plan, noise, (twist,))[1]
    return min(_left(far, rival) for rival in _rivals(plan, noise))


@lru_cache(maxsize=4)
def _rivals(plan: Plan, noise: Nuisances) -> tuple[Array, ...]:
    """Whitened displacements by each cause of the catalogue at a middling size."""
    twists = [_build(name, 0.5, 1.0, 0, scenario_of(plan))[0] for name in CATALOGUE]
    return tuple(strength(plan, noise, (twist,))[1] for twist in twists)


def _pick(rng: np.random.Generator, scenario: str) -> tuple[str, ...]:
    if scenario == "control":
        return ()
    if scenario == "outside":
        blind = rng.random() < BLIND_SHARE
        return (str(rng.choice([name for name in OUTSIDE if (name in STUDIED) != blind])),)
    if scenario == "tie":
        return (str(rng.choice(["line-payout", "clock-offset"])),)
    while True:
        names = tuple(sorted(str(name) for name in rng.choice(list(CATALOGUE), 1 + (scenario == "pair"), False)))
        if not any(tie <= set(names) for tie in NEAR_TIES):
            return names


def draw(seed: int, scenario: str, effect: str | None = None) -> Case:
    """Draw a descent case; deterministic for its arguments."""
    base = [seed, 1, sum(map(ord, scenario))]
    names = _pick(np.random.default_rng(base), scenario)
    if effect is not None:
        names = (effect,)
    scale = 0.25 if scenario == "weak" else 1.0
    for attempt in range(20):
        shape, hiding, noise_rng = np.random.default_rng([*base, attempt]).spawn(3)
        plan = draw_plan(shape, scenario, names)
        noise = draw_nuisances(shape, scenario)
        hidden = hide(plan, noise, names, hiding, scale, scenario == "tie")
        if hidden is not None:
            break
    else:
        raise RuntimeError(f"no plan shows {names} (seed {seed})")
    header, rows, stated = measure(plan, noise, hidden.twists, noise_rng)
    same_line = len({dive.line for dive in plan.dives}) == 1
    ties: tuple[tuple[str, ...], ...] = ()
    if same_line and {"line-payout", "clock-offset"} & set(names):
        swap = {"line-payout": "clock-offset", "clock-offset": "line-payout"}
        ties = (tuple(sorted(swap.get(name, name) for name in names)),)
    inside = scenario != "outside"
    mission, vehicle = mission_files(plan, shape)
    return Case(
        seed=seed,
        kind="descent",
        scenario=scenario,
        truth=names if inside else (),
        ties=ties,
        outside="" if inside else names[0],
        parameters=hidden.parameters if inside else {},
        strength=hidden.strength,
        mission=mission,
        vehicle=vehicle,
        dataset=stated,
        header=header,
        rows=rows,
        notes={"sizes": hidden.sizes, "nuisances": vars(noise), "attempt": attempt},
    )


def measure(plan: Plan, noise: Nuisances, twists: Sequence[Twist], rng: np.random.Generator):
    """Run the dives with their nuisances and log them: header, rows, and ``dataset.yaml``."""
    case_rng, *streams = rng.spawn(1 + len(plan.dives))
    rate = case_rng.uniform(2.0, 10.0)
    uneven = case_rng.uniform(0.0, 0.35)
    missing = case_rng.choice([0.0, 0.02, 0.1])
    goes_on = case_rng.random() < 0.6
    early = case_rng.uniform(1.0, 5.0) if case_rng.random() < 0.2 else 0.0
    with_pitch = case_rng.random() < 0.3
    blanks = case_rng.random() < 0.2
    header = ["run", "t_s", "depth_m"] + (["pitch_deg"] if with_pitch else [])
    rows = []
    for dive, stream in zip(plan.dives, streams, strict=True):
        z = stream.standard_normal(4) * noise.scale * np.array([RELEASE_SD, ZERO_SD, DRAG_SD, WEIGHT_SD])
        real = replace(dive, drag_factor=1.0 + z[2], wet_weight=dive.wet_weight * (1.0 + z[3]))
        swell = turbulence(stream, noise.swell, noise.swell_time)
        track = sink(plan.craft, real, (*twists, swell), 90.0)
        late = z[0] + sum(twist.delay(real.line, real.number) for twist in twists if twist.delay)
        end = track.t_touchdown if np.isfinite(track.t_touchdown) else 80.0
        end += stream.uniform(1.5, 8.0) if goes_on else -stream.uniform(0.02, 0.12) * end
        grid = np.arange(-early, end, 1.0 / rate)
        t = grid + stream.uniform(-uneven, uneven, grid.size) / rate
        t = t[(stream.random(t.size) >= missing) & (t >= -early)]
        depth = read_depth(track, real, twists, t, z[0]) + z[1] + noise.sensor * stream.standard_normal(t.size)
        if noise.resolution:
            depth = noise.resolution * np.round(depth / noise.resolution)
        since = np.maximum(t - late - track.t_taut, 0.0)
        pitch = np.round(_pitch(twists, since) + 2.0 * stream.standard_normal(t.size), 1)
        for k in range(t.size):
            lost = blanks and stream.random() < 0.01
            row = [f"dive-{dive.number + 1}", f"{t[k]:.2f}", "" if lost else f"{depth[k]:.3f}"]
            rows.append(row + ([f"{pitch[k]:.1f}"] if with_pitch else []))
    runs: dict[str, Any] = {}
    for dive in plan.dives:
        run = {"anchor_wet_weight": f"{dive.wet_weight} N", "line_length": f"{dive.line} m"}
        runs[f"dive-{dive.number + 1}"] = run | ({"depth": f"{dive.site_depth} m"} if plan.states_depth else {})
    stated: dict[str, Any] = {"kind": "descent", "name": "Dive trials", "file": "dives.csv", "runs": runs}
    if case_rng.random() < 0.6:
        stated["noise"] = {"depth": f"{noise.sensor:.3f} m"}
    return header, rows, stated | {"source": "made up"}


def _pitch(twists: Sequence[Twist], since: Array) -> Array:
    """Pitch, nose down positive: level until the line is taut, then nose down, or as an effect would have it [deg]."""
    slope = 90.0 * np.exp(-since / 0.4)
    for twist in twists:
        if twist.pitch:
            other = twist.pitch(since)
            slope = np.where(np.abs(other) > np.abs(slope), other, slope)
    return 90.0 - np.abs(slope)


def mission_files(plan: Plan, rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Any] | None]:
    """Base mission in the contract's form, with the vehicle inline (then no second file) or beside it."""
    craft, first = plan.craft, plan.dives[0]
    hull = {"length": f"{craft.length} m", "diameter": f"{craft.diameter} m", "form_factor": craft.form_factor}
    vehicle: dict[str, Any] = {"name": "Trial vehicle", "hull": hull}
    if craft.sail is not None:
        names = ("chord", "span", "thickness")
        vehicle["sail"] = {name: f"{value} m" for name, value in zip(names, craft.sail, strict=True)}
    vehicle |= {
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
    inline = plan.vehicle_form == "inline"
    mission = {
        "name": "Mooring trial",
        "vehicle": vehicle if inline else "vehicle.yaml",
        "site": {
            "depth": f"{plan.site_depth} m",
            "water": {"density": f"{craft.density} kg/m^3", "viscosity": f"{craft.viscosity:.3e} m^2/s"},
            "current": [
                {
                    "down_to": f"{plan.site_depth} m",
                    "speed": {"mean": f"{rng.uniform(0.1, 0.6):.2f} m/s", "sd": "0.1 m/s"},
                    "toward": "60 deg",
                }
            ],
        },
        "phases": [
            {
                "moor": {
                    "radius": "25 m",
                    "anchor_wet_weight": f"{first.wet_weight} N",
                    "line_length": f"{first.line} m",
                    "release_time": {"mean": "2 s", "sd": "0.5 s", "low": "0 s"},
                }
            }
        ],
        "monte_carlo": {"trials": 2000, "seed": 1},
    }
    return mission, None if inline else vehicle
