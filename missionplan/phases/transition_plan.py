"""Parameters and record of a transition: vehicle, controls, manoeuvre, interchange, time histories."""

import math
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.physics.tunnel_thruster import TunnelThruster
from missionplan.physics.vehicle_dynamics import Body


def interchange(speed: Scalars, mid_speed: Scalars, steepness: Scalars) -> Scalars:
    """Share σ_TT of the depth control that the tunnel thrusters have, Eq. 12; the sternplanes have the rest.

    Parameters
    ----------
    speed, mid_speed : float or array
        u and u* [m/s].
    steepness : float or array
        Δσ [m/s]: small values step, large ones blend.
    """
    share: Scalars = 0.5 - 0.5 * np.tanh((speed - mid_speed) / steepness)
    return share


def allocation(pitch_demand: Scalars, steepness: Scalars, limit: Scalars) -> Scalars:
    """Share k₁ of the depth controller's force that the forward thruster of a pair makes, Eq. 20; the aft one 1 - k₁.

    The paper allocates "rotational speed (or force)". Shares of force keep the controller's gain and the depth change
    of the single thruster, as in the paper's results; shares of shaft rate would halve the force.

    Parameters
    ----------
    pitch_demand : float or array
        P_d, positive nose down [rad].
    steepness, limit : float or array
        G and P_dL [rad].
    """
    share: Scalars = 0.5 * np.tanh(steepness * pitch_demand / limit) + 0.5
    return share


@dataclass(frozen=True)
class SternplaneControl:
    """Depth by pitch, pitch by sternplanes (Fig. 2): proportional and integral on depth, then proportional and rate.

    `depth_gain` [rad/m], `depth_integral` [rad/(m s)], `pitch_limit` [rad] of the demand, `pitch_gain` [-],
    `rate_gain` [s], and the deflection's `limit` [rad].
    """

    depth_gain: float
    depth_integral: float
    pitch_limit: float
    pitch_gain: float
    rate_gain: float
    limit: float = math.radians(20.0)


@dataclass(frozen=True)
class ThrusterControl:
    """Shaft rate of the thrusters by depth (sect. 5.1), and its allocation to a pair (sect. 7.2).

    `depth_gain` [rev/s a metre], `depth_integral` [rev/s a metre second], `depth_rate` [rev/s a metre a second] and the
    `limit` [rev/s]; `pair_steepness` G, `pair_limit` P_dL [rad] and `pair_lead`, the lead of the pitch rate [s].
    """

    depth_gain: float
    depth_integral: float
    depth_rate: float
    limit: float
    pair_steepness: float = 1.0
    pair_limit: float = math.radians(10.0)
    pair_lead: float = 0.0


@dataclass(frozen=True)
class TransitionVehicle:
    """Parameters of a vehicle."""

    body: Body
    """Mass, buoyancy, derivatives."""
    propeller: tuple[float, float, float]
    """b₁, b₂, b₃ of `propeller_force`."""
    speed_gain: float
    """Of the propeller's command over the speed error."""
    thrusters: tuple[TunnelThruster, ...]
    """None, one, or forward and aft; positive thrust is down."""
    suction_moment: bool
    """Whether the jet's suction has a moment (sect. 7.1); in the paper's first runs it has none."""
    sternplanes: SternplaneControl
    """Controls at speed."""
    thruster_control: ThrusterControl
    """Controls at low speed."""


@dataclass(frozen=True)
class Manoeuvre:
    """The required manoeuvre: floats or arrays over trials."""

    start_speed: float
    """Survey speed [m/s]."""
    deceleration: Scalars
    """Of the required speed, positive [m/s²]."""
    mid_speed: Scalars
    steepness: Scalars
    """u* and Δσ of the interchange [m/s]."""
    before: float = 20.0
    """Time at survey speed before slowing down [s]."""
    after: float = 200.0
    """Time simulated after the required speed has reached zero in the slowest trial [s]."""


@dataclass(frozen=True)
class History:
    """Time histories, shape (samples, n); `time` (samples,) counts from the start of the deceleration [s].

    `speed` [m/s], `pitch` [rad], `depth` below the target [m], `sternplane` [rad], `revolutions` of the first
    thruster [rev/s], `energy` of the thrusters since the deceleration [J].
    """

    time: Array
    speed: Array
    pitch: Array
    depth: Array
    sternplane: Array
    revolutions: Array
    energy: Array


@dataclass(frozen=True)
class TransitionRecord:
    """Results of a transition, arrays over trials of shape (n,)."""

    depth_excursion: Array
    """Greatest distance from the target depth [m]."""
    pitch_excursion: Array
    """Greatest change of pitch from that of the survey, either way [rad]."""
    hover_time: Array
    """Time since the deceleration began after which it stays within `HOVER_BAND` [s]; nan if it does not."""
    energy_to_hover: Array
    """Of the thrusters up to then, Eq. 14, option (b) [J]; nan if it does not."""
    hover_pitch: Array
    """Root mean square of the pitch about its mean over the last `STEADY` seconds [rad]."""
    saturation_speed: Array
    """Highest speed at which the sternplanes were at their limit [m/s]; nan if they never were."""
    out_of_range: Array
    """Share of the thrusters' energy spent beyond the force minimum, where the model of their force has not been
    checked."""
    end_energy: Array
    """Of the thrusters up to the end of the run [J]."""
    end_time: float
    """End of the run since the deceleration began [s]."""
    history: History
    """Sampled every `sample` seconds; of the start alone where that is not given."""


def energy_until(history: History, end: Scalars) -> Array:
    """Energy of the thrusters from the start of the deceleration until a time [J]; nan where the time is.

    Parameters
    ----------
    end : float or array, shape (n,)
        Since the deceleration began [s]; no later than the history.
    """
    ends = np.broadcast_to(end, history.energy.shape[1:])
    columns = [np.interp(e, history.time, column) for e, column in zip(ends, history.energy.T, strict=True)]
    return np.where(np.isnan(ends), np.nan, np.array(columns))
