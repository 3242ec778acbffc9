"""Harmonic analysis by UTide: which constituents a record holds, with errors, a mean, and what is left."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from missionplan.arrays import Array
from missionplan.physics.water import DAY, angular_frequencies, nodal_state
from missionplan.studies.tide.result import Constituent

_LEAST_SAMPLES = 10


@dataclass(frozen=True)
class ResidualProcess:
    """An Ornstein–Uhlenbeck process."""

    sd: float
    """Of one component [m/s]."""
    time: float
    """After which the correlation has fallen to 1/e [s]."""

    def density(self, frequency: float) -> float:
        """Two-sided spectral density at an angular frequency [m²/s]: 2σ²τ/(1 + ω²τ²)."""
        return 2.0 * self.sd**2 * self.time / (1.0 + (frequency * self.time) ** 2)


def fit_residual(time: Array, east: Array, north: Array) -> ResidualProcess:
    """Fit the process by maximum likelihood, exactly for samples at any times.

    `time`, shape (k,): increasing, of the samples that are there [s]. `east`, `north`, shape (k,): residuals [m/s].
    """
    values = np.stack((east, north))
    spread = math.sqrt(float(np.mean(values**2)))
    if len(time) < _LEAST_SAMPLES or spread == 0.0:
        return ResidualProcess(spread, 0.0)
    steps = np.diff(time)
    shortest, longest = 0.05 * float(np.median(steps)), 0.5 * float(time[-1] - time[0])
    optimum = scipy.optimize.minimize_scalar(
        lambda log_time: _misfit(steps, values, math.exp(log_time))[0],
        bounds=(math.log(shortest), math.log(longest)),
        method="bounded",
    )
    lasting = math.exp(float(optimum.x))
    return ResidualProcess(math.sqrt(_misfit(steps, values, lasting)[1]), lasting)


def _misfit(steps: Array, values: Array, lasting: float) -> tuple[float, float]:
    """Minus twice the log-likelihood, the variance profiled out, and that variance."""
    correlation = np.exp(-steps / lasting)
    left = -np.expm1(-2.0 * steps / lasting)
    innovations = (values[:, 1:] - correlation * values[:, :-1]) ** 2 / left
    count = values.size
    variance = float(np.sum(innovations) + np.sum(values[:, 0] ** 2)) / count
    return count * math.log(variance) + len(values) * float(np.sum(np.log(left))), variance


MAIN = ("M2", "S2", "N2", "K2", "K1", "O1", "P1", "Q1", "M4", "MS4", "MN4", "M6")
"""Constituents that most seas have: the eight of the astronomical tide, and the tides of shallow water."""
LEAST_MAIN = 4.0
"""A main constituent is kept whose squares add up to this many times their variance: one for each of its four numbers,
as in Akaike's criterion."""
FALSE_ALARM = 0.05
"""Probability that any other constituent is kept of a record that holds none of them."""
OUTLIER = 6.0
"""Samples that lie this many robust standard deviations from a first fit are left out."""
INFERRED = {"K2": ("S2", 0.2723), "P1": ("K1", 0.3309)}
"""Constituents that half a year of data is needed for, and what they are inferred from until then: ratio of amplitudes
in the equilibrium tide (Foreman & Henry, 1989, table 1), at the same Greenwich phase."""
HALF_A_YEAR = 182.62 * DAY
"""Beat of K2 and S2, and of P1 and K1 [s]."""
FORTNIGHT = 14.77 * DAY
"""Beat of M2 and S2 [s]."""
SLOW_NODE = 60.0 * DAY
"""Records shorter than this take the nodal corrections of their middle, in a tenth of the time; these change by less
than 1 % on the way [s]."""
_MAD = 1.4826
"""Standard deviation of normal numbers over their median absolute deviation."""
_ROUNDS = 3


