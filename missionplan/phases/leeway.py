"""The wind's part in the drift of a vehicle afloat."""

from dataclasses import dataclass

import numpy as np
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.phases.currents import Current
from missionplan.phases.hooks import TransitEffect


def leeway_velocity(wind: Array, downwind: Scalars, crosswind: Scalars, along: Scalars, across: Scalars) -> Array:
    """Velocity through the water that the wind gives a body afloat.

    Allen and Plourde 1999 (USCG R&D Center, CG-D-08-99), as Breivik and Allen 2008 (J. Mar. Syst. 69, 99) use it: down
    the wind a share of its speed and a constant, across it a share, to one side. Measured for winds of 2 to 20 m/s.
    In a calm there is no direction down the wind, and no leeway.

    Parameters
    ----------
    wind : array, shape (2, n)
        Velocity of the air, 10 m above the sea, toward east and north [m/s].
    downwind, crosswind : float or array, shape (n,)
        Shares of the wind's speed; crosswind positive to the right of where the air moves.
    along, across : float or array, shape (n,)
        Velocities besides [m/s].

    Returns
    -------
    array, shape (2, n)
        [m/s]
    """
    speed = np.hypot(wind[0], wind[1])
    blows = speed > 0.0
    east, north = np.where(blows, wind / np.where(blows, speed, 1.0), 0.0)
    down, right = downwind * speed + along, crosswind * speed + across
    return np.stack((down * east + right * north, down * north - right * east))


@dataclass(frozen=True)
class Leeway(TransitEffect):
    """Drift with the wind while at the surface.

    Attributes
    ----------
    wind : Current
        Velocity of the air, 10 m above the sea.
    downwind, crosswind, along, across : float or array, shape (n,)
        See `leeway_velocity`.
    """

    wind: Current
    downwind: Scalars
    crosswind: Scalars
    along: Scalars
    across: Scalars

    @override
    def surface_velocity(self, t: Array, duration: Array, position: Array) -> Array:
        air = self.wind.mean_velocity(t, duration, 0.0, position, np.zeros((2, 1)))
        air = np.broadcast_to(air, (2, np.size(t)))
        return leeway_velocity(air, self.downwind, self.crosswind, self.along, self.across)
