"""Simulation of a log: legs one after the other, with nuisances and effects."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .catalogue import STEPS_OF_A_LEG, Array, LegEffect
from .survey import Survey


@dataclass(frozen=True)
class Log:
    """Simulated legs, arrays over legs; positions have shape (legs, 2)."""

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
    """Displacement by everything else that dead reckoning does not contain, fix errors included [m]."""


def simulate_log(survey: Survey, effects: Sequence[LegEffect], rng: np.random.Generator) -> Log:
    """Simulate the legs one after the other, each aimed from its fix at the next target."""
    legs = survey.planned.size
    error = survey.sigma * rng.standard_normal((legs, 2))
    for effect in effects:
        if effect.stretch is not None:
            error = error * effect.stretch[:, None]
    fix_sd = np.sqrt(survey.fix**2 + sum(effect.fix_sd**2 for effect in effects))
    plain = survey.fix * rng.standard_normal((legs, 2, 2))
    fixes = plain * fix_sd / survey.fix
    true, t = np.zeros(2), 0.0
    keep: dict[str, list[Any]] = {name: [] for name in Log.__dataclass_fields__}
    for i in range(legs):
        start = true + fixes[i, 0]
        heading, time = _steer(survey, i, survey.targets[i] - start)
        u = survey.speed[i]
        way = u * time * np.array([np.sin(heading), np.cos(heading)])
        base = _made_good(u, heading, time, survey.compass, survey.pace)
        noise = base - way + (survey.current + error[i]) * time
        moved = _displacement_of_leg(effects, survey, t, heading, u, time, survey.surface[i], true + 0.5 * way)
        after = true + way + noise + moved
        t_end = t + time + survey.surface[i]
        leg = {
            "t_start": t,
            "t_end": t_end,
            "heading": heading,
            "under_way": time,
            "fix_start": start,
            "reckoned": start + way,
            "fix_end": after + fixes[i, 1],
            "true_start": true,
            "true_end": after,
            "signal": moved,
            "noise": noise + fixes[i, 1] - fixes[i, 0],
        }
        for name, value in leg.items():
            keep[name].append(value)
        drift = sum((effect.surface(t_end) for effect in effects if effect.surface), np.zeros(2))
        true = after + drift * survey.pause[i]
        t = t_end + survey.pause[i]
    return Log(**{name: np.array(values) for name, values in keep.items()})


def _steer(survey: Survey, leg: int, aim: Array) -> tuple[float, float]:
    """Heading [rad] and time under way [s] of a leg towards its target."""
    time = survey.planned[leg]
    if survey.heading is not None:
        return float(survey.heading[leg]), time
    heading = float(np.arctan2(aim[0], aim[1]))
    return heading, float(np.clip(np.hypot(*aim) / survey.speed[leg], 0.5 * time, 1.6 * time))


def _made_good(speed: float, heading: float, time: float, turn: float, pace: float) -> Array:
    course = heading + turn
    return speed * (1.0 + pace) * time * np.array([np.sin(course), np.cos(course)])


def _displacement_of_leg(effects, survey, t, heading, speed, time, wait, middle) -> Array:
    """Displacement by the effects alone; currents act under way, by five-point Gauss quadrature along the leg."""
    nodes, weights = np.polynomial.legendre.leggauss(5)
    at = t + 0.5 * time * (1.0 + nodes)
    along = 0.5 * time * speed * np.array([np.sin(heading), np.cos(heading)])
    turn = sum(effect.turn(t + 0.5 * time, heading) for effect in effects if effect.turn)
    pace = np.prod([effect.pace(t + 0.5 * time) for effect in effects if effect.pace])
    course = _made_good(speed, heading, time, survey.compass + turn, (1.0 + survey.pace) * pace - 1.0)
    moved = course - _made_good(speed, heading, time, survey.compass, survey.pace)
    for effect in effects:
        if effect.current:
            for node, weight, moment in zip(nodes, weights, at, strict=True):
                moved = moved + 0.5 * weight * time * effect.current(moment, middle + node * along)
        if effect.wander is not None:
            grid, v = effect.wander
            inside = t + time * (np.arange(STEPS_OF_A_LEG) + 0.5) / STEPS_OF_A_LEG
            moved = moved + time * np.array([np.mean(np.interp(inside, grid, axis)) for axis in v])
        if effect.surface:
            moved = moved + wait * effect.surface(t + time + 0.5 * wait)
        if effect.push:
            moved = moved + effect.push(heading, speed, time)
    return moved


def displacement(survey: Survey, log: Log, effects: Sequence[LegEffect]) -> Array:
    """Return the displacements by effects on the legs of a simulated log, shape (legs, 2) [m]."""
    moved = []
    for i in range(log.heading.size):
        middle = log.true_start[i] + 0.5 * (log.reckoned[i] - log.fix_start[i])
        leg = (log.t_start[i], log.heading[i], survey.speed[i], log.under_way[i], survey.surface[i], middle)
        moved.append(_displacement_of_leg(effects, survey, *leg))
    return np.array(moved)
