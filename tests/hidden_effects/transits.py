"""Navigation logs: courses, legs with their nuisances, columns, and the strength of what is hidden in them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from .case import Case
from .leg_effects import CATALOGUE, Array, Bend, Field
from .leg_outside import OUTSIDE

CURRENT_SD, COMPASS_SD, SPEED_SD = 0.004, np.radians(0.15), 0.002
"""What one is unsure of before any misfit: mean current [m/s], compass [rad], speed."""
STRONG = 12.0
"""A systematic effect moves the log by this many standard errors at least."""
LOUD = 40.0
"""And by no more than about this, beyond which the shape of an effect is measured rather than its kind."""
STRONG_RANDOM = 5.0
"""The same for a random effect: the root of twice its log-likelihood ratio."""
UNLIKE = 5.0
"""An effect outside the catalogue leaves this misfit to the nearest systematic one of the catalogue."""
FARTHEST = 120e3
"""Length of a one-way course [m]."""
RANDOM = {"persistent-error", "random-walk", "fix-error", "heavy-tails"}
ALONG_ONE_HEADING = {"compass-bias", "compass-deviation", "speed-scale", "mean-current"}


@dataclass(frozen=True)
class Survey:
    """Everything about the legs but effects and noise."""

    pattern: str
    targets: Array
    """Where each leg aims, shape (legs, 2) [m]."""
    heading: float | None
    """Steered whatever happens [rad], or None."""
    planned: Array
    speed: Array
    surface: Array
    pause: Array
    sigma: float
    fix: float
    latitude: float
    longitude: float
    current: Array
    compass: float
    pace: float

    @property
    def field(self) -> Field:
        """What the builders may know."""
        span = float(self.planned.sum() + self.surface.sum() + self.pause.sum())
        extent = float(np.sqrt(np.mean(np.sum(self.targets**2, axis=1))))
        leg_time = float(np.median(self.planned))
        return Field(self.latitude, span, extent, self.planned.size, leg_time, float(self.speed.mean()), self.sigma)


@dataclass(frozen=True)
class Log:
    """Legs as they were, arrays over legs; positions have shape (legs, 2)."""

    t_start: Array
    t_end: Array
    heading: Array
    under_way: Array
    fix_start: Array
    reckoned: Array
    fix_end: Array
    true_start: Array
    true_end: Array
    signal: Array
    """Displacement by the effects alone [m]."""
    noise: Array
    """Displacement by everything else that dead reckoning does not know, fixes included [m]."""


def draw_survey(rng: np.random.Generator, scenario: str, wanted: Sequence[str]) -> Survey:
    """Draw a survey of 60 to 300 legs; more than three days long where a period is to be seen."""
    names = set(wanted)
    patterns = ["lawnmower", "survey", "out-and-back", "triangle", "one-heading"]
    periodic = bool(names & {"tidal-current", "inertial-current"})
    if periodic or names & (ALONG_ONE_HEADING | {"current-shear"}) or scenario in ("pair", "outside"):
        patterns = ["lawnmower", "survey", "triangle"]
    pattern = "one-heading" if scenario == "tie" else str(rng.choice(patterns))
    legs = int(rng.integers(140 if names & RANDOM else 60, 301))
    if scenario in ("pair", "outside"):
        legs = max(legs, 100)
    leg_time = float(np.exp(rng.uniform(np.log(1200.0), np.log(7200.0))))
    if "fix-error" in names:
        leg_time = rng.uniform(400.0, 1200.0)
    if periodic:
        leg_time = max(leg_time, 5.0 * 86400.0 / legs)
    speed = rng.uniform(0.3, 1.5)
    if pattern in ("one-heading", "out-and-back"):
        # slower, an error of the compass would be no more than the current one is unsure of
        slowest = 0.7 if scenario == "tie" else 0.25
        speed = max(slowest, min(speed, FARTHEST / (legs * leg_time)))
        leg_time = min(leg_time, FARTHEST / (legs * speed))
    spread = rng.uniform(0.5, 0.8) if "fix-error" in names else rng.choice([0.05, 0.2, 0.5])
    planned = leg_time * np.exp(spread * rng.uniform(-1.0, 1.0, legs))
    speeds = np.full(legs, speed)
    if rng.random() < 0.3 and scenario != "tie":
        speeds = speed * (1.0 + 0.15 * rng.uniform(-1.0, 1.0, legs))
    waits = rng.uniform(60.0, 300.0)
    unequal = 0.9 if "surface-drift" in names else 0.5
    surface = waits * np.exp(unequal * rng.standard_normal(legs))
    if "surface-drift" in names:
        surface *= max(1.0, 0.1 * leg_time / waits)
    high, low = ((40.0, 50.0), (13.0, 18.0)) if periodic else ((30.0, 60.0), (5.0, 30.0))
    latitude = rng.uniform(*(high if rng.random() < 0.7 else low))
    heading = rng.uniform(0.0, 2.0 * np.pi)
    step = float(np.mean(planned * speeds))
    return Survey(
        pattern=pattern,
        targets=_targets(rng, pattern, planned * speeds, step, heading),
        heading=heading if pattern == "one-heading" and scenario == "tie" else None,
        planned=planned,
        speed=np.round(speeds, 3),
        surface=np.round(np.minimum(surface, 0.4 * planned)),
        pause=rng.uniform(10.0, 60.0, legs),
        sigma=rng.uniform(0.015, 0.04),
        fix=rng.uniform(2.0, 12.0),
        latitude=latitude * (1.0 if rng.random() < 0.6 else -1.0),
        longitude=rng.uniform(-170.0, 170.0),
        current=CURRENT_SD * np.clip(rng.standard_normal(2), -1.0, 1.0),
        compass=COMPASS_SD * float(np.clip(rng.standard_normal(), -2.0, 2.0)),
        pace=SPEED_SD * float(np.clip(rng.standard_normal(), -2.0, 2.0)),
    )


def _targets(rng: np.random.Generator, pattern: str, lengths: Array, step: float, heading: float) -> Array:
    """Ends of the planned legs, from the origin."""
    legs = lengths.size
    k = np.arange(legs)
    if pattern == "one-heading":
        angle = np.full(legs, heading)
    elif pattern == "out-and-back":
        angle = heading + np.pi * (k >= legs // 2)
    elif pattern == "lawnmower":
        row = int(rng.integers(3, 8))
        place = k % (2 * row + 2)
        angle = heading + np.select([place < row, place == row, place < 2 * row + 1], [0.0, 0.5, 1.0], 0.5) * np.pi
        # a second pass back over the area, so that it stays an area
        angle = np.where(k < legs // 2, angle, angle + np.where(np.isin(place, [row, 2 * row + 1]), np.pi, 0.0))
    elif pattern == "triangle":
        angle = heading + 2.0 * np.pi / 3.0 * ((k // int(rng.integers(2, 8))) % 3)
    else:
        return _roam(rng, lengths, step)
    return np.cumsum(lengths[:, None] * np.column_stack([np.sin(angle), np.cos(angle)]), axis=0)


def _roam(rng: np.random.Generator, lengths: Array, step: float) -> Array:
    """Random courses that turn home when far away."""
    reach = step * np.sqrt(lengths.size) * 0.6
    here, ends = np.zeros(2), []
    for length in lengths:
        angle = rng.uniform(0.0, 2.0 * np.pi)
        if np.hypot(*here) > reach:
            angle = np.arctan2(-here[0], -here[1]) + rng.uniform(-0.8, 0.8)
        here = here + length * np.array([np.sin(angle), np.cos(angle)])
        ends.append(here)
    return np.array(ends)


def sail(survey: Survey, bends: Sequence[Bend], rng: np.random.Generator) -> Log:
    """Sail the legs one after the other, aiming from each fix at the next target."""
    legs = survey.planned.size
    error = survey.sigma * rng.standard_normal((legs, 2))
    for bend in bends:
        if bend.stretch is not None:
            error = error * bend.stretch[:, None]
    fix_sd = np.sqrt(survey.fix**2 + sum(bend.fix_sd**2 for bend in bends))
    plain = survey.fix * rng.standard_normal((legs, 2, 2))
    fixes = plain * fix_sd / survey.fix
    true, t = np.zeros(2), 0.0
    keep: dict[str, list[Any]] = {name: [] for name in Log.__dataclass_fields__}
    for i in range(legs):
        start = true + fixes[i, 0]
        aim = survey.targets[i] - start
        u = survey.speed[i]
        heading = float(np.arctan2(aim[0], aim[1])) if survey.heading is None else survey.heading
        time = survey.planned[i]
        if survey.heading is None:
            time = float(np.clip(np.hypot(*aim) / u, 0.5 * time, 1.6 * time))
        way = u * time * np.array([np.sin(heading), np.cos(heading)])
        base = _made_good(u, heading, time, survey.compass, survey.pace)
        noise = base - way + (survey.current + error[i]) * time
        effect = _moved_by(bends, survey, t, heading, u, time, survey.surface[i], true + 0.5 * way)
        after = true + way + noise + effect
        keep["t_start"].append(t)
        t_end = t + time + survey.surface[i]
        keep["t_end"].append(t_end)
        keep["heading"].append(heading)
        keep["under_way"].append(time)
        keep["fix_start"].append(start)
        keep["reckoned"].append(start + way)
        keep["fix_end"].append(after + fixes[i, 1])
        keep["true_start"].append(true)
        keep["true_end"].append(after)
        keep["signal"].append(effect)
        keep["noise"].append(noise + fixes[i, 1] - fixes[i, 0])
        drift = sum((bend.surface(t_end) for bend in bends if bend.surface), np.zeros(2))
        true = after + drift * survey.pause[i]
        t = t_end + survey.pause[i]
    return Log(**{name: np.array(values) for name, values in keep.items()})


def _made_good(speed: float, heading: float, time: float, turn: float, pace: float) -> Array:
    course = heading + turn
    return speed * (1.0 + pace) * time * np.array([np.sin(course), np.cos(course)])


def _moved_by(bends, survey, t, heading, speed, time, wait, middle) -> Array:
    """Displacement by the effects alone on one leg; currents act under way, by five-point Gauss along the leg."""
    nodes, weights = np.polynomial.legendre.leggauss(5)
    at = t + 0.5 * time * (1.0 + nodes)
    along = 0.5 * time * speed * np.array([np.sin(heading), np.cos(heading)])
    turn = sum(bend.turn(t + 0.5 * time, heading) for bend in bends if bend.turn)
    pace = np.prod([bend.pace(t + 0.5 * time) for bend in bends if bend.pace])
    course = _made_good(speed, heading, time, survey.compass + turn, (1.0 + survey.pace) * pace - 1.0)
    moved = course - _made_good(speed, heading, time, survey.compass, survey.pace)
    for bend in bends:
        if bend.current:
            for node, weight, moment in zip(nodes, weights, at, strict=True):
                moved = moved + 0.5 * weight * time * bend.current(moment, middle + node * along)
        if bend.wander is not None:
            grid, v = bend.wander
            inside = np.linspace(t, t + time, 9)
            moved = moved + time * np.array([np.mean(np.interp(inside, grid, axis)) for axis in v])
        if bend.surface:
            moved = moved + wait * bend.surface(t + time + 0.5 * wait)
        if bend.push:
            moved = moved + bend.push(heading, speed, time)
    return moved


def covariance(survey: Survey, log: Log) -> Array:
    """Covariance of the legs' position errors under the nuisances, east then north, shape (2 legs, 2 legs)."""
    variance = survey.sigma**2 * log.under_way**2 + 2.0 * survey.fix**2
    time, way = log.under_way, log.reckoned - log.fix_start
    zero = np.zeros_like(time)
    columns = [
        CURRENT_SD * np.concatenate([time, zero]),
        CURRENT_SD * np.concatenate([zero, time]),
        COMPASS_SD * np.concatenate([way[:, 1], -way[:, 0]]),
        SPEED_SD * np.concatenate([way[:, 0], way[:, 1]]),
    ]
    spikes = np.array(columns)
    return np.diag(np.concatenate([variance, variance])) + spikes.T @ spikes


