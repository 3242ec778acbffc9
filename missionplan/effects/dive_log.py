"""Delays of a dive, and errors of its clock and depth sensor."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars, row_and_next
from missionplan.effects.info import EffectInfo, Finding, Instrument, Parameter
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
        # how far filters of first order are behind a depth of given rates in each step, shape (m, ...) [m]
        decay = np.exp(-step / np.maximum(constant, SHORTEST))
        behind = np.zeros((len(rate) + 1, *rate.shape[1:]))
        for k in range(len(rate)):
            behind[k + 1] = decay * behind[k] + (1.0 - decay) * constant * rate[k]
        reading = depth - behind
        window = 2.0 * lag * averaging / (1.0 + averaging)
        mask = window > 0.0
        if mask.any():
            trials = (values[..., mask] for values in (depth, rate, behind, constant, window))
            reading[..., mask] = _averaged(step, *trials)
        return reading


def _averaged(step: float, depth: Array, rate: Array, behind: Array, constant: Array, window: Array) -> Array:
    """Means of sensors' outputs over the last seconds, shape (m, n) [m].

    A filter's output r has the integral of its input less τ times its own change: ∫ r = ∫ z - τ·Δr.

    `step`: of the time grid [s]. `depth`, `behind`, (m, n): what the sensor sees, and how far its output is behind [m].
    `rate`, (m − 1, n): of the depth in each step [m/s]. `constant`, `window`, (n,): of the sensor and the mean [s].
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


