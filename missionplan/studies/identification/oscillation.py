"""Added mass and damping from free oscillation on springs (Avila et al., section 4.2)."""

import math
from collections.abc import Mapping

import numpy as np
from scipy.special import ndtri

from missionplan.arrays import Array
from missionplan.datasets.records import listed
from missionplan.datasets.tank import OscillationSettings, TankData
from missionplan.errors import RunError
from missionplan.physics import tank as osc
from missionplan.physics.tank import full_size_mass
from missionplan.studies.identification.fits import (
    INTERVAL,
    FitCurve,
    FitPanel,
    FitParameter,
    FittedModel,
    IdentifiedParameter,
    TankAnalysis,
    fit,
    preferred_first,
    scaled_estimate,
    with_interval,
)

IMPOSSIBLE = 3.0
"""Standard deviations below nil beyond which an added mass is no error of the frequency."""
_HEAVIEST = 1000.0
"""Added mass over the mass above which frequencies or times are in another unit: a plate has some tens."""
_FEWEST = 4
"""Samples of a record that have a frequency at all."""
_MOST_GAPS = 10.0
"""Duration of a record over that of one without gaps: more is no record."""


def identify_oscillation(data: TankData, settings: OscillationSettings) -> TankAnalysis:
    """Find added mass from natural frequencies, or added mass and damping from a record of displacement."""
    return _from_frequencies(data, settings) if "frequency_hz" in data.columns else _from_record(data, settings)


def _from_frequencies(data: TankData, settings: OscillationSettings) -> TankAnalysis:
    """One added mass for each mode; k and m are given, as frequencies determine only k/(m + m_ad)."""
    stiffness, scale = settings.stiffness, settings.scale
    frequency, modes = data.columns["frequency_hz"], data.labels["mode"]
    direct = _added_masses(data, settings)
    estimates, masses = direct.estimates, direct.fitted
    words = ", ".join(f"{mode} {value:.2f} kg" for mode, value in zip(modes, masses, strict=True))
    full_size = tuple(scaled_estimate(f"{e.name}_full_size", e.symbol, "kg", e, scale**3) for e in estimates)
    answer = f"Added mass: {_masses_in_words(modes, estimates)}."
    if scale != 1.0:
        answer = f"Added mass of the vehicle, from a model at 1:{scale:g}: {_masses_in_words(modes, full_size)}."
    unknown = dict.fromkeys(
        mode for mode, estimate in zip(modes, estimates, strict=True) if not math.isfinite(estimate.sd)
    )
    if unknown:
        answer += f" Without a frequency_sd_hz its error is not known: {listed(list(unknown))}."
    panel = FitPanel(
        name="added-masses",
        x_label="",
        y_label="added mass [kg]",
        x=np.arange(len(modes), dtype=float),
        y=masses,
        y_sd=np.array([estimate.sd for estimate in estimates]),
        fitted=masses,
        curves=(),
        alt=f"Added mass of each mode: {words}.",
        ticks=tuple(modes),
    )
    return TankAnalysis(
        answer=answer,
        fits=(direct,),
        panels=(panel,),
        remarks=(
            f"Stiffness {stiffness:g} N/m and mass {settings.mass:g} kg are taken as given: an error of 1 % in the "
            f"stiffness is one of {stiffness / 100 / (2 * math.pi * float(frequency.mean())) ** 2:.2f} kg in the added "
            "mass.",
        ),
        fragment=_fragment(modes, estimates, scale),
        derived=full_size if scale != 1.0 else (),
    )


def _masses_in_words(modes: list[str], estimates: tuple[IdentifiedParameter, ...]) -> str:
    """Write each mode's added mass to two figures of its error, where it has one."""
    words = []
    for mode, estimate in zip(modes, estimates, strict=True):
        has_error = math.isfinite(estimate.sd) and estimate.sd > 0.0
        decimals = max(0, 1 - math.floor(math.log10(estimate.sd))) if has_error else 0
        value = f"{estimate.value:.{decimals}f} ± {estimate.sd:.{decimals}f}" if has_error else f"{estimate.value:.4g}"
        words.append(f"{mode} {value} kg")
    return ", ".join(words)


def _added_masses(data: TankData, settings: OscillationSettings) -> FittedModel:
    """Added mass of each mode from its frequency, with the error of the frequency.

    Raises RunError as `_check_masses` does.
    """
    frequency = data.columns["frequency_hz"]
    frequency_sd = data.columns.get("frequency_sd_hz", np.full_like(frequency, np.nan))
    added = np.asarray(osc.added_mass(frequency, settings.stiffness, settings.mass))
    added_sd = np.asarray(osc.added_mass_sd(frequency, frequency_sd, settings.stiffness))
    _check_masses(data.labels["mode"], added, added_sd, settings)
    quantile = float(ndtri(0.5 + INTERVAL / 2.0))
    estimates = tuple(
        with_interval(f"added_mass_{mode}", f"m_ad {mode}", "kg", float(mass), float(sd), quantile)
        for mode, mass, sd in zip(data.labels["mode"], added, added_sd, strict=True)
    )
    return FittedModel(
        name="added mass from each frequency",
        estimates=estimates,
        chi_squared=math.nan,
        degrees_of_freedom=0,
        does_not_fit=False,
        widened=1.0,
        fitted=added,
        residual_sd=math.nan,
        covariance=np.diag(added_sd**2),
    )


