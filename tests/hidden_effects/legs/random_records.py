"""Records drawn from a normal law of their own: errors that gather within a leg, inertial currents that wander.

Each is the simplest record that can show the effect, with the log of the Bayes factor that its own law has over the
nearest law without it: what the best method could know. The rival's parameters are those that fit the record best, so
that the figure is rather too low than too high.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from ..case import Case
from .catalogue import SIDEREAL_DAY, Array

DAY = 86400.0
STEPS_OF_A_LEG = 24
"""Steps by which the mean of a current over a leg is found."""


@dataclass(frozen=True)
class Record:
    """Legs one after the other that share their fixes; positions have shape (legs, 2)."""

    t_start: Array
    time: Array
    speed: float
    heading: Array
    error: Array
    """Displacement beyond dead reckoning [m]."""
    fixes: Array
    """Errors of the fixes, shape (legs + 1, 2) [m]."""


def log_density(values: Array, covariance: Array) -> float:
    """Log density of independent columns of values, each normal about zero."""
    factor = np.linalg.cholesky(covariance)
    white = np.linalg.solve(factor, values)
    return -0.5 * float(np.sum(white**2)) - values.shape[1] * float(np.log(np.diag(factor)).sum())


def best_log_density(values: Array, covariance, start: list[float]) -> float:
    """Greatest log density over the logarithms of a covariance's parameters."""

    def minus(logarithms: Array) -> float:
        try:
            return -log_density(values, covariance(*np.exp(np.clip(logarithms, -30.0, 30.0))))
        except np.linalg.LinAlgError:
            return 1e9

    return -float(minimize(minus, np.log(start), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-3}).fun)


def shared_fix_covariance(time: Array) -> Array:
    """Covariance of a leg's velocity errors from fixes of 1 m that neighbouring legs share [1/s²]."""
    between = np.eye(time.size + 1)[1:] - np.eye(time.size + 1)[:-1]
    return between @ between.T / np.outer(time, time)


def gathering(seed: int, scale: float = 1.0, walking: bool = True) -> Case:
    """Draw a case whose position error gathers within each leg, beside a velocity error and poor fixes.

    Parameters
    ----------
    seed : int
    scale : float
        Factor on the size of what gathers.
    walking : bool
        False for the same record without it.
    """
    rng = np.random.default_rng([seed, 41])
    legs = int(rng.integers(230, 271))
    time = np.exp(rng.uniform(np.log(600.0), np.log(2400.0), legs))
    sigma, fix = rng.uniform(0.008, 0.02), rng.uniform(4.0, 15.0)
    rate = scale * sigma * np.sqrt(1200.0) * np.exp(rng.uniform(np.log(1.5), np.log(8.0))) * walking
    noise = rng.standard_normal((3, legs + 1, 2))
    error = sigma * time[:, None] * noise[0, 1:] + rate * np.sqrt(time)[:, None] * noise[1, 1:]
    fixes = fix * noise[2]
    t_start = np.append(0.0, np.cumsum(time + 60.0)[:-1])
    record = Record(t_start, time, 0.6, _headings(rng, legs), error, fixes)
    velocity = (error + np.diff(fixes, axis=0)) / time[:, None]
    shared = shared_fix_covariance(time)
    own = log_density(velocity, np.diag(sigma**2 + rate**2 / time) + fix**2 * shared)
    gain = own - best_log_density(
        velocity, lambda white, poor: white**2 * np.eye(legs) + poor**2 * shared, [2 * sigma, fix]
    )
    truth = ("position-random-walk",) if walking else ()
    parameters = {"position-random-walk.rate": rate} if walking else {}
    return _case(seed, "gathering" if walking else "control", record, truth, parameters, gain, sigma, fix, 20.0)