def whiten(survey: Survey, log: Log, displacement: Array) -> Array:
    """Displacements of the legs in standard errors, decorrelated."""
    factor = np.linalg.cholesky(covariance(survey, log))
    return np.linalg.solve(factor, displacement.T.ravel())


def random_strength(survey: Survey, log: Log, bend: Bend) -> float:
    """Root of twice the log-likelihood ratio of a random effect over the best independent errors."""
    assert bend.statistic is not None
    kind, first, second = bend.statistic
    error = (log.signal + log.noise) / log.under_way[:, None]
    middle = 0.5 * (log.t_start + log.t_end)
    fix = 2.0 * survey.fix**2 / log.under_way**2

    def gauss(sigma: float, extra: Array) -> float:
        matrix = np.diag(sigma**2 + fix) + extra
        logdet = np.linalg.slogdet(matrix).logabsdet
        return -0.5 * float(2.0 * logdet + np.sum(error * np.linalg.solve(matrix, error)))

    nothing = np.zeros((middle.size, middle.size))
    low = survey.sigma * np.exp(minimize(lambda x: -gauss(survey.sigma * np.exp(x[0]), nothing), [0.2]).x[0])
    base = gauss(low, nothing)
    if kind == "persistent-error":
        extra = first**2 * np.exp(-np.abs(middle[:, None] - middle) / second)
    elif kind == "random-walk":
        extra = first**2 * np.minimum.outer(middle, middle)
    elif kind == "fix-error":
        extra = np.diag(2.0 * first**2 / log.under_way**2)
    else:
        norm = np.sqrt(survey.sigma**2 + fix)
        radius = np.hypot(*(error.T / norm))
        if kind == "student":
            density = -(first + 2.0) / 2.0 * np.log1p(radius**2 / first)
        else:
            wide = second**2
            density = np.log(
                (1.0 - first) * np.exp(-(radius**2) / 2.0) + first / wide * np.exp(-(radius**2) / 2 / wide)
            )
        return float(np.sqrt(max(0.0, 2.0 * (np.sum(density - 2.0 * np.log(norm)) - base))))
    return float(np.sqrt(max(0.0, 2.0 * (gauss(survey.sigma, extra) - base))))


