"""A depth sensor with a lag."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class SensorLag(DescentEffect):
    """Reading r of the true depth z with ``time·dr/dt = z − r`` (first order)."""

    time: Scalars = 0.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the depth that the sensor reads: exact for a depth linear between grid points.

        Parameters
        ----------
        t : array, shape (m,)
            Uniform time grid [s].
        depth : array, shape (m, ...)
            True depth, trials last [m].
        """
        step = float(t[1] - t[0])
        lag = np.broadcast_to(np.maximum(np.asarray(self.time, dtype=float), 0.0), depth.shape[1:])
        ratio = step / np.maximum(lag, 1e-9)
        decay = np.exp(-ratio)
        slope = np.diff(depth, axis=0)
        mean_slope = np.where(lag > 0.0, -np.expm1(-ratio) / ratio, 0.0)
        result = np.empty_like(depth)
        behind = np.zeros(depth.shape[1:])
        result[0] = depth[0]
        for k in range(len(slope)):
            behind = decay * behind + mean_slope * slope[k]
            result[k + 1] = depth[k + 1] - behind
        return result


INFO = EffectInfo(
    id="sensor-lag",
    phase="descent",
    tier="physical",
    effect=SensorLag,
    parameters={"time": Parameter("s", "time constant of the sensor", 0.0, 10.0, scale=0.5, spike=0.02)},
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
    is_sensor_lag=True,
    instrument=Instrument("a dip of the sensor by hand, sampled fast", "time", 0.05, 15.0),
)
