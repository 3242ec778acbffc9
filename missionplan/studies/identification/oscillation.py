"""Added mass and damping from free oscillation on springs (Avila et al., section 4.2)."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy import stats

from missionplan.arrays import Array
from missionplan.datasets.tank import OscillationSettings, TankData
from missionplan.physics import oscillation as osc
from missionplan.physics.tank import full_size_mass
from missionplan.results.identification import FitCurve, FitPanel, FittedModel, IdentifiedParameter, TankAnalysis
from missionplan.studies.identification.least_squares import INTERVAL, Parameter, adds_something, derived, fit


def identify_oscillation(data: TankData) -> TankAnalysis:
    """Find added mass from natural frequencies, or added mass and damping from a record of displacement."""
    return _from_frequencies(data) if "frequency_hz" in data.columns else _from_record(data)


def _given(data: TankData) -> tuple[float, float, float]:
    """Stiffness [N/m], mass in air [kg] and scale."""
    settings = data.settings
    assert isinstance(settings, OscillationSettings)
    assert settings.stiffness is not None
    assert settings.mass is not None
    return settings.stiffness, settings.mass, settings.scale


def _from_frequencies(data: TankData) -> TankAnalysis:
    """One added mass for each mode; k and m are given, as frequencies alone hold only k/(m + m_ad)."""
    stiffness, mass, scale = _given(data)
    frequency, modes = data.columns["frequency_hz"], data.labels["mode"]
    frequency_sd = data.columns.get("frequency_sd_hz", np.full_like(frequency, np.nan))
    added = np.asarray(osc.added_mass(frequency, stiffness, mass))
    added_sd = np.asarray(osc.added_mass_sd(frequency, frequency_sd, stiffness))
    reach = float(stats.norm.ppf(0.5 + INTERVAL / 2.0))
    estimates = tuple(
        IdentifiedParameter(
            f"added_mass_{mode}", f"m_ad {mode}", float(m), float(s), float(m - reach * s), float(m + reach * s), "kg"
        )
        for mode, m, s in zip(modes, added, added_sd, strict=True)
    )
    direct = FittedModel(
        "added mass from each frequency", estimates, math.nan, 0, 1.0, added, math.nan, np.diag(added_sd**2)
    )
    place = np.arange(len(modes), dtype=float)
    full = tuple(derived(f"{e.name}_full_size", e.symbol, "kg", e, scale**3) for e in estimates) if scale != 1.0 else ()
    words = ", ".join(f"{mode} {value:.2f} kg" for mode, value in zip(modes, added, strict=True))
    return TankAnalysis(
        answer=f"Added mass: {words}.",
        fits=(direct,),
        panels=(
            FitPanel(
                "added-mass",
                "",
                "added mass [kg]",
                place,
                added,
                added_sd,
                added,
                (),
                f"Added mass of each mode: {words}.",
                tuple(modes),
            ),
        ),
        remarks=(
            f"Stiffness {stiffness:g} N/m and mass {mass:g} kg are taken as given: an error of 1 % in the stiffness is "
            f"one of {stiffness / 100 / (2 * math.pi * float(frequency.mean())) ** 2:.2f} kg in the added mass.",
        ),
        fragment=_fragment(modes, estimates, scale),
        derived=full,
    )


def _fragment(modes: list[str], estimates: tuple[IdentifiedParameter, ...], scale: float) -> Mapping[str, Any]:
    """Write the vehicle's `added_mass:`, at full size."""
    masses: dict[str, Any] = {}
    for mode, estimate in zip(modes, estimates, strict=True):
        mean = f"{float(full_size_mass(estimate.value, scale)):.5g} kg"
        sd = float(full_size_mass(estimate.sd, scale))
        masses[mode] = {"mean": mean, "sd": f"{sd:.3g} kg"} if math.isfinite(sd) else mean
    return {"added_mass": masses}