def wandering(seed: int, latitude: float = 27.0, inertial: bool = True) -> Case:
    """Draw a case with persistent errors and, beside them, an inertial current whose amplitude and phase wander.

    Sixty legs in ten days; 3 cm/s rms of inertial current with an e-folding time of ten days; persistent errors of
    5 cm/s over 4 days and 2 cm/s of independent error.

    Parameters
    ----------
    seed : int
    latitude : float
        [deg]
    inertial : bool
        False for the same record without the inertial current.
    """
    rng = np.random.default_rng([seed, 42])
    legs, span = 60, 10.0 * DAY
    time = np.full(legs, span / legs - 120.0)
    t_start = span / legs * np.arange(legs)
    f = 4.0 * np.pi / SIDEREAL_DAY * np.sin(np.radians(latitude))
    t = (t_start[:, None] + time[:, None] * (np.arange(STEPS_OF_A_LEG) + 0.5) / STEPS_OF_A_LEG).ravel()
    apart = np.abs(t[:, None] - t)
    mean = np.kron(np.eye(legs), np.full((1, STEPS_OF_A_LEG), 1.0 / STEPS_OF_A_LEG))

    def persistent(white: float, size: float, memory: float) -> Array:
        each = white**2 * np.eye(legs) + size**2 * mean @ np.exp(-apart / memory) @ mean.T
        return np.kron(np.eye(2), each)

    # a turning current of complex covariance s² e^(-|τ|/T - ifτ): half of it in each component
    kept = 0.5 * 0.03**2 * np.exp(-apart / (10.0 * DAY))
    turned = f * (t[:, None] - t)
    level, across = mean @ (kept * np.cos(turned)) @ mean.T, mean @ (kept * np.sin(turned)) @ mean.T
    without = persistent(0.02, 0.05, 4.0 * DAY)
    whole = without + np.block([[level, across], [-across, level]])
    drawn = np.linalg.cholesky(whole if inertial else without) @ rng.standard_normal((2 * legs, 1))
    rival = best_log_density(drawn, persistent, [0.02, 0.05, 4.0 * DAY])
    gain = log_density(drawn, whole) - rival
    velocity = drawn.reshape(2, legs).T
    record = Record(
        t_start, time, 0.3, _headings(rng, legs), velocity * time[:, None], 5.0 * rng.standard_normal((legs + 1, 2))
    )
    truth = ("inertial-current", "persistent-error") if inertial else ("persistent-error",)
    name = "wandering" if inertial else "single"
    return _case(seed, name, record, truth, {"persistent-error.sigma": 0.05}, gain, 0.02, 5.0, latitude)


def _headings(rng: np.random.Generator, legs: int) -> Array:
    """Headings of a survey there and back, with a turn between."""
    first = rng.uniform(0.0, 2.0 * np.pi)
    return first + np.pi * (np.arange(legs) // 5 % 2) + 0.5 * np.pi * (np.arange(legs) % 5 == 4)


def _case(
    seed: int,
    scenario: str,
    record: Record,
    truth: tuple[str, ...],
    parameters: dict[str, float],
    gain: float,
    sigma: float,
    fix: float,
    latitude: float,
) -> Case:
    way = record.speed * record.time[:, None] * np.stack([np.sin(record.heading), np.cos(record.heading)], axis=1)
    true = np.vstack([np.zeros(2), np.cumsum(way + record.error, axis=0)]) + record.fixes
    places = np.hstack([true[:-1], true[:-1] + way, true[1:]])
    times = np.stack([record.t_start, record.t_start + record.time], axis=1)
    leg = record.speed * float(np.median(record.time))
    transit = {
        "name": "survey",
        "from": ["0 m", "0 m"],
        "to": [f"{8.0 * leg:.0f} m", "0 m"],
        "speed": f"{record.speed} m/s",
        "d_max": f"{leg:.0f} m",
        "arrival_radius": f"{0.1 * leg:.0f} m",
    }
    return Case(
        seed=seed,
        kind="transit",
        scenario=scenario,
        truth=truth,
        ties=(),
        outside="",
        parameters=parameters,
        strength=gain,
        mission={
            "name": "Record",
            "site": {"origin": {"latitude": f"{latitude} deg", "longitude": "-90 deg"}},
            "navigation": {
                "velocity_error": {"sigma": f"{sigma:.4f} m/s"},
                "surfacing_time": "60 s",
                "fix_error": f"{fix:.1f} m",
            },
            "phases": [{"transit": transit}],
            "monte_carlo": {"trials": 1000, "seed": 1},
        },
        vehicle=None,
        dataset={"kind": "transit", "name": "Record", "file": "legs.csv", "source": "made up"},
        header=["leg", "t_start_s", "t_end_s", "x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m"],
        rows=[
            [str(i + 1), *(f"{value:.1f}" for value in times[i]), *(f"{value:.3f}" for value in places[i])]
            for i in range(record.time.size)
        ],
        notes={"log_bayes_factor": gain, "sigma": sigma, "fix": fix},
    )
