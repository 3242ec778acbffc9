"""Tank experiments with hidden effects, from the papers' formulas implemented again.

``python -m tests.hidden_effects.tank --cases 200`` runs the tool and prints how often it is right.
"""

import argparse
import math
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from .case import Case
from .tool import Outcome, diagnose

EFFECTS = {
    "drag": ("drag-bias", "reynolds-drag"),
    "free-oscillation": ("added-mass", "quadratic-damping"),
    "thruster": ("jet-suction", "thrust-asymmetry"),
    "propeller-transient": ("axial-flow",),
}
PRIOR_SD = {"drag-bias": 0.02, "reynolds-drag": 0.01, "added-mass": 0.03, "quadratic-damping": 0.02}
"""Prior uncertainty of an experimenter, also present in controls: one standard deviation of each effect."""
PRIOR_SD |= {"jet-suction": 0.05, "thrust-asymmetry": 0.01}
SMALLEST, LARGEST = 5.0, 20.0
"""Sizes of the effects in standard errors, which include the prior uncertainty and the sensor's noise."""
MISSION = {
    "name": "Base of the tank cases",
    "site": {"water": {"density": "1000 kg/m^3", "viscosity": "1.01e-6 m^2/s"}},
    "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "90 s"},
    "phases": [
        {"transit": {"name": "run", "from": ["0 m", "0 m"], "to": ["3 km", "0 m"], "speed": "1 m/s", "d_max": "1 km",
                     "arrival_radius": "50 m"}}
    ],
    "monte_carlo": {"trials": 100, "seed": 1},
}  # fmt: skip
Model = Callable[[dict[str, float]], np.ndarray]


class Rig:
    """One experiment: data set keys and columns, and the noise-free reading for sizes of effects and nuisances."""

    def __init__(self, dataset: dict, columns: dict[str, np.ndarray], read: Model, noise: float | np.ndarray) -> None:
        self.dataset, self.columns, self.read = dataset, columns, read
        self.noise = np.broadcast_to(noise, len(next(iter(columns.values())))).astype(float)
        self.quantity = ""
        self.nuisances: dict[str, float] = {}
        self.vehicle: dict | None = None


def towing(rng: np.random.Generator) -> Rig:
    """A half-scale model towed at a dozen speeds or more: force ½ρAC_D U²(1 + b)(U/U₀)^p, U₀ their geometric mean."""
    speed = np.round(np.geomspace(0.2, rng.uniform(1.0, 1.6), int(rng.integers(12, 25))), 4)
    area, coefficient = rng.uniform(0.05, 0.15), rng.uniform(0.4, 2.2)
    middle = float(np.exp(np.mean(np.log(speed))))
    share = rng.uniform(0.01, 0.03)

    def read(size: dict[str, float]) -> np.ndarray:
        plain = 500.0 * area * coefficient * speed**2
        return plain * (1.0 + size.get("drag-bias", 0.0)) * (speed / middle) ** size.get("reynolds-drag", 0.0)

    rig = Rig({"kind": "drag"}, {"speed_m_s": speed}, read, share * read({}))
    rig.dataset |= {"reference_area": f"{area} m^2", "reference_length": "0.3 m", "scale": 2.0}
    rig.columns["force_sd_n"] = rig.noise
    hull = {"length": "1.2 m", "diameter": "0.4 m"}
    drag = {"coefficient": coefficient, "area": f"{4.0 * area} m^2"}
    rig.vehicle, rig.quantity = {"hull": hull, "drag": drag}, "force_n"
    return rig


def springs(rng: np.random.Generator) -> Rig:
    """A model released on springs, by Runge–Kutta steps of 1/200 period."""
    mass, stiffness = rng.uniform(15.0, 30.0), rng.uniform(2500.0, 5000.0)
    start, linear, every = rng.uniform(0.03, 0.07), rng.uniform(0.1, 0.3), 24
    step = 2.0 * math.pi * math.sqrt(mass / stiffness) / 200.0
    count = 72

    def read(size: dict[str, float]) -> np.ndarray:
        square = stiffness / mass / (1.0 + size.get("added-mass", 0.0))
        rate = size.get("quadratic-damping", 0.0)
        x, v, out = start + size.get("start", 0.0), size.get("kick", 0.0), []
        decay = 2.0 * linear * (1.0 + size.get("linear", 0.0))

        def pull(x: float, v: float) -> float:
            return -square * x - (decay + rate * abs(v)) * v

        for k in range(count * every):
            if k % every == 0:
                out.append(x)
            v2 = v + 0.5 * step * (a1 := pull(x, v))
            v3 = v + 0.5 * step * (a2 := pull(x + 0.5 * step * v, v2))
            v4 = v + step * (a3 := pull(x + 0.5 * step * v2, v3))
            a4 = pull(x + step * v3, v4)
            x, v = x + step / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        return np.array(out) + size.get("offset", 0.0)

    rig = Rig({"kind": "free-oscillation"}, {"t_s": step * every * np.arange(count)}, read, rng.uniform(2e-4, 5e-4))
    rig.dataset |= {"stiffness": f"{stiffness} N/m", "mass": f"{mass} kg"}
    rig.nuisances = {"start": 0.01, "kick": 0.05, "offset": 0.01, "linear": 0.3}
    rig.quantity = "displacement_m"
    return rig