def _check_masses(modes: list[str], added: Array, sd: Array, settings: OscillationSettings) -> None:
    """Raise RunError when an added mass is negative beyond its error, or many times the mass."""
    air = math.sqrt(settings.stiffness / settings.mass) / (2.0 * math.pi)
    negative = added + IMPOSSIBLE * np.nan_to_num(sd) < 0.0
    for wrong, what in ((negative, "negative"), (added > _HEAVIEST * settings.mass, f"over {_HEAVIEST:g} masses")):
        if wrong.any():
            words = f"the added mass of {listed(np.array(modes)[wrong].tolist())} would be {what}"
            raise RunError(
                f"{words}: without water the frequency is {air:.3g} Hz; is it right, and stiffness and mass?"
            )


def _fragment(modes: list[str], estimates: tuple[IdentifiedParameter, ...], scale: float) -> Mapping[str, object]:
    """The vehicle's `added_mass:`, at full size."""
    masses: dict[str, object] = {}
    for mode, estimate in zip(modes, estimates, strict=True):
        mean = f"{float(full_size_mass(estimate.value, scale)):.5g} kg"
        sd = float(full_size_mass(estimate.sd, scale))
        masses[mode] = {"mean": mean, "sd": f"{sd:.3g} kg"} if math.isfinite(sd) else mean
    return {"added_mass": masses}


def _from_record(data: TankData, settings: OscillationSettings) -> TankAnalysis:
    """Fit a decaying oscillation with linear, then linear and quadratic damping, to a record of displacement."""
    time, record = data.columns["t_s"], data.columns["displacement_m"]
    record_sd = settings.noise.displacement
    parameters = starting_values(time, record)

    def swing(values: Array) -> Array:
        f, start, velocity, offset, delta, *beta = values
        return np.asarray(offset + osc.displacement(time, start, velocity, f, delta, beta[0] if beta else 0.0))

    quadratic = FitParameter("quadratic_rate", "β", "1/m", 0.1 / (float(np.ptp(record)) / 2.0), low=0.0)
    simple = fit("linear damping", swing, parameters, record, record_sd, in_sequence=True)
    richer = fit("linear and quadratic damping", swing, [*parameters, quadratic], record, record_sd, in_sequence=True)
    fits = preferred_first(simple, richer)
    best, widened = fits[0], fits[0].widened
    physical = _physical(best, settings.stiffness, settings.mass)
    _check_masses(["surge"], np.array([physical[0].value]), np.array([physical[0].sd]), settings)
    remark = (
        f"Errors were widened {widened:.1f} times for scatter beyond the stated noise and for residuals "
        "that follow one another."
    )
    panel = FitPanel(
        name="displacement",
        x_label="time [s]",
        y_label="displacement [m]",
        x=time,
        y=record,
        y_sd=record_sd,
        fitted=best.fitted,
        curves=(FitCurve(best.name, time, best.fitted),),
        alt=f"Displacement against time with the fit {best.name}.",
    )
    return TankAnalysis(
        answer=f"The added mass is {physical[0].in_words}.",
        fits=fits,
        panels=(panel,),
        remarks=(remark,) if widened > 1.05 and not best.does_not_fit else (),
        fragment=_fragment(["surge"], physical[:1], settings.scale),
        derived=physical,
    )


def starting_values(time: Array, record: Array) -> list[FitParameter]:
    """Starting values: the strongest frequency of the record, its first sample and its mean.

    The frequency is the peak of a discrete Fourier transform with a Hann window, padded with zeros (Harris 1978, Proc.
    IEEE 66, 51–83).
    """
    if len(time) < _FEWEST or not np.all(np.diff(time) > 0.0) or not 0.0 < np.ptp(record) < np.inf:
        message = f"a record of an oscillation needs {_FEWEST} samples in the order of time, not all the same"
        raise RunError(message)
    step = float(np.median(np.diff(time)))
    if np.ptp(time) > _MOST_GAPS * len(time) * step:
        raise RunError("the record of the oscillation has gaps far longer than its samples are apart")
    even = np.arange(time[0], time[-1], step)
    spectrum = np.abs(
        np.fft.rfft((np.interp(even, time, record) - record.mean()) * np.hanning(len(even)), 8 * len(even))
    )
    frequency = float(np.fft.rfftfreq(8 * len(even), step)[np.argmax(spectrum)])
    if frequency == 0.0:
        raise RunError("the record drifts, but does not oscillate: its strongest frequency is nil")
    velocity = float((record[1] - record[0]) / (time[1] - time[0]))
    half = len(record) // 2
    decay = math.log(max(float(np.std(record[:half]) / np.std(record[half:])), 1.0)) / (float(time[-1] - time[0]) / 2.0)
    return [
        FitParameter("frequency", "f", "Hz", frequency, low=0.0, high=max(0.5 / step, 2.0 * frequency)),
        FitParameter("start", "x₀", "m", float(record[0] - record.mean())),
        FitParameter("start_velocity", "v₀", "m/s", velocity),
        FitParameter("offset", "x̄", "m", float(record.mean())),
        FitParameter("linear_rate", "δ", "1/s", max(decay, 1e-3), low=0.0),
    ]


def _physical(best: FittedModel, stiffness: float, mass: float) -> tuple[IdentifiedParameter, ...]:
    """Added mass [kg] and damping [kg/s, kg/m] from the fitted rates, with their errors."""
    frequency = best["frequency"]
    total = stiffness / (2.0 * math.pi * frequency.value) ** 2
    slope = -2.0 * total / frequency.value
    shifted = scaled_estimate("added_mass", "m_ad", "kg", frequency, slope, total - mass - slope * frequency.value)
    estimates = [shifted, scaled_estimate("linear_damping", "b", "kg/s", best["linear_rate"], 2.0 * total)]
    if "quadratic_rate" in best:
        estimates.append(scaled_estimate("quadratic_damping", "c", "kg/m", best["quadratic_rate"], total))
    return tuple(estimates)
