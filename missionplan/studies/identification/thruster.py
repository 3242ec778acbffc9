"""Static thrust of a thruster (Avila et al.), or what forward speed leaves of a tunnel thruster's (Palmer et al.)."""

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.tank import TankData, ThrusterSettings
from missionplan.errors import RunError
from missionplan.physics.thruster import bollard_pull
from missionplan.results.learned.identification import FitCurve, FitPanel, FittedModel, TankAnalysis
from missionplan.studies.identification.least_squares import FitParameter, f_test_prefers, fit
from missionplan.studies.identification.tunnel_thruster import identify_tunnel_thruster

_RATE_REMARK = (
    "A vehicle file carries thrust against shaft rate as `thrust_constant` of a tunnel thruster, with its `decay`: "
    "give `geometry` and measure under way."
)
AT_REST = 0.01
"""Speeds below this count as bollard pull [m/s]."""


def identify_thruster(data: TankData, settings: ThrusterSettings) -> TankAnalysis:
    """Fit static thrust with its deadband, or a tunnel thruster under way where speeds and a geometry are given."""
    speed = data.columns.get("speed_m_s", np.zeros_like(data.columns["thrust_n"]))
    if np.any(speed > AT_REST) and settings.geometry is not None and "rpm" in data.columns:
        return identify_tunnel_thruster(data, settings, settings.geometry, speed)
    return _static(data, speed <= AT_REST)


def _static(data: TankData, at_rest: NDArray[np.bool_]) -> TankAnalysis:
    """Fit τ = c(|V| - V₀)² with a constant for each direction, without and with the deadband V₀."""
    name, unit = ("voltage_v", "V") if "voltage_v" in data.columns else ("rpm", "1/s")
    command = data.columns[name][at_rest] / (1.0 if unit == "V" else 60.0)
    thrust = data.columns["thrust_n"][at_rest]
    if not np.any(command):
        raise RunError(f"thrust: no row at rest has a {name} other than 0")
    noise = data.settings.noise.thrust
    thrust_sd = None if noise is None else np.full_like(thrust, noise)
    simple, richer = _static_fits(command, thrust, thrust_sd, unit)
    fits = (richer, simple) if f_test_prefers(simple, richer) else (simple, richer)
    return TankAnalysis(
        answer=_constants_in_words(fits[0]),
        fits=fits,
        panels=(_static_panel(command, thrust, thrust_sd, fits[0], unit),),
        remarks=_asymmetry(fits[0]) + (() if unit == "V" else (_RATE_REMARK,)),
        fragment={"thrusters": [_static_fragment(fits[0])]} if unit == "V" else {},
    )


def _static_fits(command: Array, thrust: Array, thrust_sd: Array | None, unit: str) -> tuple[FittedModel, FittedModel]:
    """Fit the constants of the directions that were measured, without and with the deadband."""
    squared = "N/V^2" if unit == "V" else "N*s^2"
    sides = [("ahead", command > 0.0), ("astern", command < 0.0)]
    parameters = [
        FitParameter(side, f"c {side}", squared, float(np.sum(np.abs(thrust[m])) / np.sum(command[m] ** 2)), low=0.0)
        for side, m in sides
        if np.any(m)
    ]
    largest = float(np.abs(command).max())
    deadband = FitParameter("deadband", "V₀", unit, 0.02 * largest, 0.0, largest)

    def constants(values: Array) -> tuple[float, float]:
        by_side = dict(zip([p.name for p in parameters], values, strict=False))
        return by_side.get("ahead", 0.0), by_side.get("astern", 0.0)

    def without(values: Array) -> Array:
        return np.asarray(bollard_pull(command, *constants(values)))

    def with_deadband(values: Array) -> Array:
        return np.asarray(bollard_pull(command, *constants(values[:-1]), values[-1]))

    simple = fit("quadratic thrust", without, parameters, thrust, thrust_sd)
    richer = fit("quadratic thrust with a deadband", with_deadband, [*parameters, deadband], thrust, thrust_sd)
    return simple, richer


def _constants_in_words(best: FittedModel) -> str:
    parts = [f"{e.value:.4g} {e.unit} {e.name}" for e in best.estimates if e.name != "deadband"]
    band = f", with a deadband of {best['deadband'].value:.2g} {best['deadband'].unit}" if "deadband" in best else ""
    return f"Thrust is {' and '.join(parts)}{band}."


def _asymmetry(best: FittedModel) -> tuple[str, ...]:
    if "ahead" not in best or "astern" not in best:
        return ()
    ahead, astern = best["ahead"], best["astern"]
    variance = ahead.sd**2 + astern.sd**2
    apart = abs(ahead.value - astern.value) / np.sqrt(variance) if variance > 0.0 else np.inf
    return (
        f"Astern it makes {100 * astern.value / ahead.value:.0f} % of its thrust ahead ({apart:.1f} standard errors).",
    )


def _static_fragment(best: FittedModel) -> dict[str, object]:
    fragment: dict[str, object] = {"name": "thruster"}
    for estimate in best.estimates:
        its_unit = "N/V^2" if estimate.name != "deadband" else "V"
        fragment[estimate.name] = {"mean": f"{estimate.value:.5g} {its_unit}", "sd": f"{estimate.sd:.2g} {its_unit}"}
    return fragment


def _static_panel(command: Array, thrust: Array, thrust_sd: Array | None, best: FittedModel, unit: str) -> FitPanel:
    line = np.linspace(command.min(), command.max(), 200)
    ahead = best["ahead"].value if "ahead" in best else 0.0
    astern = best["astern"].value if "astern" in best else 0.0
    deadband = best["deadband"].value if "deadband" in best else 0.0
    return FitPanel(
        name="static-thrust",
        x_label="voltage [V]" if unit == "V" else "shaft rate [rev/s]",
        y_label="thrust [N]",
        x=command,
        y=thrust,
        y_sd=np.full_like(thrust, np.nan) if thrust_sd is None else thrust_sd,
        fitted=best.fitted,
        curves=(FitCurve(best.name, line, np.asarray(bollard_pull(line, ahead, astern, deadband))),),
        alt="Static thrust against the command with the preferred fit.",
    )