def jets(rng: np.random.Generator, decay: float = 0.0) -> Rig:
    """A tunnel thruster in both directions, at rest and under way: K₃n|n|·exp(-c ρA u²/|K₃n²|), less astern.

    With a decay given, the speeds are at most 0.7 m/s and what leaves 3/10 of the highest static thrust.
    """
    rates = np.linspace(900.0, 2400.0, 4)
    command, share = (grid.ravel() for grid in np.meshgrid(np.r_[-rates, rates] / 60.0, [0.0, 3 / 7, 5 / 7, 1.0]))
    constant, width = rng.uniform(0.01, 0.04), rng.uniform(0.06, 0.1)
    jet = math.sqrt(constant * 1600.0 / (1000.0 * math.pi / 4.0 * width**2))
    speed = share * (min(0.7, jet * math.sqrt(1.2 / decay)) if decay else 0.7)
    noise = rng.uniform(0.01, 0.02) * constant * 1600.0

    def read(size: dict[str, float]) -> np.ndarray:
        static = constant * (1.0 + size.get("constant", 0.0)) * command**2
        suction = np.exp(-size.get("jet-suction", 0.0) * speed**2 * 1000.0 * math.pi / 4.0 * width**2 / static)
        astern = np.where(command < 0.0, 1.0 - size.get("thrust-asymmetry", 0.0), 1.0)
        return np.sign(command) * static * suction * astern

    rig = Rig({"kind": "thruster"}, {"rpm": 60.0 * command, "speed_m_s": speed}, read, noise)
    rig.dataset |= {"geometry": {"diameter": f"{width} m"}, "noise": {"thrust": f"{noise} N"}}
    rig.nuisances, rig.quantity = {"constant": 0.5}, "thrust_n"
    return rig


def blades(rng: np.random.Generator, quicker: float = 1.0) -> Rig:
    """A propeller at an oscillating shaft rate behind an accelerating hull; the flow in the disc by small steps of Heun.

    Sampled and driven `quicker` times as fast where the flow settles fast.
    """
    count, step, a, w = 120, 0.06 / quicker, 0.2, 0.15
    width, level, slope = 0.3, rng.uniform(0.35, 0.5), rng.uniform(-1.0, -0.7)
    time = step * np.arange(count)
    period, phase = rng.uniform(2.0, 4.0) / quicker, rng.uniform(0.0, 6.0)

    def turns(t: np.ndarray) -> np.ndarray:
        return 7.0 + 3.0 * np.sin(2.0 * math.pi * t / period + phase)

    speed = 0.9 - 0.7 * np.exp(-time / 4.0)
    disc = math.pi / 4.0 * width**2
    noise = rng.uniform(0.3, 1.0)

    def read(size: dict[str, float]) -> np.ndarray:
        k0, k1 = level * (1.0 + size.get("level", 0.0)), slope * (1.0 + size.get("slope", 0.0))

        def push(n: np.ndarray | float, flow: np.ndarray | float) -> np.ndarray | float:
            return 1000.0 * width**3 * n * (width * k0 * n + k1 * flow / (1.0 + a))

        settled = (1.0 + a) * (1.0 - w) * speed
        factor = size.get("axial-flow", 0.0)
        if factor == 0.0:
            return np.asarray(push(turns(time), settled))
        fine, sub = 40, []
        rate = np.interp(np.arange(count * fine + 1) * step / fine, time, turns(time))
        way = np.interp(np.arange(count * fine + 1) * step / fine, time, speed)
        n0, u0 = rate[0], (1.0 - w) * way[0]
        # steady at the start: thrust = d|u|(u - u0) solved for u
        b, c = 1000.0 * width**3 * n0 * k1 / (1.0 + a), 1000.0 * width**4 * k0 * n0**2
        d = 2000.0 * disc
        flow = ((d * u0 + b) + math.sqrt((d * u0 + b) ** 2 + 4.0 * d * c)) / (2.0 * d)

        def change(k: int, flow: float) -> float:
            force = push(rate[k], flow) - d * abs(flow) * (flow - (1.0 - w) * way[k])
            return float(step / fine * force / (factor * 1000.0 * disc * width))

        for k in range(count * fine):
            if k % fine == 0:
                sub.append(flow)
            first = change(k, flow)
            flow += 0.5 * (first + change(k + 1, flow + first))
        return np.asarray(push(turns(time), np.array(sub)))

    rig = Rig(
        {"kind": "propeller-transient"}, {"t_s": time, "rpm": 60.0 * turns(time), "speed_m_s": speed}, read, noise
    )
    rig.dataset |= {"noise": {"thrust": f"{noise} N"}}
    rig.dataset["geometry"] = {"diameter": f"{width} m", "wake_fraction": w, "axial_flow_factor": a}
    rig.nuisances, rig.quantity = {"level": 0.5, "slope": 0.5}, "thrust_n"
    return rig


