"""Drag coefficient from towing at constant speed, constant and against Reynolds number (Avila et al., sect. 4.1)."""

from collections.abc import Mapping, Sequence

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.tank import DragSettings, TankData
from missionplan.errors import RunError
from missionplan.physics.drag import drag_force, reynolds_number
from missionplan.physics.tank import drag_coefficient, reynolds_drag_coefficient
from missionplan.studies.identification.fits import (
    FitCurve,
    FitPanel,
    FitParameter,
    FittedModel,
    TankAnalysis,
    fit,
    preferred_first,
)

BLUFF_REYNOLDS = 1e5
"""Reynolds number above which Avila et al. call the coefficients constant."""


def identify_drag(data: TankData, settings: DragSettings) -> TankAnalysis:
    """Fit a constant drag coefficient and a power of the Reynolds number to drag against speed.

    `data`: of kind drag: speed, force and, where known, its standard deviation. `settings`: the data's.

    Returns
    -------
    TankAnalysis
        The preferred fit first: the power only where an F test at 1 % prefers it.
    """
    speed, force = data.columns["speed_m_s"], data.columns["force_n"]
    if np.any(speed <= 0.0):
        raise RunError("drag coefficient: each row needs a speed above 0")
    area, density = settings.reference_area, data.density
    reynolds = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))
    coefficients = np.asarray(drag_coefficient(force, speed, area, density))
    middle = float(f"{np.exp(np.mean(np.log(reynolds))):.2g}")
    by_row = data.columns.get("force_sd_n")  # else one for all, or none
    force_sd = by_row if by_row is not None and np.all(by_row > 0.0) else data.settings.noise.force
    simple, richer = _fits(data, settings, force_sd, coefficients, middle)
    fits = preferred_first(simple, richer)
    best, per_force = fits[0], np.asarray(drag_coefficient(1.0, speed, area, density))
    compared, coefficient = _compared(data, settings), best["drag_coefficient"]
    at = f" at Re {middle:.2g}" if best is richer else ""
    return TankAnalysis(
        answer=f"The drag coefficient{at} is {coefficient.in_words}.",
        fits=fits,
        panels=(
            FitPanel(
                name="drag-coefficient",
                x_label="Reynolds number",
                y_label="drag coefficient",
                x=reynolds,
                y=coefficients,
                y_sd=None if force_sd is None else force_sd * per_force,
                fitted=best.fitted * per_force,
                curves=(*_curves(fits, reynolds, middle), *compared),
                alt=f"Measured drag coefficients against Reynolds number with the fit {best.name}.",
            ),
            FitPanel(
                name="drag-force",
                x_label="speed [m/s]",
                y_label="drag [N]",
                x=speed,
                y=force,
                y_sd=force_sd,
                fitted=best.fitted,
                curves=(FitCurve(best.name, speed, best.fitted),),
                alt="Measured drag against speed with the preferred fit.",
            ),
        ),
        remarks=_remarks(reynolds, coefficients, simple, richer, *(_beside(data, coefficients, c) for c in compared)),
        fragment=_fragment(best, settings, middle),
    )


def _fits(
    data: TankData, settings: DragSettings, force_sd: Array | float | None, coefficients: Array, middle: float
) -> tuple[FittedModel, FittedModel]:
    """Fit the constant coefficient, and the power of the Reynolds number about one in the middle of the data."""
    speed, force, area = data.columns["speed_m_s"], data.columns["force_n"], settings.reference_area
    reynolds = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))

    def constant(values: Array) -> Array:
        return np.asarray(drag_force(speed, values[0], area, data.density))

    def power(values: Array) -> Array:
        coefficient = reynolds_drag_coefficient(reynolds, values[0], values[1], middle)
        return np.asarray(drag_force(speed, coefficient, area, data.density))

    level = FitParameter("drag_coefficient", "C_D", "", float(np.mean(coefficients)), low=0.0)
    slope = FitParameter("reynolds_exponent", "p", "", 0.0, low=-2.0, high=2.0)
    simple = fit("constant drag coefficient", constant, [level], force, force_sd)
    return simple, fit("drag coefficient against Reynolds number", power, [level, slope], force, force_sd)