@dataclass(frozen=True)
class Hidden:
    """Effects as drawn, the log they gave, and how far they move it."""

    bends: tuple[Bend, ...]
    parameters: dict[str, float]
    sizes: dict[str, float]
    strength: float
    log: Log


def hide(survey: Survey, names: Sequence[str], rng: np.random.Generator, noise_seed: Sequence[int], scale: float):
    """Draw sizes, enlarging what is not clear; None if the largest is not. Noise is the same for every size."""
    severity = {name: rng.uniform(0.0, 0.9 if len(names) == 1 else 0.6) for name in names}
    shape = {name: int(rng.integers(2**32)) for name in names}

    def build(factor: float):
        built = {}
        for name in names:
            cause = (CATALOGUE | OUTSIDE)[name]
            size = factor * cause.low * (cause.high / cause.low) ** severity[name]
            built[name] = (*cause.build(size, np.random.default_rng(shape[name]), survey.field), float(size))
        return built

    enlarged = False
    while True:
        built = build(1.0)
        alone = {name: sail(survey, (built[name][0],), np.random.default_rng(noise_seed)) for name in names}
        log = sail(survey, tuple(item[0] for item in built.values()), np.random.default_rng(noise_seed))
        weak = [name for name in names if not _stands_out(survey, names, built, alone, log, name)]
        if not weak:
            loud = len(names) == 1 and not enlarged and _strength(survey, log, names, built) > LOUD
            if loud and severity[names[0]] > -1.0:
                severity[names[0]] -= 0.25
                continue
            break
        if any(severity[name] >= 1.0 for name in weak):
            return None
        severity |= {name: min(1.0, severity[name] + 0.34) for name in weak}
        enlarged = True  # and not made smaller again: what is unlike the catalogue may have to be loud
    if scale != 1.0:
        built = build(scale)
        log = sail(survey, tuple(item[0] for item in built.values()), np.random.default_rng(noise_seed))
    reached = _strength(survey, log, names, built)
    parameters = {f"{name}.{key}": float(value) for name, item in built.items() for key, value in item[1].items()}
    sizes = {name: item[2] for name, item in built.items()}
    return Hidden(tuple(item[0] for item in built.values()), parameters, sizes, reached, log)


