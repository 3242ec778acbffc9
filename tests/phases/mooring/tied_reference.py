"""Reference for the drift of anchor and vehicle on a taut line: planar, by scipy, sharing no code with the package.

Generalised coordinates are the place of the vehicle's nose and the line's angle from the vertical, so that the line
is no constraint but built in, and the equations are Lagrange's with their mass matrix solved at each step. The package
has Cartesian coordinates, the line's tension as a multiplier, and splits the forces.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

TOLERANCE = {"rtol": 1e-8, "atol": 1e-9, "max_step": 0.1}


@dataclass(frozen=True)
class Body:
    """Masses with added mass along the axis and across [kg], drag k v|v| along and across [N s²/m²]; middle above the end [m]."""

    along: float
    across: float
    drag_along: float
    drag_across: float
    middle: float = 0.0


@dataclass(frozen=True)
class Case:
    """Two bodies, line, depth, and layers: lower ends [m] and speeds [m/s]; released some time after the fix [s]."""

    anchor: Body
    vehicle: Body
    weight: float
    buoyancy: float
    line: float
    depth: float
    down_to: tuple[float, ...]
    speed: tuple[float, ...]
    release: float

    def current(self, depth: float) -> float:
        return next(
            (speed for end, speed in zip(self.down_to, self.speed, strict=True) if depth <= end), self.speed[-1]
        )


@dataclass(frozen=True)
class Landing:
    """Where and when the anchor lands: offset from the last fix [m], time since the separation [s], line's angle [rad]."""

    offset: float
    time: float
    angle: float


def against(factor: float, velocity: float) -> float:
    return -factor * velocity * abs(velocity)


def event_at_zero(function):
    function.terminal = True
    return function


def tied(case: Case) -> Landing:
    """Land with both bodies tied."""
    a, v, line = case.anchor, case.vehicle, case.line
    top = case.current(0.0)
    begun = top * case.release

    def lone(_, y):
        _, z, vx, vz = y
        return [
            vx,
            vz,
            against(a.drag_across, vx - case.current(max(z - a.middle, 0.0))) / a.across,
            (case.weight + against(a.drag_along, vz)) / a.along,
        ]

    taut = event_at_zero(lambda t, y: np.hypot(y[0] - begun - top * t, y[1]) - line)
    fall = solve_ivp(lone, (0.0, 100.0), [begun, 0.0, top, 0.0], events=taut, **TOLERANCE)
    paid_out, (x, z, vx, vz) = fall.t_events[0][0], fall.y_events[0][0]
    afloat = begun + top * paid_out
    angle = np.arctan2(x - afloat, z)
    state = [afloat, 0.0, angle, *snatch(case, angle, np.array([vx, vz]), np.array([top, 0.0]))]

    def pulled(_, y):
        _, z, th, vx, vz, turn = y
        sine, cosine = np.sin(th), np.cos(th)
        anchor_x, anchor_z = vx + line * cosine * turn, vz - line * sine * turn
        on_vehicle = [
            against(v.drag_across, vx - case.current(max(z - v.middle, 0.0))),
            -case.buoyancy + against(v.drag_along, vz),
        ]
        on_anchor = [
            against(a.drag_across, anchor_x - case.current(max(z + line * cosine - a.middle, 0.0))),
            case.weight + against(a.drag_along, anchor_z),
        ]
        # Jacobian of the anchor's place, and what its acceleration has beyond it
        jacobian = np.array([[1.0, 0.0, line * cosine], [0.0, 1.0, -line * sine]])
        bent = -line * turn**2 * np.array([sine, cosine])
        mass = np.diag([v.across, v.along, 0.0]) + jacobian.T @ np.diag([a.across, a.along]) @ jacobian
        force = np.array([*on_vehicle, 0.0]) + jacobian.T @ (on_anchor - np.array([a.across, a.along]) * bent)
        return [vx, vz, turn, *np.linalg.solve(mass, force)]

    landed = event_at_zero(lambda _, y: y[1] + line * np.cos(y[2]) - case.depth)
    down = solve_ivp(pulled, (0.0, 500.0), state, events=landed, **TOLERANCE)
    x, _, th = down.y_events[0][0][:3]
    return Landing(x + line * np.sin(th), paid_out + down.t_events[0][0], th)


def snatch(case: Case, angle: float, anchor: np.ndarray, vehicle: np.ndarray) -> tuple[float, float, float]:
    """Vehicle's velocity and the line's turning rate after an impulse along the line has ended the motion apart."""
    along = np.array([np.sin(angle), np.cos(angle)])
    masses = [np.array([body.across, body.along]) for body in (case.anchor, case.vehicle)]
    impulse = along @ (anchor - vehicle) / sum(along @ (along / mass) for mass in masses)
    anchor, vehicle = anchor - impulse * along / masses[0], vehicle + impulse * along / masses[1]
    turn = (anchor - vehicle) @ np.array([np.cos(angle), -np.sin(angle)]) / case.line
    return vehicle[0], vehicle[1], turn


def varied_case(number: int) -> Case:
    """One of the cases of the comparison: from a small vehicle in shallow water to 60 m, up to 1.4 m/s of shear."""
    rng = np.random.default_rng([2026, number])
    density, diameter = 1020.0, rng.uniform(0.10, 0.20)
    fineness = rng.uniform(7.0, 12.0)
    length = fineness * diameter
    displaced = 0.9 * density * np.pi / 4.0 * diameter**2 * length
    tip = rng.uniform(1.2, 2.5) * diameter
    flooded = 1.4 * density * np.pi / 4.0 * diameter**2 * tip
    area = np.pi / 4.0 * diameter**2
    line = rng.uniform(2.0, 12.0)
    depth = line + rng.uniform(6.0, 48.0)
    layers = int(rng.integers(2, 5))
    return Case(
        anchor=Body(
            flooded + 0.3 * density * diameter**3,
            flooded + 0.6 * density * area * tip,
            0.5 * density * 0.2 * area,
            0.5 * density * 0.7 * diameter * tip,
        ),
        vehicle=Body(
            1.02 * displaced,
            1.95 * displaced,
            0.5 * density * rng.uniform(0.4, 0.8) * area,
            0.5 * density * 1.1 * diameter * length,
            0.5 * length,
        ),
        weight=float(np.exp(rng.uniform(np.log(0.8), np.log(2.5)))) * displaced,
        buoyancy=rng.uniform(0.0, 0.1) * displaced,
        line=line,
        depth=depth,
        down_to=tuple(depth * (index + 1) / layers for index in range(layers)),
        speed=tuple(rng.uniform(-0.2, 1.2, layers)),
        release=rng.uniform(0.0, 10.0),
    )
