"""Files of a transit case: the navigation log in metres or degrees, and the base mission."""

from typing import Any

import numpy as np

from .catalogue import Array
from .sailing import Log
from .survey import Survey


def columns(survey: Survey, log: Log, rng: np.random.Generator, need_surface: bool):
    """Write the log in metres or degrees: header, rows, ``dataset.yaml``."""
    metres = rng.random() < 0.5
    legs = np.flatnonzero(rng.random(log.heading.size) >= rng.choice([0.0, 0.0, 0.03]))
    extras = _extra_columns(survey, log, rng, need_surface)
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


def _extra_columns(survey: Survey, log: Log, rng: np.random.Generator, need_surface: bool) -> dict[str, Array]:
    extras: dict[str, Array] = {}
    if need_surface or rng.random() < 0.7:
        extras["surface_s"] = survey.surface
    if rng.random() < 0.6:
        extras["speed_m_s"] = survey.speed
    if rng.random() < 0.6:
        extras["heading_deg"] = np.round(np.degrees(log.heading) % 360.0, 1)
    if rng.random() < 0.15:
        extras["battery_v"] = np.round(16.0 - 2.0 * log.t_start / log.t_start[-1], 2)
    return extras


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
    """Return latitude and longitude [deg] after a step of at most a few kilometres east and north [m]."""
    a, e2 = 6378137.0, 6.69437999014e-3

    def radii(phi: float) -> tuple[float, float]:
        w = 1.0 - e2 * np.sin(phi) ** 2
        return a * (1.0 - e2) / w**1.5, a / w**0.5

    phi = np.radians(latitude)
    middle = phi + 0.5 * step[1] / radii(phi)[0]
    meridian, normal = radii(middle)
    new = phi + step[1] / meridian
    turn = step[0] / (normal * np.cos(middle))
    return float(np.degrees(new)), float((longitude + np.degrees(turn) + 180.0) % 360.0 - 180.0)


def mission_file(survey: Survey, rng: np.random.Generator) -> dict[str, Any]:
    """Return the base mission; its velocity error is a guess within a fifth of the true one."""
    speed = float(np.mean(survey.speed))
    leg = speed * float(np.median(survey.planned))
    transit = {
        "name": "survey",
        "from": ["0 m", "0 m"],
        "to": [f"{8.0 * leg:.0f} m", "0 m"],
        "speed": f"{speed:.3f} m/s",
        "d_max": f"{leg:.0f} m",
        "arrival_radius": f"{0.1 * leg:.0f} m",
    }
    return {
        "name": "Survey",
        "site": {"origin": {"latitude": f"{survey.latitude:.5f} deg", "longitude": f"{survey.longitude:.5f} deg"}},
        "navigation": {
            "velocity_error": {"sigma": f"{survey.sigma * rng.uniform(0.83, 1.2):.4f} m/s"},
            "surfacing_time": f"{float(np.mean(survey.surface)):.0f} s",
            "fix_error": f"{survey.fix:.1f} m",
        },
        "phases": [{"transit": transit}],
        "monte_carlo": {"trials": 2000, "seed": 1},
    }