RIGS = {"drag": towing, "free-oscillation": springs, "thruster": jets, "propeller-transient": blades}


def strength(rig: Rig, effect: str, size: float, others: tuple[str, ...]) -> float:
    """Return an effect's size over its standard error, from noise, nuisances and the prior uncertainty of all effects.

    By derivatives at its size. An effect without prior uncertainty (present or absent) counts by the change of the data.
    """
    here = rig.read({effect: size})
    unsure = {name: PRIOR_SD[name] for name in others if name in PRIOR_SD and name != effect}
    columns = [
        (rig.read({effect: size, name: 1e-3 * sd}) - here) / 1e-3 for name, sd in (rig.nuisances | unsure).items()
    ]
    white = np.stack(columns, axis=1) / rig.noise[:, None] if columns else np.zeros((len(here), 0))
    step = 1e-3 * PRIOR_SD.get(effect, 0.0)
    moved = (rig.read({effect: size + step}) - here) / step if step else here - rig.read({})
    moved = moved / rig.noise
    pulled = white.T @ moved
    inside = pulled @ np.linalg.solve(np.eye(white.shape[1]) + white.T @ white, pulled)
    length = math.sqrt(max(float(moved @ moved - inside), 1e-30))
    return abs(size) / math.hypot(1.0 / length, PRIOR_SD[effect]) if step else length


def size_for(rig: Rig, effect: str, wanted: float, others: tuple[str, ...]) -> float:
    """Return the size at which an effect has the wanted strength, the largest if none has."""
    high = {"drag-bias": 2.0, "reynolds-drag": 0.6, "added-mass": 2.0, "jet-suction": 8.0}.get(effect, 0.9)
    high = 8.0 if effect == "quadratic-damping" else high

    def lacking(size: float) -> float:
        return strength(rig, effect, size, others) - wanted

    return float(brentq(lacking, 0.0, high)) if lacking(high) > 0.0 else high


def draw(seed: int, kind: str, effect: str | None) -> Case:
    """Draw an experiment of a kind with one effect, or with none."""
    rng = np.random.default_rng([seed, list(RIGS).index(kind)])
    rig = RIGS[kind](rng)
    sizes = {
        name: PRIOR_SD[name] * rng.standard_normal() for name in EFFECTS[kind] if name in PRIOR_SD and name != effect
    }
    reached = 0.0
    if effect == "axial-flow":
        sizes[effect] = float(np.exp(rng.normal(0.0, 0.7)))
    elif effect is not None:
        sizes[effect] = size_for(rig, effect, rng.uniform(SMALLEST, LARGEST), EFFECTS[kind])
        if effect in ("drag-bias", "reynolds-drag", "thrust-asymmetry") and rng.random() < 0.3:
            sizes[effect] = -0.7 * sizes[effect] if -0.7 * sizes[effect] > -0.6 else sizes[effect]
    if effect is not None:
        reached = strength(rig, effect, sizes[effect], EFFECTS[kind])
    return _measured(rig, seed, kind, effect, sizes, reached, rng)


