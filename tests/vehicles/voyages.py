"""Missions at random, each with the sea that it says, in numbers that are not the package's."""

import math
from pathlib import Path

import numpy as np
import yaml
from sea import Sea

MISSIONS = Path(__file__).parents[2] / "missions"
VEHICLE = yaml.safe_load((MISSIONS / "vehicles" / "vt475-self-mooring.yaml").read_text())


def voyage_of(number: int, *, gliding: bool = False) -> tuple[dict, Sea, dict]:
    """Mission's data, its sea, and what its interpreters need beside the file; a glider's is slower and deeper."""
    rng = np.random.default_rng(1000 + number)

    def between(low: float, high: float) -> float:
        return round(float(rng.uniform(low, high)), 3)

    length, course = between(700.0, 2200.0), rng.uniform(0.0, 2.0 * math.pi)
    goal = round(length * math.sin(course), 1), round(length * math.cos(course), 1)
    depth, speed, water = between(1.5, 6.0), between(1.0, 1.8), between(16.0, 30.0)
    toward, upper, lower = between(0.0, 360.0), between(0.0, 0.25), between(0.0, 0.15)
    scatter, sigma, fix_sd, fix_time = between(0.0, 0.04), between(0.005, 0.04), between(1.0, 4.0), between(20.0, 90.0)
    bias = between(-4.0, 4.0) if number % 2 else 0.0
    fix_more = 3.0 * fix_time if number % 4 == 3 else 0.0
    if gliding:
        depth, speed, upper, lower = depth + 5.0, 0.25 * speed, 0.3 * upper, 0.3 * lower
        scatter, sigma = 0.3 * scatter, 0.3 * sigma
    transit = {"depth": f"{depth} m", "speed": f"{speed} m/s", "d_max": f"{between(250.0, 500.0)} m"}
    transit |= {"arrival_radius": f"{between(15.0, 40.0)} m"}
    current = [
        {"down_to": "14 m", "speed": {"mean": f"{upper} m/s", "sd": f"{scatter} m/s"}, "toward": f"{toward} deg"},
        {"down_to": f"{water} m", "speed": {"mean": f"{lower} m/s", "sd": f"{scatter} m/s"}, "toward": f"{toward} deg"},
    ]
    data = {
        "name": f"voyage {number}",
        "vehicle": VEHICLE,
        "site": {
            "origin": {"latitude": "37.25 deg", "longitude": "-76.38 deg"},
            "depth": f"{water} m",
            "water": {"temperature": "20 degC", "salinity": 15},
            "current": current,
        },
        "navigation": {
            "velocity_error": {"sigma": f"{sigma} m/s"},
            "surfacing_time": {"low": f"{fix_time} s", "high": f"{fix_time + fix_more} s"}
            if fix_more
            else f"{fix_time} s",
            "fix_error": f"{fix_sd} m",
            "drift_compensation": "mean",
        },
        "effects": [{"compass-bias": {"angle": f"{bias} deg"}}] if bias else [],
        "phases": [
            {"transit": {"name": "out", "from": ["0 m", "0 m"], "to": [f"{goal[0]} m", f"{goal[1]} m"], **transit}},
            {
                "moor": {
                    "radius": "60 m",
                    "anchor_wet_weight": "11.8 N",
                    "line_length": "5 m",
                    "release_time": "10 s",
                    "hold": "5 min",
                    "galvanic_release": "2 min",
                }
            },
            {"transit": {"name": "home", "to": ["0 m", "0 m"], **transit}},
        ],
    }
    sea = Sea(
        ((14.0, upper, scatter, toward), (water, lower, scatter, toward)),
        sigma,
        fix_sd,
        fix_time,
        fix_more,
        compass_bias=bias,
    )
    return data, sea, {"goal": goal, "bottom": water - 5.0, "galvanic": 120.0, "speed": speed, "depth": depth}
