"""Drag coefficient from towing at constant speed, constant and against Reynolds number (Avila et al., sect. 4.1)."""

from collections.abc import Mapping
from dataclasses import dataclass

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
    towing = _Towing.of(data, settings)
    simple, richer = towing.fits()
    fits = preferred_first(simple, richer)
    best = fits[0]["drag_coefficient"]
    at = f" at Re {towing.middle:.2g}" if fits[0] is richer else ""
    compared = _compared(data, settings)
    return TankAnalysis(
        answer=f"The drag coefficient{at} is {best.value:.3f}{best.interval_in_words('.3f')}.",
        fits=fits,
        panels=(towing.coefficient_panel(fits, compared), towing.force_panel(fits[0])),
        remarks=_remarks(towing, simple, richer, compared),
        fragment=_fragment(fits[0], settings, towing.middle),
    )


@dataclass(frozen=True)
class _Compared:
    """Speeds [m/s], Reynolds numbers and drag coefficients of another table, on its own reference area."""

    name: str
    speed: Array
    reynolds: Array
    coefficient: Array


def _compared(data: TankData, settings: DragSettings) -> _Compared | None:
    """The other table, where the data set has one."""
    if data.compared is None or settings.compare is None:
        return None
    speed, force = data.compared["speed_m_s"], data.compared["force_n"]
    area = settings.compare.reference_area or settings.reference_area
    reynolds = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))
    return _Compared(
        settings.compare.name, speed, reynolds, np.asarray(drag_coefficient(force, speed, area, data.density))
    )


@dataclass(frozen=True)
class _Towing:
    """Drag against speed."""

    speed: Array
    force: Array
    """[m/s, N], shape (points,)."""
    force_sd: Array | float | None
    """Stated errors, of all or shape (points,) [N]."""
    area: float
    density: float
    """Reference area and density of the water [m², kg/m³]."""
    reynolds: Array
    coefficients: Array
    """Shape (points,)."""
    middle: float
    """Reynolds number in the middle of the data, two digits."""

    @classmethod
    def of(cls, data: TankData, settings: DragSettings) -> "_Towing":
        speed, force = data.columns["speed_m_s"], data.columns["force_n"]
        if np.any(speed <= 0.0):
            raise RunError("drag coefficient: each row needs a speed above 0")
        reynolds = np.asarray(reynolds_number(speed, settings.reference_length, data.viscosity))
        given = data.columns.get("force_sd_n")  # by row, or else one for all, or none
        return cls(
            speed=speed,
            force=force,
            force_sd=given if given is not None and np.all(given > 0.0) else data.settings.noise.force,
            area=settings.reference_area,
            density=data.density,
            reynolds=reynolds,
            coefficients=np.asarray(drag_coefficient(force, speed, settings.reference_area, data.density)),
            middle=float(f"{np.exp(np.mean(np.log(reynolds))):.2g}"),
        )

    def fits(self) -> tuple[FittedModel, FittedModel]:
        """Fit the constant coefficient, and the power."""
        start = float(np.mean(self.coefficients))
        level = FitParameter("drag_coefficient", "C_D", "", start, low=0.0)
        slope = FitParameter("reynolds_exponent", "p", "", 0.0, low=-2.0, high=2.0)

        def constant(values: Array) -> Array:
            return np.asarray(drag_force(self.speed, values[0], self.area, self.density))

        def power(values: Array) -> Array:
            coefficient = reynolds_drag_coefficient(self.reynolds, values[0], values[1], self.middle)
            return np.asarray(drag_force(self.speed, coefficient, self.area, self.density))

        simple = fit("constant drag coefficient", constant, [level], self.force, self.force_sd)
        name = "drag coefficient against Reynolds number"
        return simple, fit(name, power, [level, slope], self.force, self.force_sd)

    def coefficient_panel(self, fits: tuple[FittedModel, FittedModel], compared: _Compared | None) -> FitPanel:
        """Drag coefficients against Reynolds number, with both fits and the table to compare with."""
        per_force = np.asarray(drag_coefficient(1.0, self.speed, self.area, self.density))
        line = np.geomspace(self.reynolds.min(), self.reynolds.max(), 80)

        def along(fitted: FittedModel) -> Array:
            exponent = fitted["reynolds_exponent"].value if "reynolds_exponent" in fitted else 0.0
            return np.asarray(reynolds_drag_coefficient(line, fitted["drag_coefficient"].value, exponent, self.middle))

        curves = [FitCurve(fitted.name, line, along(fitted)) for fitted in fits]
        if compared is not None:
            curves.append(FitCurve(compared.name, compared.reynolds, compared.coefficient, dots=True))
        return FitPanel(
            name="drag-coefficient",
            x_label="Reynolds number",
            y_label="drag coefficient",
            x=self.reynolds,
            y=self.coefficients,
            y_sd=None if self.force_sd is None else self.force_sd * per_force,
            fitted=fits[0].fitted * per_force,
            curves=tuple(curves),
            alt=f"Measured drag coefficients against Reynolds number with the fit {fits[0].name}.",
        )

    def force_panel(self, best: FittedModel) -> FitPanel:
        """Drag against speed, with the preferred fit."""
        return FitPanel(
            name="drag-force",
            x_label="speed [m/s]",
            y_label="drag [N]",
            x=self.speed,
            y=self.force,
            y_sd=self.force_sd,
            fitted=best.fitted,
            curves=(FitCurve(best.name, self.speed, best.fitted),),
            alt="Measured drag against speed with the preferred fit.",
        )


def _remarks(towing: _Towing, simple: FittedModel, richer: FittedModel, compared: _Compared | None) -> tuple[str, ...]:
    coefficients, above = towing.coefficients, towing.coefficients[towing.reynolds > BLUFF_REYNOLDS]
    means = f"The plain mean of the {len(coefficients)} coefficients is {coefficients.mean():.3f}"
    means += f", of those above Re = 10⁵ {above.mean():.3f}." if 0 < len(above) < len(coefficients) else "."
    remarks = [means]
    if not np.isnan(simple.chi_squared) and not simple.does_not_fit:
        per_degree = simple.chi_squared / simple.degrees_of_freedom
        if per_degree > 1.0:
            sd = simple["drag_coefficient"].sd
            remarks.append(
                "The points scatter more than their stated errors say (chi-squared per degree of freedom "
                f"{per_degree:.1f}): the standard error {sd / simple.widened:.3f} was widened to {sd:.3f}."
            )
    exponent = richer["reynolds_exponent"]
    error = f" ± {exponent.sd:.3f}" if exponent.has_interval else ""
    remarks.append(f"Against the Reynolds number the exponent is {exponent.value:.3f}{error}.")
    if compared is not None:
        remarks.append(_comparison(towing, compared))
    return tuple(remarks)


def _comparison(towing: _Towing, compared: _Compared) -> str:
    """How far the measurement lies from the other table, coefficient by coefficient at the same speeds."""
    shared = [
        (c, o)
        for v, c in zip(towing.speed, towing.coefficients, strict=True)
        for w, o in zip(compared.speed, compared.coefficient, strict=True)
        if v == w
    ]
    if not shared:
        return f"{compared.name} has no speed in common with the measurement."
    here, there = np.array(shared).T
    below, above = 1.0 - here.mean() / there.mean(), there.mean() / here.mean() - 1.0
    words = ("below", "above") if below > 0.0 else ("above", "below")
    return (
        f"The tank's mean coefficient lies {100 * abs(below):.1f} % {words[0]} that of {compared.name} at the same "
        f"speeds ({compared.name} lies {100 * abs(above):.1f} % {words[1]} the tank)."
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