def _from_record(data: TankData) -> TankAnalysis:
    """Fit a decaying oscillation with linear, then linear and quadratic damping, to a record of displacement."""
    stiffness, mass, scale = _given(data)
    time, record = data.columns["t_s"], data.columns["displacement_m"]
    noise = data.settings.noise.displacement
    record_sd = None if noise is None else np.full_like(record, noise)
    parameters = starting_values(time, record)

    def linear(values: Array) -> Array:
        f, start, velocity, offset, delta = values
        return np.asarray(offset + osc.displacement(time, start, velocity, f, delta, 0.0))

    def both(values: Array) -> Array:
        f, start, velocity, offset, delta, beta = values
        return np.asarray(offset + osc.displacement(time, start, velocity, f, delta, beta))

    amplitude = float(np.ptp(record)) / 2.0
    quadratic = Parameter("quadratic_rate", "β", "1/m", 0.1 / amplitude, low=0.0)
    simple = fit("linear damping", linear, parameters, record, record_sd, in_sequence=True)
    richer = fit("linear and quadratic damping", both, [*parameters, quadratic], record, record_sd, in_sequence=True)
    fits = (richer, simple) if adds_something(simple, richer) else (simple, richer)
    found = _physical(fits[0], stiffness, mass)
    added = found[0]
    return TankAnalysis(
        answer=f"The added mass is {added.value:.3g} kg (90 % interval {added.low:.3g} to {added.high:.3g} kg).",
        fits=fits,
        panels=(_record_panel(time, record, record_sd, fits),),
        remarks=(
            f"Errors were widened {fits[0].widened:.1f} times for scatter beyond the stated noise and for residuals "
            "that follow one another.",
        )
        if fits[0].widened > 1.05
        else (),
        fragment=_fragment(["surge"], (added,), scale),
        derived=found,
    )


def starting_values(time: Array, record: Array) -> list[Parameter]:
    """Starting values: the strongest frequency of the record, its first sample and its mean."""
    step = float(np.median(np.diff(time)))
    even = np.arange(time[0], time[-1], step)
    spectrum = np.abs(
        np.fft.rfft((np.interp(even, time, record) - record.mean()) * np.hanning(len(even)), 8 * len(even))
    )
    frequency = float(np.fft.rfftfreq(8 * len(even), step)[np.argmax(spectrum)])
    velocity = float((record[1] - record[0]) / (time[1] - time[0]))
    half = len(record) // 2
    decay = math.log(max(float(np.std(record[:half]) / np.std(record[half:])), 1.0)) / (float(time[-1] - time[0]) / 2.0)
    return [
        Parameter("frequency", "f", "Hz", frequency, low=0.0),
        Parameter("start", "x₀", "m", float(record[0] - record.mean())),
        Parameter("start_velocity", "v₀", "m/s", velocity),
        Parameter("offset", "x̄", "m", float(record.mean())),
        Parameter("linear_rate", "δ", "1/s", max(decay, 1e-3), low=0.0),
    ]


def _physical(best: FittedModel, stiffness: float, mass: float) -> tuple[IdentifiedParameter, ...]:
    """Added mass [kg] and damping [kg/s, kg/m] from the fitted rates, with their errors."""
    frequency = best["frequency"]
    total = stiffness / (2.0 * math.pi * frequency.value) ** 2
    slope = -2.0 * total / frequency.value
    shifted = derived("added_mass", "m_ad", "kg", frequency, slope, total - mass - slope * frequency.value)
    found = [shifted, derived("linear_damping", "b", "kg/s", best["linear_rate"], 2.0 * total)]
    if "quadratic_rate" in best:
        found.append(derived("quadratic_damping", "c", "kg/m", best["quadratic_rate"], total))
    return tuple(found)


def _record_panel(time: Array, record: Array, record_sd: Array | None, fits: tuple[FittedModel, ...]) -> FitPanel:
    sd = np.full_like(record, np.nan) if record_sd is None else record_sd
    return FitPanel(
        "displacement",
        "time [s]",
        "displacement [m]",
        time,
        record,
        sd,
        fits[0].fitted,
        (FitCurve(fits[0].name, time, fits[0].fitted),),
        f"Displacement against time with the fit {fits[0].name}.",
    )
