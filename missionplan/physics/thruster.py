"""Static thrust of a thruster against its command, ahead and astern (Avila et al., section 5)."""

import numpy as np

from missionplan.arrays import Scalars


def bollard_pull(command: Scalars, ahead: Scalars, astern: Scalars, deadband: Scalars = 0.0) -> Scalars:
    """Thrust in bollard pull, τ = cV|V| with a constant for each direction and a deadband.

    Avila et al., Eq. 6, with V reduced by the deadband: τ = ±c(|V| - V₀)², and zero inside it, so that thrust is
    continuous.

    Parameters
    ----------
    command : float or array
        Voltage [V] or shaft rate [rad/s]; positive ahead.
    ahead, astern : float or array
        c for positive and for negative commands [N per command²]; 9.423 and 6.551 for the URS's thruster, printed
        in N/V².
    deadband : float or array
        V₀ ≥ 0, in units of the command.

    Returns
    -------
    float or array
        Thrust, positive ahead [N].
    """
    beyond = np.maximum(np.abs(command) - deadband, 0.0)
    thrust: Scalars = np.where(np.asarray(command) >= 0.0, ahead, -np.asarray(astern)) * beyond**2
    return thrust