def _curves(fits: Sequence[FittedModel], reynolds: Array, middle: float) -> list[FitCurve]:
    """Drag coefficients of the fits against Reynolds number."""
    line, curves = np.geomspace(reynolds.min(), reynolds.max(), 80), []
    for fitted in fits:
        exponent = fitted["reynolds_exponent"].value if "reynolds_exponent" in fitted else 0.0
        along = reynolds_drag_coefficient(line, fitted["drag_coefficient"].value, exponent, middle)
        curves.append(FitCurve(fitted.name, line, np.asarray(along)))
    return curves


def _compared(data: TankData, settings: DragSettings) -> list[FitCurve]:
    """Drag coefficients of the other table, on its own reference area, where the data set has one."""
    if data.compared is None or settings.compare is None:
        return []
    speed, area = data.compared["speed_m_s"], settings.compare.reference_area or settings.reference_area
    reynolds = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))
    coefficient = np.asarray(drag_coefficient(data.compared["force_n"], speed, area, data.density))
    return [FitCurve(settings.compare.name, reynolds, coefficient, dots=True)]


def _remarks(
    reynolds: Array, coefficients: Array, simple: FittedModel, richer: FittedModel, *more: str
) -> tuple[str, ...]:
    above = coefficients[reynolds > BLUFF_REYNOLDS]
    means = f"The plain mean of the {len(coefficients)} coefficients is {coefficients.mean():.3f}"
    means += f", of those above Re = 10⁵ {above.mean():.3f}." if 0 < len(above) < len(coefficients) else "."
    remarks, per_degree = [means], simple.chi_squared / simple.degrees_of_freedom
    if per_degree > 1.0 and not simple.does_not_fit:  # nan where no errors were stated
        sd = simple["drag_coefficient"].sd
        remarks.append(
            "The points scatter more than their stated errors say (chi-squared per degree of freedom "
            f"{per_degree:.1f}): the standard error {sd / simple.widened:.3f} was widened to {sd:.3f}."
        )
    exponent = richer["reynolds_exponent"]
    error = f" ± {exponent.sd:.3f}" if exponent.has_interval else ""
    return (*remarks, f"Against the Reynolds number the exponent is {exponent.value:.3f}{error}.", *more)


def _beside(data: TankData, coefficients: Array, compared: FitCurve) -> str:
    """How far the measurement lies from the other table, coefficient by coefficient at the same speeds."""
    shared = [
        (c, o)
        for v, c in zip(data.columns["speed_m_s"], coefficients, strict=True)
        for w, o in zip((data.compared or {})["speed_m_s"], compared.y, strict=True)
        if v == w
    ]
    if not shared:
        return f"{compared.label} has no speed in common with the measurement."
    here, there = np.array(shared).T
    below, above = 1.0 - here.mean() / there.mean(), there.mean() / here.mean() - 1.0
    words = ("below", "above") if below > 0.0 else ("above", "below")
    return (
        f"The tank's mean coefficient lies {100 * abs(below):.1f} % {words[0]} that of {compared.label} at the same "
        f"speeds ({compared.label} lies {100 * abs(above):.1f} % {words[1]} the tank)."
    )


def _fragment(best: FittedModel, settings: DragSettings, middle: float) -> Mapping[str, object]:
    """The vehicle's `drag:`, at full size where the data set is of a model."""
    coefficient = best["drag_coefficient"]
    drag: dict[str, object] = {
        "coefficient": {"mean": round(coefficient.value, 4), "sd": round(coefficient.sd, 4)},
        "area": f"{settings.reference_area * settings.scale**2:.6g} m^2",
    }
    if "reynolds_exponent" in best:
        exponent = best["reynolds_exponent"]
        drag["exponent"] = {"mean": round(exponent.value, 4), "sd": round(exponent.sd, 4)}
        drag["at_reynolds"] = middle
        drag["length"] = f"{settings.reference_length * settings.scale:.6g} m"
    return {"drag": drag}