PARAMETERS = {
    "drag-bias": "fraction",
    "reynolds-drag": "exponent",
    "added-mass": "fraction",
    "quadratic-damping": "rate",
    "jet-suction": "decay",
    "thrust-asymmetry": "fraction",
    "axial-flow": "mass_factor",
}
"""Each effect's one parameter, defined alike on both sides."""


def draw_sized(seed: int, effect: str, size: float) -> Case:
    """Draw an experiment with one effect of a size, whether it can be seen or not, as one would lay it out for that size.

    The other effects have their prior uncertainty.
    """
    (kind,) = (kind for kind, effects in EFFECTS.items() if effect in effects)
    rng = np.random.default_rng([seed, list(PARAMETERS).index(effect), 78, round(1e4 * abs(size)), int(size < 0.0)])
    if effect == "jet-suction":
        rig = jets(rng, size)
    elif effect == "axial-flow":
        rig = blades(rng, max(1.0, 1.0 / size))
    else:
        rig = RIGS[kind](rng)
    sizes = {name: PRIOR_SD[name] * rng.standard_normal() for name in EFFECTS[kind] if name in PRIOR_SD}
    sizes[effect] = size
    return _measured(rig, seed, kind, effect, sizes, math.nan, rng)


def _measured(
    rig: Rig,
    seed: int,
    kind: str,
    effect: str | None,
    sizes: dict[str, float],
    reached: float,
    rng: np.random.Generator,
) -> Case:
    """The experiment as it is measured and written down."""
    sizes = {name: max(value, 0.0) if name in POSITIVE else value for name, value in sizes.items()}
    parameters = {} if effect is None else {f"{effect}.{PARAMETERS[effect]}": sizes[effect]}
    reading = rig.read(sizes)
    columns = rig.columns | {rig.quantity: reading + rig.noise * rng.standard_normal(len(reading))}
    mission = {**MISSION, "vehicle": rig.vehicle} if rig.vehicle else dict(MISSION)
    rows = [[f"{value:.8g}" for value in row] for row in zip(*columns.values(), strict=True)]
    dataset = {**rig.dataset, "file": "tank.csv", "name": "Tank"}
    truth = () if effect is None else (effect,)
    return Case(
        seed, kind, "control" if effect is None else "single", truth, (), "", parameters, reached, mission, None, dataset,
        list(columns), rows, {"sizes": sizes},
    )  # fmt: skip


POSITIVE = ("quadratic-damping", "jet-suction")


def cases(count: int, seed: int) -> list[Case]:
    """Draw cases: the kinds in turn, half of them controls."""
    kinds = list(RIGS)
    drawn = []
    for k in range(count):
        kind = kinds[k % len(kinds)]
        turn = k // len(kinds)
        effects = EFFECTS[kind]
        drawn.append(draw(seed + k, kind, None if turn % 2 else effects[turn // 2 % len(effects)]))
    return drawn


def summary(outcomes: list[Outcome]) -> tuple[str, float, float]:
    """Return a text, the share of false alarms and the share of right causes at five standard errors or more."""
    controls = [o for o in outcomes if not o.case.truth]
    strong = [o for o in outcomes if o.case.truth and o.case.strength >= SMALLEST]
    alarms = [o for o in controls if o.diagnosis.get("verdict") != "adequate"]
    right = [o for o in strong if o.case.accepts(o.diagnosis.get("causes", []))]
    missed = [o for o in outcomes if o in alarms or (o in strong and o not in right)]
    lines = [f"false alarms: {len(alarms)} of {len(controls)} (target: 3 %)"]
    lines.append(f"right cause at {SMALLEST:g} standard errors or more: {len(right)} of {len(strong)} (target: 95 %)")
    for o in missed:
        found, verdict = o.diagnosis.get("causes"), o.diagnosis.get("verdict")
        lines.append(f"  {o.case.name} {o.case.truth} at {o.case.strength:.1f}: {verdict} {found} {o.error[:200]}")
    return "\n".join(lines), len(alarms) / max(len(controls), 1), len(right) / max(len(strong), 1)


def main() -> int:
    """Run the study; return 0 if both targets are met."""
    parser = argparse.ArgumentParser(prog="python -m tests.hidden_effects.tank", description=__doc__)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        seen, truths = Path(scratch) / "seen", Path(scratch) / "truths"
        page, alarms, right = summary(
            [diagnose(case, seen, truths, in_process=True) for case in cases(options.cases, options.seed)]
        )
    print(page)
    return int(alarms > 0.03 or right < 0.95)


if __name__ == "__main__":
    sys.exit(main())
