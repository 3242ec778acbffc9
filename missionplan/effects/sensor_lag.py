"""A depth sensor with a lag."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect

SHORTEST = 1e-9
"""Time constant in place of none at all [s]."""


@dataclass(frozen=True)
class SensorLag(DescentEffect):
    """Reading of the true depth through a filter of mean delay `time`: a slow sensor, and a logger that averages.

    The sensor is a filter of first order, ``τ·dr/dt = z − r``; the logger takes the mean over the last w seconds, which
    delays by w/2: τ + w/2 = `time`, w/(2τ) = `averaging`. Without averaging the filter is of first order; with a
    great deal it is a moving average; two time constants in series are like a little.
    """

    time: Scalars = 0.0
    averaging: Scalars = 0.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the depth that the sensor reads: exact for a depth linear between grid points.

        Parameters
        ----------
        t : array, shape (m,)
            Uniform time grid [s].
        depth : array, shape (m, ...)
            True depth, trials last [m].
        """
        lag = np.broadcast_to(np.maximum(np.asarray(self.time, dtype=float), 0.0), depth.shape[1:])
        averaging = np.asarray(self.averaging, dtype=float)
        constant = lag / (1.0 + averaging)
        step, rate = float(t[1] - t[0]), np.diff(depth, axis=0) / (t[1] - t[0])
        behind = _behind(step, rate, constant)
        reading = depth - behind
        window = 2.0 * lag * averaging / (1.0 + averaging)
        own = window > 0.0
        if own.any():
            trials = (values[..., own] for values in (depth, rate, behind, constant, window))
            reading[..., own] = _averaged(step, *trials)
        return reading


def _behind(step: float, rate: Array, constant: Array) -> Array:
    """How far filters of first order are behind a depth of given rates in each step, shape (m, ...) [m]."""
    decay = np.exp(-step / np.maximum(constant, SHORTEST))
    result = np.zeros((len(rate) + 1, *rate.shape[1:]))
    for k in range(len(rate)):
        result[k + 1] = decay * result[k] + (1.0 - decay) * constant * rate[k]
    return result


def _averaged(step: float, depth: Array, rate: Array, behind: Array, constant: Array, window: Array) -> Array:
    """Means of sensors' outputs over the last seconds, shape (m, n) [m].

    A filter's output r has the integral of its input less τ times its own change: ∫ r = ∫ z - τ·Δr.

    Parameters
    ----------
    step : float
        Of the time grid [s].
    depth, behind : array, shape (m, n)
        What the sensor sees, and how far its output is behind [m].
    rate : array, shape (m - 1, n)
        Of the depth in each step [m/s].
    constant, window : array, shape (n,)
        Of the sensor and the mean [s].
    """
    integral = np.zeros_like(depth)
    np.cumsum(0.5 * step * (depth[1:] + depth[:-1]), axis=0, out=integral[1:])
    now = integral - constant * (depth - behind)
    rows = np.ceil(window / step).astype(np.intp)
    since = rows * step - window  # from the grid's time before the window's begin
    decay = np.exp(-since / np.maximum(constant, SHORTEST))
    output = depth[:-1] + since * rate - decay * behind[:-1] - (1.0 - decay) * constant * rate
    begin = integral[:-1] + since * depth[:-1] + 0.5 * since**2 * rate - constant * output
    place = np.arange(len(depth))[:, None] - rows
    before = np.take_along_axis(begin, np.maximum(place, 0), axis=0)
    at_rest = depth[0] * (step * np.arange(len(depth))[:, None] - window - constant)
    return np.asarray((now - np.where(place < 0, at_rest, before)) / window)


INFO = EffectInfo(
    id="sensor-lag",
    phase="descent",
    tier="physical",
    effect=SensorLag,
    parameters={
        "time": Parameter(
            "s",
            "mean delay: the sensor's time constant and half the window of a mean",
            0.0,
            10.0,
            scale=0.5,
            spike=0.02,
        ),
        "averaging": Parameter(
            "",
            "delay by averaging (half the window) over the sensor's own time constant; great for a moving average",
            0.0,
            1000.0,
            median=1.0,
            factor=5.0,
        ),
    },
    what="A filtered or slow pressure sensor: at a steady speed its reading is late by its time constant.",
    finding=Finding(
        "time",
        "the depth sensor lags by {size}",
        "the depth sensor leads by {size}",
        remedy="correct the log for it; the plan stays as it is",
    ),
    sizes="Averaging in loggers gives 0.1 to 1 s; a lag is positive.",
    confused_with=("clock-offset", "line-payout"),
    distinguished_by=(
        "Fast sampling at the start of the dive (a lag rounds it, a clock shifts it); dipping the sensor by hand."
    ),
    changes_plan=False,
    instrument=Instrument("a dip of the sensor by hand, sampled fast", "time", 0.05, 15.0),
)
