"""Drag coefficient from towing at constant speed, constant and against Reynolds number (Avila et al., sect. 4.1)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.tank import DragSettings, TankData
from missionplan.physics.drag import drag_force, reynolds_number
from missionplan.physics.tank import drag_coefficient, reynolds_drag_coefficient
from missionplan.results.identification import FitCurve, FitPanel, FittedModel, TankAnalysis
from missionplan.studies.identification.least_squares import Parameter, adds_something, fit

BLUFF_REYNOLDS = 1e5
"""Reynolds number above which Avila et al. call the coefficients constant."""


def identify_drag(data: TankData) -> TankAnalysis:
    """Fit a constant drag coefficient and a power of the Reynolds number to drag against speed.

    Parameters
    ----------
    data : TankData
        Of kind drag: speed, force and, where known, its standard deviation.

    Returns
    -------
    TankAnalysis
        The preferred fit first: the power only where an F test at 1 % asks for it.
    """
    settings = data.settings
    assert isinstance(settings, DragSettings)
    speed, force = data.columns["speed_m_s"], data.columns["force_n"]
    area, density = settings.reference_area, data.density
    reynolds = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))
    middle = float(f"{np.exp(np.mean(np.log(reynolds))):.2g}")
    force_sd = _force_sd(data, len(force))
    coefficients = np.asarray(drag_coefficient(force, speed, area, density))
    start = float(np.mean(coefficients))
    level = Parameter("drag_coefficient", "C_D", "", start, low=0.0)
    slope = Parameter("reynolds_exponent", "p", "", 0.0, low=-2.0, high=2.0)

    def constant(values: Array) -> Array:
        return np.asarray(drag_force(speed, values[0], area, density))

    def power(values: Array) -> Array:
        return np.asarray(
            drag_force(speed, reynolds_drag_coefficient(reynolds, values[0], values[1], middle), area, density)
        )

    simple = fit("constant drag coefficient", constant, [level], force, force_sd)
    richer = fit("drag coefficient against Reynolds number", power, [level, slope], force, force_sd)
    wins = adds_something(simple, richer)
    fits = (richer, simple) if wins else (simple, richer)
    best = fits[0]
    value, uncertainty = (
        best["drag_coefficient"],
        f"{best['drag_coefficient'].low:.3f} to {best['drag_coefficient'].high:.3f}",
    )
    at = f" at Re {middle:.2g}" if wins else ""
    return TankAnalysis(
        answer=f"The drag coefficient{at} is {value.value:.3f} (90 % interval {uncertainty}).",
        fits=fits,
        panels=(
            _coefficient_panel(data, fits, reynolds, coefficients, force_sd, middle),
            _force_panel(speed, force, force_sd, best),
        ),
        remarks=_remarks(data, simple, richer, reynolds, coefficients),
        fragment=_fragment(best, settings, middle),
    )


def _force_sd(data: TankData, points: int) -> Array | None:
    """Stated errors of the forces: by row, or one for all, or none."""
    given = data.columns.get("force_sd_n")
    noise = data.settings.noise.force
    if given is None or np.any(np.isnan(given)) or np.any(given <= 0.0):
        return None if noise is None else np.full(points, noise)
    return given


def _coefficient_panel(
    data: TankData,
    fits: tuple[FittedModel, FittedModel],
    reynolds: Array,
    coefficients: Array,
    force_sd: Array | None,
    middle: float,
) -> FitPanel:
    settings = data.settings
    assert isinstance(settings, DragSettings)
    per_force = coefficients / data.columns["force_n"]
    line = np.geomspace(reynolds.min(), reynolds.max(), 80)

    def along(fitted: FittedModel) -> Array:
        exponent = fitted["reynolds_exponent"].value if "reynolds_exponent" in fitted else 0.0
        return np.asarray(reynolds_drag_coefficient(line, fitted["drag_coefficient"].value, exponent, middle))

    curves = [FitCurve(fitted.name, line, along(fitted)) for fitted in fits]
    if data.compared is not None and settings.compare is not None:
        speed, other = _compared(data, settings)
        at = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))
        curves.append(FitCurve(settings.compare.name, at, other, dots=True))
    return FitPanel(
        name="drag-coefficient",
        x_label="Reynolds number",
        y_label="drag coefficient",
        x=reynolds,
        y=coefficients,
        y_sd=force_sd * per_force if force_sd is not None else np.full_like(coefficients, np.nan),
        fitted=fits[0].fitted * per_force,
        curves=tuple(curves),
        alt=f"Measured drag coefficients against Reynolds number with the fit {fits[0].name}.",
    )


def _force_panel(speed: Array, force: Array, force_sd: Array | None, best: FittedModel) -> FitPanel:
    return FitPanel(
        name="drag-force",
        x_label="speed [m/s]",
        y_label="drag [N]",
        x=speed,
        y=force,
        y_sd=force_sd if force_sd is not None else np.full_like(force, np.nan),
        fitted=best.fitted,
        curves=(FitCurve(best.name, speed, best.fitted),),
        alt="Measured drag against speed with the preferred fit.",
    )


def _remarks(
    data: TankData, simple: FittedModel, richer: FittedModel, reynolds: Array, coefficients: Array
) -> tuple[str, ...]:
    above = coefficients[reynolds > BLUFF_REYNOLDS]
    means = f"The plain mean of the {len(coefficients)} coefficients is {coefficients.mean():.3f}"
    means += f", of those above Re 1e5 {above.mean():.3f}." if 0 < len(above) < len(coefficients) else "."
    remarks = [means]
    if not np.isnan(simple.chi_squared):
        per_degree = simple.chi_squared / simple.degrees_of_freedom
        if per_degree > 1.0:
            sd = simple["drag_coefficient"].sd
            remarks.append(
                "The points scatter more than their stated errors say (chi-squared per degree of freedom "
                f"{per_degree:.1f}): the standard error {sd / simple.widened:.3f} was widened to {sd:.3f}."
            )
    exponent = richer["reynolds_exponent"]
    remarks.append(f"Against the Reynolds number the exponent is {exponent.value:.3f} ± {exponent.sd:.3f}.")
    settings = data.settings
    assert isinstance(settings, DragSettings)
    if data.compared is not None and settings.compare is not None:
        remarks.append(_comparison(data, settings, coefficients))
    return tuple(remarks)


def _compared(data: TankData, settings: DragSettings) -> tuple[Array, Array]:
    """Speeds [m/s] and drag coefficients of the other table, on its own reference area."""
    assert data.compared is not None
    assert settings.compare is not None
    speed, force = data.compared["speed_m_s"], data.compared["force_n"]
    area = settings.compare.reference_area or settings.reference_area
    return speed, np.asarray(drag_coefficient(force, speed, area, data.density))


def _comparison(data: TankData, settings: DragSettings, coefficients: Array) -> str:
    """How far the measurement lies from the other table, coefficient by coefficient at the same speeds."""
    assert settings.compare is not None
    speed, other = _compared(data, settings)
    shared = [
        (c, o)
        for v, c in zip(data.columns["speed_m_s"], coefficients, strict=True)
        for w, o in zip(speed, other, strict=True)
        if v == w
    ]
    if not shared:
        return f"{settings.compare.name} has no speed in common with the measurement."
    here, there = np.array(shared).T
    below, above = 1.0 - here.mean() / there.mean(), there.mean() / here.mean() - 1.0
    words = ("below", "above") if below > 0.0 else ("above", "below")
    name = settings.compare.name
    return (
        f"The tank's mean coefficient lies {100 * abs(below):.1f} % {words[0]} that of {name} at the same "
        f"speeds ({name} lies {100 * abs(above):.1f} % {words[1]} the tank)."
    )


def _fragment(best: FittedModel, settings: DragSettings, middle: float) -> Mapping[str, Any]:
    """Write the vehicle's `drag:`, at full size where the data set is of a model."""
    value = best["drag_coefficient"]
    drag: dict[str, Any] = {
        "coefficient": {"mean": round(value.value, 4), "sd": round(value.sd, 4)},
        "area": f"{settings.reference_area * settings.scale**2:.6g} m^2",
    }
    if "reynolds_exponent" in best:
        exponent = best["reynolds_exponent"]
        drag["exponent"] = {"mean": round(exponent.value, 4), "sd": round(exponent.sd, 4)}
        drag["at_reynolds"] = middle
        drag["length"] = f"{settings.reference_length * settings.scale:.6g} m"
    return {"drag": drag}