def _strength(survey, log, names, built) -> float:
    if len(names) == 1 and names[0] in RANDOM:
        return random_strength(survey, log, built[names[0]][0])
    return float(np.linalg.norm(whiten(survey, log, log.signal)))


def _stands_out(survey, names, built, alone, log, name) -> bool:
    if name in RANDOM:
        return random_strength(survey, alone[name], built[name][0]) >= STRONG_RANDOM
    own = whiten(survey, alone[name], alone[name].signal)
    if len(names) == 1:
        apart = name in CATALOGUE or unlike_catalogue(survey, alone[name], own) >= UNLIKE
        return float(np.linalg.norm(own)) >= STRONG and apart
    other = next(each for each in names if each != name)
    if other in RANDOM:
        # a wandering error hides a current: the larger of the two noises counts
        sigma = np.hypot(survey.sigma, np.std(alone[other].signal / alone[other].under_way[:, None]))
        return float(np.linalg.norm(own)) * survey.sigma / sigma >= 0.8 * STRONG
    near = whiten(survey, alone[other], alone[other].signal)
    share = float(near @ own) / max(float(near @ near), 1e-12)
    return float(np.linalg.norm(own - share * near)) >= 0.6 * STRONG


def unlike_catalogue(survey: Survey, log: Log, far: Array) -> float:
    """Misfit that the nearest systematic cause of the catalogue leaves of an effect [standard errors]."""
    left = []
    for name in CATALOGUE.keys() - RANDOM:
        cause = CATALOGUE[name]
        bend, _ = cause.build(cause.low, np.random.default_rng(0), survey.field)
        near = whiten(survey, log, displacement(survey, log, (bend,)))
        share = float(near @ far) / max(float(near @ near), 1e-12)
        left.append(float(np.linalg.norm(far - share * near)))
    return min(left)


