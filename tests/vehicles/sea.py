"""A mission's own sea, written anew: its currents, errors of dead reckoning, fixes. Imports nothing of the package."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Sea:
    """What a mission says of its sea.

    Attributes
    ----------
    layers : tuple of (down to [m], mean speed, its sd [m/s], toward [deg])
    sigma : float
        Of the velocity error of a leg, each axis [m/s].
    fix_sd : float
        Each axis [m].
    fix_time, fix_time_more : float
        At the surface until a fix, and how much more it may be, any time between being as likely [s].
    compass_bias : float
        Course made less course steered, clockwise [deg].
    speed_error : float
        Speed made over speed commanded, less one.
    """

    layers: tuple[tuple[float, float, float, float], ...]
    sigma: float
    fix_sd: float
    fix_time: float
    fix_time_more: float = 0.0
    compass_bias: float = 0.0
    speed_error: float = 0.0


class Voyage:
    """One draw of the sea, and what the vehicle meets there."""

    def __init__(self, sea: Sea, rng: np.random.Generator) -> None:
        self.sea, self.rng = sea, rng
        self.fix_time = sea.fix_time + sea.fix_time_more * rng.random()
        self._layers = []
        for down_to, mean, sd, toward in sea.layers:
            speed, course = mean + sd * rng.standard_normal(), math.radians(toward)
            self._layers.append((down_to, (speed * math.sin(course), speed * math.cos(course))))

    def current(self, depth: float) -> tuple[float, float]:
        """East and north [m/s]."""
        for down_to, velocity in self._layers:
            if depth <= down_to:
                return velocity
        return self._layers[-1][1] if self._layers else (0.0, 0.0)

    def leg_error(self) -> tuple[float, float]:
        """Velocity error of a new leg [m/s]."""
        east, north = self.sea.sigma * self.rng.standard_normal(2)
        return float(east), float(north)

    def made(self, through: tuple[float, float], error: tuple[float, float], depth: float) -> tuple[float, float]:
        """Velocity over ground of a velocity through the water as the vehicle believes to make it [m/s]."""
        bias, scale = math.radians(self.sea.compass_bias), 1.0 + self.sea.speed_error
        east = scale * (through[0] * math.cos(bias) + through[1] * math.sin(bias))
        north = scale * (through[1] * math.cos(bias) - through[0] * math.sin(bias))
        current, under_way = self.current(depth), math.hypot(*through) > 0.0
        return east + current[0] + under_way * error[0], north + current[1] + under_way * error[1]

    def fix(self, position: list[float]) -> tuple[float, float]:
        """A fix at a true position [m]."""
        east, north = self.sea.fix_sd * self.rng.standard_normal(2)
        return position[0] + float(east), position[1] + float(north)
