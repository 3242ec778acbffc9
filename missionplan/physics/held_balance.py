"""Newton's method for pitch and altitude of a held body together, in a profile of the current: where to begin.

It takes six steps where a search for the altitude, with one for the pitch at each, takes twenty-five. But it may fail,
or come to the other of two balances where the current falls off upward: `line_statics` searches from what it finds.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.physics.current_above import ProfileAbove
from missionplan.physics.held_body import HeldBody

Height = Callable[[Array, Array], Array]
"""Height of the nose that a line makes [m], from its altitude [m] and its pull, shape (3, n) [N]."""

_MOST = 10
_NEAR = 3e-5
"""Step after which the next would be less than a tolerance of 1e-7 [rad, line lengths]."""
_LONGEST = 0.5
"""Step of the pitch [rad]."""
_LEAST = 1e-12


def balanced(
    body: HeldBody, current: ProfileAbove, height: Height, length: Array, start: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Approach the pitch [rad] and the altitude of the nose [m] at which a body is in balance.

    Parameters
    ----------
    body : HeldBody
    current : ProfileAbove
    height : callable
    length : array, shape (n,)
        Of the line [m].
    start : tuple of array, shape (n,)
        Pitch and altitude; kept in trials in which the method does not converge, or passes places from which the body
        would move on.
    """
    pitch, altitude = start
    open_, steady = np.ones((2, pitch.size), dtype=bool)
    for _ in range(_MOST):
        turn, rise, returns = _Balance(body, current, pitch, altitude).newton(height, length)
        steady &= returns | ~open_
        turned = np.clip(pitch + np.clip(turn, -_LONGEST, _LONGEST), -0.5 * np.pi, 0.5 * np.pi)
        pitch = np.where(open_, turned, pitch)  # what was found does not depend on the other trials
        altitude = np.where(open_, np.clip(altitude + rise, 0.0, length), altitude)
        open_ &= (np.abs(turn) > _NEAR) | (np.abs(rise) > _NEAR * length)
        if not open_.any():
            break
    found = steady & ~open_
    return np.where(found, pitch, start[0]), np.where(found, altitude, start[1])


@dataclass(frozen=True)
class _Varying:
    """A number of each trial, and how it changes with the pitch [1/rad] and the altitude [1/m]."""

    value: Scalars
    turn: Scalars
    rise: Scalars = 0.0

    def __add__(self, other: "_Varying") -> "_Varying":
        return _Varying(self.value + other.value, self.turn + other.turn, self.rise + other.rise)

    def __sub__(self, other: "_Varying") -> "_Varying":
        return _Varying(self.value - other.value, self.turn - other.turn, self.rise - other.rise)

    def __mul__(self, other: "_Varying") -> "_Varying":
        return _Varying(
            self.value * other.value,
            self.value * other.turn + self.turn * other.value,
            self.value * other.rise + self.rise * other.value,
        )

    def times(self, factor: Scalars) -> "_Varying":
        return _Varying(self.value * factor, self.turn * factor, self.rise * factor)


@dataclass(frozen=True)
class _Balance:
    """Moment about the nose, and excess of the height that the line makes over the altitude, with their derivatives.

    How the current's direction changes is left out: it does not change the moment. The derivatives of the height are
    those of a straight line, and those of the axial drag are a square law's.
    """

    body: HeldBody
    current: ProfileAbove
    pitch: Array
    altitude: Array

    def newton(self, height: Height, length: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Newton's steps of pitch [rad] and altitude [m], and whether the body would return from a little away."""
        moment, across, up, course = self._loads()
        lifted = height(self.altitude, np.stack((course[0] * across.value, course[1] * across.value, up.value)))
        excess = lifted - self.altitude
        # of a straight line: length × up / pull
        pull = np.maximum(np.hypot(across.value, up.value), _LEAST)
        lever = length * across.value / pull**3
        excess_turn = lever * (across.value * up.turn - up.value * across.turn)
        excess_rise = lever * (across.value * up.rise - up.value * across.rise) - 1.0
        area = moment.turn * excess_rise - moment.rise * excess_turn
        returns = (moment.turn < 0.0) & (area > 0.0)
        area = np.where(np.abs(area) > _LEAST, area, np.inf)
        turn = (moment.rise * excess - moment.value * excess_rise) / area
        return turn, (moment.value * excess_turn - moment.turn * excess) / area, returns

    def _loads(self) -> tuple[_Varying, _Varying, _Varying, Array]:
        """Moment that raises the tail [N m], pull on the line along the current and up [N], and where that flows."""
        body, places = self.body, self.body.sections
        sine, cosine = np.sin(self.pitch), np.cos(self.pitch)
        velocity, shear = self.current.with_shear(self.altitude + places * sine)
        course = (places * np.sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1]) * velocity).sum(axis=1)
        course /= np.maximum(np.hypot(course[0], course[1]), _LEAST)
        speeds, shears = (part[0] * course[0] + part[1] * course[1] for part in (velocity, shear))
        size = np.abs(speeds)
        squares, growth = body.section_drag * speeds * size, 2.0 * body.section_drag * size * shears
        by_place = (growth * places).sum(axis=0)
        drag = _Varying(squares.sum(axis=0), by_place * cosine, growth.sum(axis=0))
        arm = _Varying((squares * places).sum(axis=0), (growth * places * places).sum(axis=0) * cosine, by_place)
        mean = _Varying(speeds.mean(axis=0), (shears * places).mean(axis=0) * cosine, shears.mean(axis=0))
        sines, cosines = _Varying(sine, cosine), _Varying(cosine, -sine)
        steep = _Varying(sine * np.abs(sine), 2.0 * np.abs(sine) * cosine)
        moment = cosines.times(body.raising_moment) - sines.times(np.abs(body.righting_moment)) - arm * steep
        along, normal = mean * cosines, drag * steep
        force = body.axial_drag(along.value)
        steeper = 2.0 * force / np.where(np.abs(along.value) > _LEAST, along.value, np.inf)
        axial = _Varying(force, steeper * along.turn, steeper * along.rise)
        up = sines * axial - cosines * normal + _Varying(body.net_buoyancy, 0.0)
        return moment, cosines * axial + sines * normal, up, course
