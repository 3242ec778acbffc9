"""Electrical power under way, and the unit of energy."""

from missionplan.arrays import Scalars

JOULES_PER_WATT_HOUR = 3600.0
"""J in 1 Wh: batteries are rated, and energies reported, in watt-hours."""


def propulsive_power(drag: Scalars, speed: Scalars, efficiency: Scalars) -> Scalars:
    """Electrical power of propulsion, F u/η = ½ρAC_d u³/η.

    Parameters
    ----------
    drag : float or array, shape (n,)
        F at that speed [N].
    speed : float or array, shape (n,)
        u through the water [m/s].
    efficiency : float or array, shape (n,)
        η, from the battery to the work against drag.

    Returns
    -------
    float or array, shape (n,)
        [W]
    """
    return drag * speed / efficiency