SENSOR_LAG = EffectInfo(
    id="sensor-lag",
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


@dataclass(frozen=True)
class LinePayout(DescentEffect):
    """Everything after the separation is delayed by `delay_per_length` for each metre of line."""

    delay_per_length: Scalars = 0.0

    def delay(self, line_length: Scalars) -> Scalars:
        """Return the delay [s]."""
        return self.delay_per_length * line_length


LINE_PAYOUT = EffectInfo(
    id="line-payout",
    effect=LinePayout,
    parameters={"delay_per_length": Parameter("s/m", "delay for each metre of line", 0.0, 5.0, scale=0.2, spike=0.004)},
    what=(
        "Friction or tangling on the spool: the line pays out more slowly than the anchor's free fall would pull it."
    ),
    finding=Finding(
        "delay_per_length",
        "the line takes {size} to pay out",
        remedy="plan with the slower dive, or let the line run more freely",
    ),
    sizes="From zero to about half a second per metre; a delay is positive. Assumed from hand-wound spools.",
    confused_with=("clock-offset",),
    distinguished_by=("Dives with a much longer or shorter line; with one length it is identical to a clock offset."),
)


@dataclass(frozen=True)
class ClockOffset(DescentEffect):
    """Everything is delayed by `time` on the clock of the log."""

    time: Scalars = 0.0

    def delay(self, line_length: Scalars) -> Scalars:
        """Return the delay [s]."""
        return self.time


CLOCK_OFFSET = EffectInfo(
    id="clock-offset",
    effect=ClockOffset,
    parameters={
        "time": Parameter("s", "offset, positive when the dive is late on the log", -10.0, 10.0, scale=0.5, spike=0.02)
    },
    what="Time zero of the log is the release command, or the clock of another computer, not the anchor's separation.",
    finding=Finding(
        "time",
        "the log has the dive {size} late",
        "the log has the dive {size} early",
        remedy="set the clocks together before the next dive; the plan stays as it is",
    ),
    sizes="Solenoids and pin pullers take 0.1 to 1 s; the clocks of loggers differ by as much. Either sign.",
    confused_with=("line-payout", "sensor-lag", "sensor-position"),
    distinguished_by="Dives with a much longer line (a payout delay grows with it, a clock does not).",
    changes_plan=False,
    follows_law=True,
    scatter="release",
    instrument=Instrument("the separation heard or filmed against the log's clock", "time", 0.05, 5.0),
)


@dataclass(frozen=True)
class ClockRate(DescentEffect):
    """The log counts ``1 + fraction`` seconds in a second since the separation."""

    fraction: Scalars = 0.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the depth at the true times, linear between those of the grid and straight beyond its end [m]."""
        rates = np.broadcast_to(1.0 + np.asarray(self.fraction, dtype=float), depth.shape[1:])
        place = np.arange(float(len(t))).reshape(-1, *(1,) * (depth.ndim - 1)) / rates
        row = np.minimum(place.astype(np.intp), len(depth) - 2)
        low, high = row_and_next(depth, row)
        return np.asarray((1.0 - (place - row)) * low + (place - row) * high)


CLOCK_RATE = EffectInfo(
    id="clock-rate",
    effect=ClockRate,
    parameters={
        "fraction": Parameter(
            "", "relative error of the clock's rate, fast positive", -0.2, 0.2, scale=0.01, spike=2e-4
        )
    },
    what="The log's clock runs fast or slow: times are counted in samples that are not taken as often as stated.",
    finding=Finding(
        "fraction",
        "the log's clock runs {size} fast",
        "the log's clock runs {size} slow",
        remedy="compare it with a watch over an hour and correct the log; the plan stays as it is",
        in_percent=True,
    ),
    sizes="A crystal keeps time to 0.01 %; oscillators without one, and loops that wait between samples, to 1 to 5 %.",
    confused_with=("depth-scale", "drag-bias", "vertical-current"),
    distinguished_by="The log against a watch; dives whose line takes long to pay out.",
    changes_plan=False,
    follows_law=True,
    instrument=Instrument("the log's clock against a watch for an hour", "fraction", 5e-4, 60.0),
)


@dataclass(frozen=True)
class SensorPosition(DescentEffect):
    """The sensor is `aft` [m] behind the nose: nose down it is higher by as much, though not above the surface."""

    aft: Scalars = 0.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the sensor's depth [m]."""
        return np.maximum(depth - self.aft, np.minimum(depth, 0.0))


SENSOR_POSITION = EffectInfo(
    id="sensor-position",
    effect=SensorPosition,
    parameters={"aft": Parameter("m", "distance of the sensor behind the nose", 0.0, 5.0, scale=0.4, spike=0.01)},
    what="The depth sensor sits in the hull or the tail, and the vehicle goes down nose first.",
    finding=Finding(
        "aft",
        "the depth sensor sits {size} behind the nose",
        remedy="measure where it is and correct the log; the plan stays as it is",
    ),
    sizes="Up to the vehicle's length; never ahead of the nose.",
    confused_with=("clock-offset", "sensor-lag"),
    distinguished_by="A tape measure; dives with anchors of two weights (a delay grows to more depth at more speed).",
    changes_plan=False,
    follows_law=True,
    instrument=Instrument("the sensor's distance from the nose, by tape", "aft", 0.02, 5.0),
)


@dataclass(frozen=True)
class DepthScale(DescentEffect):
    """Reading times ``1 + fraction``."""

    fraction: Scalars = 0.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the depth that the sensor reads [m]."""
        return depth * (1.0 + self.fraction)


DEPTH_SCALE = EffectInfo(
    id="depth-scale",
    effect=DepthScale,
    parameters={
        "fraction": Parameter(
            "", "relative error of the reading, too deep positive", -0.5, 0.5, scale=0.06, spike=0.003
        )
    },
    what="Wrong sensor range, or pressure converted to depth with the wrong density.",
    finding=Finding(
        "fraction",
        "the depth sensor reads {size} too deep",
        "the depth sensor reads {size} too shallow",
        remedy="calibrate it; the plan stays as it is",
        in_percent=True,
    ),
    sizes="Fresh water taken for sea water gives 2.6 %; sensors without calibration are wrong by 1 to 10 %.",
    confused_with=("drag-bias", "vertical-current", "clock-rate"),
    distinguished_by="Readings at a known depth (a lead line, the seafloor at touchdown).",
    changes_plan=False,
    instrument=Instrument("readings at two known depths (a lead line)", "fraction", 0.005, 20.0),
)