@dataclass(frozen=True)
class Samples:
    """What was measured at one depth, gaps left out."""

    time: Array
    """Increasing, since the start of 1970, shape (k,) [s]."""
    velocity: Array
    """East and north, shape (2, k) [m/s]."""
    latitude: float
    """Latitude [rad]."""

    @property
    def lasting(self) -> float:
        """From the first sample to the last [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def covered(self) -> float:
        """Time that the samples stand for, gaps left out [s]."""
        return len(self.time) * float(np.median(np.diff(self.time)))


@dataclass(frozen=True)
class HarmonicFit:
    """Constituents, a mean and what is left."""

    samples: Samples
    """Those that were fitted."""
    constituents: tuple[Constituent, ...]
    """The largest first."""
    mean: Array
    """East and north, shape (2,) [m/s]."""
    residual: ResidualProcess
    """Of the current about the tide and the mean."""

    @property
    def spread(self) -> float:
        """Standard deviation of one component about a forecast, with the fit's own errors [m/s].

        These come in twice: once for what the fit took of the noise into the tide, and once for the forecast.
        """
        fitted = [wave.name for wave in self.constituents if not wave.inferred_from]
        doubt = self.mean_error**2 + float(np.sum(self.coefficient_variance(fitted)))
        return math.sqrt(self.residual.sd**2 + 2.0 * doubt)

    @property
    def mean_error(self) -> float:
        """Standard error of either component of the mean [m/s]."""
        return math.sqrt(self.residual.density(0.0) / self.samples.covered)

    def coefficient_variance(self, names: Sequence[str]) -> Array:
        """Variance of the cosine's and of the sine's coefficient of constituents [m²/s²]: 2P(ω)/T.

        P is the two-sided spectral density of what is left, T the time that the samples stand for.
        """
        return np.array([2.0 * self.residual.density(w) / self.samples.covered for w in _frequencies(names)])


def fit_tide(samples: Samples) -> HarmonicFit:
    """Fit the constituents that a record is long enough to tell apart and that it holds.

    `samples`: at least some days of them.
    """
    candidates = [wave.name for wave in _solve(samples, "auto")[0]]
    fit = _fit(samples, candidates)
    left = samples.velocity - fit.mean[:, None]
    left = left - tidal_velocity(fit.constituents, samples.time, samples.latitude)
    centred = np.abs(left - np.median(left, axis=1, keepdims=True))
    scale = _MAD * np.median(centred, axis=1, keepdims=True)
    good = np.all(centred <= OUTLIER * np.maximum(scale, 1e-6), axis=0)
    samples = Samples(samples.time[good], samples.velocity[:, good], samples.latitude)
    kept = [name for name in candidates if name in MAIN]
    every = _fit(samples, candidates).constituents
    for _ in range(_ROUNDS):
        before, others = kept, max(sum(wave.name not in MAIN for wave in every), 1)
        least = float(scipy.stats.chi2.isf(FALSE_ALARM / others, 4))
        variances = _fit(samples, kept).coefficient_variance([wave.name for wave in every])
        kept = [
            wave.name
            for wave, variance in zip(every, variances, strict=True)
            if wave.major**2 + wave.minor**2 > variance * (LEAST_MAIN if wave.name in MAIN else least)
        ]
        if set(kept) == set(before):
            break
    inferred = {
        name: reference
        for name, (reference, _) in INFERRED.items()
        if reference in kept and name not in kept and FORTNIGHT <= samples.lasting < HALF_A_YEAR
    }
    return _fit(samples, kept, inferred)


def tidal_velocity(waves: Sequence[Constituent], time: Array, latitude: float) -> Array:
    """Predict the tide, the nodal corrections those of each day, shape (2, k) [m/s].

    `time`, shape (k,): since the start of 1970 [s]. `latitude` [rad].
    """
    total = np.zeros((2, len(time)))
    if not waves or not len(time):
        return total
    names = [wave.name for wave in waves]
    days, of_day = np.unique(np.floor(time / DAY), return_inverse=True)
    noons = (days + 0.5) * DAY
    state = nodal_state(names, noons, latitude)
    since_noon = time - noons[of_day]
    parts = zip(waves, state.factor, state.argument + state.angle, _frequencies(names), strict=True)
    for wave, factor, argument, frequency in parts:
        total += factor[of_day] * ellipse_velocity(wave, argument[of_day] + frequency * since_noon)
    return total


def ellipse_velocity(wave: Constituent, argument: Array) -> Array:
    """Velocity of one ellipse when the equilibrium tide has an argument [rad], shape (2, k) [m/s]."""
    along, across = wave.major * np.cos(argument - wave.phase), wave.minor * np.sin(argument - wave.phase)
    sine, cosine = math.sin(wave.toward), math.cos(wave.toward)
    # the minor axis lies 90° counter-clockwise of the major one
    return np.stack((along * sine - across * cosine, along * cosine + across * sine))


def ellipse_errors(major: float, minor: float, variance: float) -> tuple[float, float]:
    """Standard errors of either semi-axis, and of the direction and the phase.

    Linearised about the two rotary components, whose amplitudes are half the sum and half their difference. An
    angle of which nothing is known has the error of a uniform one.

    `major`, `minor` [m/s]. `variance`: of each of the four coefficients [m²/s²].

    Returns
    -------
    tuple of float
        [m/s, rad]
    """
    rotary = [0.5 * (major + minor), 0.5 * (major - minor)]
    most = math.pi / math.sqrt(3.0)
    if min(abs(radius) for radius in rotary) ** 2 <= variance / (8.0 * most**2):
        return math.sqrt(variance), most
    angle = math.sqrt(variance / 8.0 * sum(1.0 / radius**2 for radius in rotary))
    return math.sqrt(variance), min(angle, most)


def _frequencies(names: Sequence[str]) -> Array:
    return angular_frequencies(names) if names else np.zeros(0)


def _fit(samples: Samples, names: Sequence[str], inferred: Mapping[str, str] | None = None) -> HarmonicFit:
    waves, mean = _solve(samples, names, inferred or {})
    left = samples.velocity - mean[:, None] - tidal_velocity(waves, samples.time, samples.latitude)
    bare = HarmonicFit(samples, (), mean, fit_residual(samples.time, *left))
    constituents = []
    for wave, variance in zip(waves, bare.coefficient_variance([wave.name for wave in waves]), strict=True):
        axis, angle = ellipse_errors(wave.major, wave.minor, float(variance))
        if not wave.inferred_from:
            wave = replace(wave, major_error=axis, minor_error=axis, toward_error=angle, phase_error=angle)
        constituents.append(wave)
    largest = sorted(constituents, key=lambda wave: -math.hypot(wave.major, wave.minor))
    return HarmonicFit(samples, tuple(largest), mean, bare.residual)


def _solve(
    samples: Samples, names: Collection[str], inferred: Mapping[str, str] | None = None
) -> tuple[list[Constituent], Array]:
    """Fit by least squares with UTide: the ellipses, and the mean of both components."""
    import utide  # half a second: SciPy's signal processing

    if not names:
        return [], np.mean(samples.velocity, axis=1)
    options: dict[str, object] = {}
    if inferred:
        # given twice, for the two senses of rotation
        options["infer"] = utide.utilities.Bunch(
            inferred_names=list(inferred),
            reference_names=list(inferred.values()),
            amp_ratios=[INFERRED[name][1] for name in inferred] * 2,
            phase_offsets=[0.0] * (2 * len(inferred)),
        )
    fit = utide.solve(
        samples.time / DAY,
        *samples.velocity,
        lat=math.degrees(samples.latitude),
        epoch="1970-01-01",
        constit=names if isinstance(names, str) else [*names, *(inferred or {})],
        trend=False,
        nodal="linear_time" if samples.lasting < SLOW_NODE else True,
        method="ols",
        conf_int="none",
        Rayleigh_min=1.0,
        verbose=False,
        **options,
    )
    columns = zip(map(str, fit["name"]), fit["Lsmaj"], fit["Lsmin"], fit["theta"], fit["g"], strict=True)
    waves = []
    for name, major, minor, inclination, lag in columns:  # an inclination is counter-clockwise from east [deg]
        toward = math.radians(90.0 - float(inclination)) % (2.0 * math.pi)
        turned = toward >= math.pi  # the other end of the major axis is reached half a period later
        phase = (math.radians(float(lag)) + math.pi * turned) % (2.0 * math.pi)
        reference = (inferred or {}).get(name, "")
        ellipse = float(major), float(minor), toward - math.pi * turned, phase
        waves.append(Constituent(name, *ellipse, inferred_from=reference))
    return waves, np.array([fit["umean"], fit["vmean"]], dtype=float)
