"""Terminal velocity required of the descent (Briggs et al., Eq. 1)."""

import numpy as np

from missionplan.arrays import Array, Scalars


def layer_thicknesses(down_to: Array, depth: float) -> Array:
    """Thickness of each layer of the water column; the last one reaches the seafloor.

    Parameters
    ----------
    down_to : array, shape (k,)
        Lower edge of each layer, from the surface down [m].
    depth : float
        Of the seafloor [m].

    Returns
    -------
    array, shape (k,)
        Thicknesses that add up to `depth`; 0 for a layer below the seafloor [m].

    Raises
    ------
    ValueError
        When there is no layer, or the edges do not increase.
    """
    edges = np.concatenate(([0.0], np.asarray(down_to, dtype=float)))
    if edges.size < 2 or np.any(np.diff(edges) <= 0.0):
        raise ValueError("expected at least one layer, and lower edges that increase from the surface down")
    edges[-1] = max(edges[-1], depth)
    return np.diff(np.minimum(edges, depth))


def required_terminal_velocity(speeds: Array, thicknesses: Array, radius: Scalars) -> Scalars:
    """Terminal velocity that bounds the drift when the worst currents are aligned: Eq. 1 for any number of layers.

    It assumes terminal velocity from the start and neglects release and pay-out, so that the drift of a real dive may
    be larger.

    Parameters
    ----------
    speeds : array, shape (k,) or (k, n)
        Worst current of each layer [m/s].
    thicknesses : array, shape (k,)
        Of each layer, surface to seafloor [m].
    radius : float or array, shape (n,)
        Allowed drift R [m].

    Returns
    -------
    float or array, shape (n,)
        Σ |v_i| h_i / R [m/s].
    """
    return np.tensordot(thicknesses, np.abs(speeds), axes=(0, 0)) / radius


def required_terminal_velocity_vector(speeds: Array, toward: Array, thicknesses: Array, radius: Scalars) -> Scalars:
    """Terminal velocity that bounds the drift when each layer has its own direction.

    Parameters
    ----------
    speeds, toward : array, shape (k,) or (k, n)
        Current of each layer [m/s], and direction towards which it flows, clockwise from north [rad].
    thicknesses : array, shape (k,)
        [m].
    radius : float or array, shape (n,)
        Allowed drift R [m].

    Returns
    -------
    float or array, shape (n,)
        ‖Σ v_i h_i‖ / R [m/s]; never above `required_terminal_velocity`.
    """
    east = np.tensordot(thicknesses, speeds * np.sin(toward), axes=(0, 0))
    north = np.tensordot(thicknesses, speeds * np.cos(toward), axes=(0, 0))
    return np.hypot(east, north) / radius
