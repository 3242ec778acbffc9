"""Slow modulation of oscillating currents: amplitude and phase that change over days.

Unresolved neighbours of a tidal constituent (springs and neaps, N2 beside M2), a frequency a little above the inertial
one (Kunze 1985: the vorticity of the flow about it shifts it by some per cent), gusts and decay: all of them multiply
the oscillation by 1 + ε(t), with ε complex and slow (as in complex demodulation, Emery & Thomson 2001). Here ε has a
squared-exponential covariance; its mean over the record belongs to the amplitude and phase, so that a steady
oscillation is not shared with its modulation.

An oscillation of one amplitude and phase may also wander: its complex amplitude as a whole is such a process about
zero. Its size is then inferred from the record, and a weak one is not compared with the usual size of a steady one.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.legs.likelihood.hyperparameters import SLAB_SCALE
from missionplan.effects.oscillation import COHERENCE_TIME, MODULATION
from missionplan.results.learned.evidence import Causes

DAY = 86400.0
MARGIN = 5.0 * DAY
"""How far beyond the record the functions' domain reaches at either end [s]."""
SHORTEST = 1.5 * DAY
"""Least correlation length that the functions resolve [s]."""
MAX_RADIANS = 3.0
"""Functions of more than this many radians in that length have no weight (e^−4.5 of the spectral density at zero)."""
MAX_FUNCTIONS = 48
"""Most functions; a longer record is resolved more coarsely."""
LENGTH_OF_TIME = math.sqrt(2.0 / math.pi)
"""Length of a squared-exponential covariance over the e-folding time of an exponential one of the same integral."""


@dataclass(frozen=True)
class Forms:
    """Oscillations among the causes that are not steady: whose amplitude changes slowly, or wanders about zero."""

    modulated: Causes = ()
    wandering: Causes = ()


STEADY = Forms()


@dataclass(frozen=True)
class Modulation:
    """Functions of time that modulate an oscillation."""

    effect: str
    """The oscillation."""
    frequencies: Array
    """Of the cosines, shape (m,) [rad/s]."""
    span: float
    """Of their domain [s]."""
    wanders_over: Array | None = None
    """Middles of the legs [s] where the oscillation wanders: the functions are those of its whole amplitude, shape
    (n,)."""
    _mean_sd: dict[float, float] = field(default_factory=dict, init=False, repr=False, compare=False)

    def sd(self, relative: float, coherence_time: float) -> Array:
        """Prior standard deviations of the coefficients, real parts then imaginary ones, shape (2m,).

        With them ε has the squared-exponential covariance (Solin & Särkkä 2020, Eq. 20).

        `relative`: standard deviation of the real and of the imaginary part of ε. `coherence_time`: its e-folding time
        [s].
        """
        length = LENGTH_OF_TIME * coherence_time
        density = math.sqrt(2.0 * math.pi) * length * np.exp(-0.5 * (self.frequencies * length) ** 2)
        return np.tile(relative * np.sqrt(2.0 * density / self.span), 2)

    @property
    def keys(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Hyperparameters: relative size, or that of the amplitude over the usual one, and coherence time."""
        return (self.effect, MODULATION if self.wanders_over is None else SLAB_SCALE), (self.effect, COHERENCE_TIME)

    def mean_sd(self, coherence_time: float) -> float:
        """Standard deviation of the mean over the record of an amplitude that wanders with one of 1."""
        if self.wanders_over is None:
            return 1.0
        if coherence_time not in self._mean_sd:
            length, n = LENGTH_OF_TIME * coherence_time, len(self.wanders_over)
            pairs = float(np.exp(-0.5 / length**2 * self._squared_intervals).sum())
            self._mean_sd[coherence_time] = math.sqrt((n + 2.0 * pairs) / n**2)
        return self._mean_sd[coherence_time]

    @cached_property
    def _squared_intervals(self) -> Array:
        """Squared times between the middles of the legs, each pair once, shape (n (n − 1)/2,) [s²]."""
        t = self.wanders_over if self.wanders_over is not None else np.zeros(0)
        first, second = np.triu_indices(len(t), 1)
        return np.asarray(np.square(t[first] - t[second]))


def smooth_functions(effect: str, t: Array) -> tuple[Modulation, Array]:
    """Return cosines on a domain wider than the record, less their means over it, shape (n, m).

    `effect`: the oscillation. `t`, shape (n,): middles of the legs [s].
    """
    start, span = t.min() - MARGIN, float(np.ptp(t)) + 2.0 * MARGIN
    count = min(int(MAX_RADIANS * span / (math.pi * SHORTEST)), MAX_FUNCTIONS)
    frequency = math.pi * np.arange(1, count + 1) / span
    functions = np.cos(frequency * (t - start)[:, None])
    return Modulation(effect, np.asarray(frequency, dtype=float), span), functions - functions.mean(axis=0)


def modulated_columns(functions: Array, in_phase: Array, in_quadrature: Array) -> Array:
    """Columns of Re(ε·w) for an oscillation Re(w), shape (2, n, 2m) [m/s].

    `functions`, shape (n, m): of ε. `in_phase`, `in_quadrature`, shape (2, n): the oscillation, and the same a quarter
    of a period later [m/s].
    """
    return np.concatenate([part[:, :, None] * functions for part in (in_phase, in_quadrature)], axis=2)


def variance_of_mean(t: Array, relative: float, coherence_time: float) -> float:
    """Variance of the mean of ε's real part over the legs: how far a record's amplitude may be from the usual one."""
    length = LENGTH_OF_TIME * coherence_time
    return float(relative**2 * np.mean(np.exp(-0.5 * ((t[:, None] - t) / length) ** 2)))