def displacement(survey: Survey, log: Log, bends: Sequence[Bend]) -> Array:
    """What effects would have done on legs already sailed, shape (legs, 2) [m]."""
    moved = []
    for i in range(log.heading.size):
        middle = log.true_start[i] + 0.5 * (log.reckoned[i] - log.fix_start[i])
        leg = (log.t_start[i], log.heading[i], survey.speed[i], log.under_way[i], survey.surface[i], middle)
        moved.append(_moved_by(bends, survey, *leg))
    return np.array(moved)


def _pick(rng: np.random.Generator, scenario: str) -> tuple[str, ...]:
    if scenario == "control":
        return ()
    if scenario == "outside":
        return (str(rng.choice(list(OUTSIDE))),)
    if scenario == "tie":
        return (str(rng.choice(["compass-bias", "speed-scale"])),)
    while True:
        names = tuple(sorted(str(name) for name in rng.choice(list(CATALOGUE), 1 + (scenario == "pair"), False)))
        if len(RANDOM & set(names)) < 2:
            return names


def draw(seed: int, scenario: str, effect: str | None = None) -> Case:
    """Draw a transit case; deterministic for its arguments."""
    base = [seed, 2, sum(map(ord, scenario))]
    names = _pick(np.random.default_rng(base), scenario)
    if effect is not None:
        names = (effect,)
    scale = 0.25 if scenario == "weak" else 1.0
    for attempt in range(30):
        shape, hiding = np.random.default_rng([*base, attempt]).spawn(2)
        survey = draw_survey(shape, scenario, names)
        if scenario == "control":
            survey = _louder(survey, shape)
        hidden = hide(survey, names, hiding, [*base, attempt, 7], scale)
        if hidden is not None:
            break
    else:
        raise RuntimeError(f"no survey shows {names} (seed {seed})")
    inside = scenario != "outside"
    ties: tuple[tuple[str, ...], ...] = ()
    if scenario == "tie":
        rivals = {"compass-bias": ("compass-deviation", "mean-current"), "speed-scale": ("mean-current",)}
        ties = tuple((rival,) for rival in rivals[names[0]])
    header, rows, dataset = columns(survey, hidden.log, shape, "surface-drift" in names)
    return Case(
        seed=seed,
        kind="transit",
        scenario=scenario,
        truth=names if inside else (),
        ties=ties,
        outside="" if inside else names[0],
        parameters=hidden.parameters if inside else {},
        strength=hidden.strength,
        mission=mission_file(survey, shape),
        vehicle=None,
        dataset=dataset,
        header=header,
        rows=rows,
        notes={
            "sizes": hidden.sizes,
            "sigma": survey.sigma,
            "fix": survey.fix,
            "pattern": survey.pattern,
            "legs": int(survey.planned.size),
            "latitude": survey.latitude,
            "attempt": attempt,
        },
    )


def _louder(survey: Survey, rng: np.random.Generator) -> Survey:
    """Controls see nuisances of half to twice the usual size."""
    scale = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0))))
    louder = {name: scale * getattr(survey, name) for name in ("current", "compass", "pace", "sigma", "fix")}
    return replace(survey, **louder)


