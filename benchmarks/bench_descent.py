"""Time a descent of the vectorised model against scipy.integrate.solve_ivp, one trial at a time, at equal accuracy.

Run: OMP_NUM_THREADS=1 python benchmarks/bench_descent.py

Both integrate the example's pay-out, pull-down and coasting with the drag of Eqs. 2–13 (the same functions), events
included. Accuracy is the error of time and lowest altitude against DOP853 at a tolerance of 1e-12; solve_ivp is
given the loosest tolerance at which it is as accurate as the model at its default step.
"""

import time
from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from missionplan.phases.currents import layers
from missionplan.phases.descent import descend
from missionplan.phases.descent_forces import Dive
from missionplan.physics.vehicle_drag import Hull, Sail, VehicleDrag, anchor_drag
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
TRIALS = 10_000


def vectorised(trials):
    """Descents of many trials with their own weights and currents."""
    rng = np.random.default_rng(1)
    speed = [1.0 + 0.15 * rng.standard_normal(trials), 0.9 + 0.15 * rng.standard_normal(trials)]
    toward = [np.full(trials, np.pi / 2), np.full(trials, 2 * np.pi / 3)]
    return descend(
        replace(DIVE, wet_weight=DIVE.wet_weight * np.exp(0.05 * rng.standard_normal(trials))),
        release_time=np.abs(2.0 + 0.5 * rng.standard_normal(trials)),
        current=layers([50 * FOOT, 100 * FOOT], speed, toward),
        position=np.zeros((2, trials)),
        t_start=np.zeros(trials),
    )


def one_by_one(dive, method, tolerance):
    """One descent by solve_ivp: time to touchdown and lowest altitude."""
    drag, lone = dive.vehicle_drag, dive.anchor_drag
    pull = dive.wet_weight - dive.net_buoyancy

    def stage(force, mass, state, event):
        event.terminal = True
        found = solve_ivp(
            lambda _, y: (y[1], force(y[1]) / mass),
            (0.0, 500.0),
            state,
            method,
            events=event,
            rtol=tolerance,
            atol=tolerance,
        )
        return found.t_events[0][0], found.y_events[0][0]

    payout, (_, fast) = stage(
        lambda v: dive.wet_weight - lone(v), dive.lone_mass, (0.0, 0.0), lambda _, y: y[0] - dive.line_length
    )
    shared = fast * dive.lone_mass / dive.joint_mass
    bottom = dive.site_depth - dive.line_length
    down, state = stage(lambda v: pull - drag(v) - lone(v), dive.joint_mass, (0.0, shared), lambda _, y: y[0] - bottom)
    _, (deepest, _) = stage(lambda v: -dive.net_buoyancy - drag(v), dive.free_mass, state, lambda _, y: y[1] + 1e-14)
    return np.array([payout + down, dive.site_depth - deepest])


def main():
    """Print the ratio."""
    exact = one_by_one(DIVE, "DOP853", 1e-12)
    still = layers([1000.0], [0.0], [0.0])
    nought = np.zeros(1)
    record = descend(DIVE, release_time=nought, current=still, position=np.zeros((2, 1)), t_start=nought)
    error = np.abs([record.descent_time[0], record.lowest_altitude[0]] - exact).max()
    print(f"error of the model at its default step: {error:.1e}")

    candidates = [("RK45", 10.0**-power) for power in np.arange(3.0, 12.0, 0.5)]
    candidates += [("DOP853", 10.0**-power) for power in np.arange(3.0, 12.0, 0.5)]
    alone = np.inf
    for method in ("RK45", "DOP853"):
        for name, tolerance in candidates:
            if name == method and np.abs(one_by_one(DIVE, method, tolerance) - exact).max() <= error:
                began = time.perf_counter()
                for _ in range(20):
                    one_by_one(DIVE, method, tolerance)
                each = (time.perf_counter() - began) / 20
                print(f"solve_ivp {method} at {tolerance:.0e}: {each * 1e3:.1f} ms a descent")
                alone = min(alone, each)
                break
    vectorised(100)
    began = time.perf_counter()
    vectorised(TRIALS)
    total = time.perf_counter() - began
    print(f"vectorised: {TRIALS} descents in {total:.2f} s, {total / TRIALS * 1e6:.0f} µs a descent")
    print(f"ratio: {alone / (total / TRIALS):.0f} (asked: 200)")


if __name__ == "__main__":
    main()
