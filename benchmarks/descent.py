"""Descents of the model, of uncoupled and of tied bodies, and of `solve_ivp`, one at a time, at equal accuracy.

Both integrate the example's pay-out, pull-down and coasting with the drag of Eqs. 2–13 (the same functions), events
included. Accuracy is the error of time and lowest altitude relative to DOP853 at a tolerance of 1e-12; solve_ivp is
given the loosest tolerance at which it is as accurate as the model at its default step.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.common import Options, Row, Section, alternate, duration
from missionplan.phases.currents import layers
from missionplan.phases.mooring.descent import DescentRecord, descend
from missionplan.phases.mooring.forces import Dive
from missionplan.phases.mooring.motion import CrossFlowBody, TiedBodies
from missionplan.physics.drag import Hull, Sail, VehicleDrag, anchor_drag
from missionplan.physics.water import Water

INCH, FOOT = 0.0254, 0.3048
WATER = Water(1026.02, 1.1892e-6)
DIVE = Dive(
    wet_weight=11.6974,
    anchor_mass=2.7935,
    anchor_added_mass=0.536,
    anchor_drag=anchor_drag(4.75 * INCH, 0.2, WATER.density),
    vehicle_mass=10.2,
    vehicle_added_mass=0.240,
    net_buoyancy=0.8896,
    vehicle_drag=VehicleDrag(Hull(44 * INCH, 4.75 * INCH), Sail(4 * INCH, 4 * INCH, 0.6 * INCH), 1.25, WATER),
    line_length=5.0,
    site_depth=100 * FOOT,
)
TIED = replace(DIVE, tied=TiedBodies(CrossFlowBody(7.51, 3.99), CrossFlowBody(76.1, 20.0, 22 * INCH)))
"""The same with the drift of both bodies tied by the line."""
TRIALS, PEER_TRIALS = 10_000, 20

Method = Literal["RK45", "DOP853"]
METHODS: tuple[Method, ...] = ("RK45", "DOP853")
Force = Callable[[Any], Any]
"""Vertical force, down positive [N], of the speed [m/s]."""
Event = Callable[[float, np.ndarray], float]
"""Event function of time and state: zero where a stage ends."""


def vectorised(trials: int, dive: Dive = DIVE) -> DescentRecord:
    """Descents of many trials with individual weights and currents."""
    rng = np.random.default_rng(1)
    speed = [1.0 + 0.15 * rng.standard_normal(trials), 0.9 + 0.15 * rng.standard_normal(trials)]
    toward = [np.full(trials, np.pi / 2), np.full(trials, 2 * np.pi / 3)]
    return descend(
        replace(dive, wet_weight=dive.wet_weight * np.exp(0.05 * rng.standard_normal(trials))),
        release_time=np.abs(2.0 + 0.5 * rng.standard_normal(trials)),
        current=layers([50 * FOOT, 100 * FOOT], speed, toward),
        position=np.zeros((2, trials)),
        t_start=np.zeros(trials),
    )


def one_by_one(dive: Dive, method: Method, tolerance: float) -> np.ndarray:
    """One descent by solve_ivp: time to touchdown and lowest altitude."""
    drag, lone = dive.vehicle_drag, dive.anchor_drag
    pull = dive.wet_weight - dive.net_buoyancy

    def stage(force: Force, mass: Any, state: Sequence[float] | np.ndarray, event: Event) -> tuple[float, np.ndarray]:
        event.terminal = True  # type: ignore[attr-defined]
        found = solve_ivp(
            lambda _, y: (y[1], force(y[1]) / mass),
            (0.0, 500.0),
            state,
            method,
            events=event,
            rtol=tolerance,
            atol=tolerance,
        )
        assert found.t_events is not None
        assert found.y_events is not None
        return found.t_events[0][0], found.y_events[0][0]

    payout, (_, fast) = stage(
        lambda v: dive.wet_weight - lone(v), dive.lone_mass, (0.0, 0.0), lambda _, y: y[0] - dive.line_length
    )
    shared = fast * dive.lone_mass / dive.joint_mass
    bottom = dive.site_depth - dive.line_length
    down, state = stage(lambda v: pull - drag(v) - lone(v), dive.joint_mass, (0.0, shared), lambda _, y: y[0] - bottom)
    _, (deepest, _) = stage(lambda v: -dive.net_buoyancy - drag(v), dive.free_mass, state, lambda _, y: y[1] + 1e-14)
    return np.array([payout + down, dive.site_depth - deepest])


def as_accurate(method: Method, exact: np.ndarray, error: float) -> float | None:
    """Loosest tolerance at which solve_ivp is as accurate as the model; None if none of those tried is."""
    for tolerance in 10.0 ** -np.arange(3.0, 12.0, 0.5):
        if np.abs(one_by_one(DIVE, method, tolerance) - exact).max() <= error:
            return float(tolerance)
    return None


def several(method: Method, tolerance: float) -> None:
    """Run `PEER_TRIALS` descents by solve_ivp."""
    for _ in range(PEER_TRIALS):
        one_by_one(DIVE, method, tolerance)


def compare(options: Options) -> Section:
    """Time the descents of both."""
    exact = one_by_one(DIVE, "DOP853", 1e-12)
    nought = np.zeros(1)
    still = layers([1000.0], [0.0], [0.0])
    record = descend(DIVE, release_time=nought, current=still, position=np.zeros((2, 1)), t_start=nought)
    error = np.abs([record.descent_time[0], record.lowest_altitude[0]] - exact).max()

    trials = TRIALS // options.shrink
    sides: dict[str, Callable[[], object]] = {
        "model": lambda: vectorised(trials),
        "tied": lambda: vectorised(trials, TIED),
    }
    tolerances = {method: as_accurate(method, exact, float(error)) for method in METHODS}
    for method, tolerance in tolerances.items():
        if tolerance is not None:
            sides[method] = partial(several, method, tolerance)
    vectorised(100)
    times = alternate(sides, options.repeats)
    total, tied = times.pop("model"), times.pop("tied")
    rows = [
        Row(f"{trials} descents on one core", duration(total), "", "", "≤ 1 s", total <= 1.0),
        Row(
            f"{trials} descents, drift tied by the line (beside: uncoupled)",
            duration(tied),
            duration(total),
            f"{tied / total:.1f} × as long",
            "≤ 2",
            tied <= 2.0 * total,
        ),
    ]
    for peer in METHODS:
        if peer not in times:
            continue
        each = times[peer] / PEER_TRIALS
        ratio = each / (total / trials)
        what = f"per descent: `solve_ivp` ({peer}, tolerance {tolerances[peer]:.0e})"
        pair = duration(total / trials), duration(each)
        rows.append(Row(what, *pair, f"{ratio:.0f} × faster", "≥ 200", ratio >= 200.0))
    note = f"Both have errors of at most {error:.0e} (s, m) in descent time and lowest altitude."
    return Section(tuple(rows), ("numpy", "scipy"), (note,))