def columns(survey: Survey, log: Log, rng: np.random.Generator, need_surface: bool):
    """Write the log in metres or degrees: header, rows, ``dataset.yaml``."""
    metres = rng.random() < 0.5
    legs = np.flatnonzero(rng.random(log.heading.size) >= rng.choice([0.0, 0.0, 0.03]))
    extras: dict[str, Array] = {}
    if need_surface or rng.random() < 0.7:
        extras["surface_s"] = survey.surface
    if rng.random() < 0.6:
        extras["speed_m_s"] = survey.speed
    if rng.random() < 0.6:
        extras["heading_deg"] = np.round(np.degrees(log.heading) % 360.0, 1)
    if rng.random() < 0.15:
        extras["battery_v"] = np.round(16.0 - 2.0 * log.t_start / log.t_start[-1], 2)
    spoiled = rng.random(log.heading.size) < (0.03 if rng.random() < 0.3 else 0.0)
    if spoiled.any():
        extras["ok"] = 1.0 - spoiled
    origin = 1.4e9 if rng.random() < 0.3 else 0.0
    if metres:
        header = ["leg", "t_start_s", "t_end_s", "x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m"]
        places = np.hstack([log.fix_start, log.reckoned, log.fix_end])
        text = [[f"{value:.2f}" for value in row] for row in places]
    else:
        header = ["leg", "t_start_s", "t_end_s", "lat_start", "lon_start"]
        header += ["lat_dr_end", "lon_dr_end", "lat_end", "lon_end"]
        text = [[f"{value:.7f}" for value in row] for row in _degrees(survey, log)]
    rows = []
    for i in legs:
        times = [str(i + 1), f"{origin + log.t_start[i]:.1f}", f"{origin + log.t_end[i]:.1f}"]
        cells = text[i] if not (spoiled[i] and rng.random() < 0.5) else ["", "", *text[i][2:]]
        rows.append(times + cells + [f"{values[i]:g}" for values in extras.values()])
    dataset: dict[str, Any] = {"kind": "transit", "name": "Navigation log", "file": "legs.csv", "source": "made up"}
    if rng.random() < 0.5:
        dataset["noise"] = {"fix": f"{survey.fix:.1f} m"}
    return header + list(extras), rows, dataset


def _degrees(survey: Survey, log: Log) -> Array:
    """Latitude and longitude of the three points of each leg, shape (legs, 6).

    The track is laid on the WGS 84 ellipsoid in steps, each with the radii of curvature at its middle, so that every
    displacement keeps its length far from the origin.
    """
    latitude, longitude = survey.latitude, survey.longitude
    here = np.zeros(2)
    out = []
    for start, reckoned, end, true in zip(log.fix_start, log.reckoned, log.fix_end, log.true_end, strict=True):
        points = [step_on_ellipsoid(latitude, longitude, point - here) for point in (start, reckoned, end)]
        out.append([value for point in points for value in point])
        latitude, longitude = step_on_ellipsoid(latitude, longitude, true - here)
        here = true
    return np.array(out)


def step_on_ellipsoid(latitude: float, longitude: float, step: Array) -> tuple[float, float]:
    """Latitude and longitude [deg] after a step of at most some kilometres east and north [m]."""
    a, e2 = 6378137.0, 6.69437999014e-3

    def radii(phi: float) -> tuple[float, float]:
        w = 1.0 - e2 * np.sin(phi) ** 2
        return a * (1.0 - e2) / w**1.5, a / w**0.5

    phi = np.radians(latitude)
    middle = phi + 0.5 * step[1] / radii(phi)[0]
    meridian, _ = radii(middle)
    _, normal = radii(middle)
    new = phi + step[1] / meridian
    turn = step[0] / (normal * np.cos(middle))
    return float(np.degrees(new)), float((longitude + np.degrees(turn) + 180.0) % 360.0 - 180.0)


def mission_file(survey: Survey, rng: np.random.Generator) -> dict[str, Any]:
    """Base mission in the contract's form; its velocity error is a guess within a fifth of the truth."""
    speed = float(np.mean(survey.speed))
    leg = speed * float(np.median(survey.planned))
    return {
        "name": "Survey",
        "site": {"origin": {"latitude": f"{survey.latitude:.5f} deg", "longitude": f"{survey.longitude:.5f} deg"}},
        "navigation": {
            "velocity_error": {"sigma": f"{survey.sigma * rng.uniform(0.83, 1.2):.4f} m/s"},
            "surfacing_time": f"{float(np.mean(survey.surface)):.0f} s",
            "fix_error": f"{survey.fix:.1f} m",
        },
        "phases": [
            {
                "transit": {
                    "name": "survey",
                    "from": ["0 m", "0 m"],
                    "to": [f"{8.0 * leg:.0f} m", "0 m"],
                    "speed": f"{speed:.3f} m/s",
                    "d_max": f"{leg:.0f} m",
                    "arrival_radius": f"{0.1 * leg:.0f} m",
                }
            }
        ],
        "monte_carlo": {"trials": 2000, "seed": 1},
    }
