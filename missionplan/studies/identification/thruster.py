"""Static thrust (Avila et al.), and what forward speed leaves of a tunnel thruster's (Palmer et al.)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.tank import TankData, ThrusterGeometry, ThrusterSettings
from missionplan.physics import tunnel_thruster as tt
from missionplan.physics.thruster import bollard_pull
from missionplan.results.identification import FitCurve, FitPanel, FittedModel, TankAnalysis
from missionplan.studies.identification.least_squares import Parameter, adds_something, fit

_RATE_REMARK = (
    "A vehicle file carries thrust against shaft rate as `thrust_constant` of a tunnel thruster, with its `decay`: "
    "give `geometry` and measure under way."
)
AT_REST = 0.01
"""Speeds below this count as bollard pull [m/s]."""


def identify_thruster(data: TankData) -> TankAnalysis:
    """Fit static thrust with its deadband, or a tunnel thruster under way where speeds and a geometry are given."""
    settings = data.settings
    assert isinstance(settings, ThrusterSettings)
    speed = data.columns.get("speed_m_s", np.zeros_like(data.columns["thrust_n"]))
    if np.any(speed > AT_REST) and settings.geometry is not None and "rpm" in data.columns:
        return _under_way(data, settings.geometry, speed)
    return _static(data, speed <= AT_REST)


def _static(data: TankData, at_rest: NDArray[np.bool_]) -> TankAnalysis:
    """Fit τ = c(|V| - V₀)² with a constant for each direction, without and with the deadband V₀."""
    name, unit = ("voltage_v", "V") if "voltage_v" in data.columns else ("rpm", "1/s")
    command = data.columns[name][at_rest] / (1.0 if unit == "V" else 60.0)
    thrust = data.columns["thrust_n"][at_rest]
    noise = data.settings.noise.thrust
    thrust_sd = None if noise is None else np.full_like(thrust, noise)
    squared = "N/V^2" if unit == "V" else "N*s^2"
    sides = [("ahead", command > 0.0), ("astern", command < 0.0)]
    parameters = [
        Parameter(side, f"c {side}", squared, float(np.sum(np.abs(thrust[m])) / np.sum(command[m] ** 2)), low=0.0)
        for side, m in sides
        if np.any(m)
    ]
    deadband = Parameter("deadband", "V₀", unit, 0.02 * float(np.abs(command).max()), 0.0, float(np.abs(command).max()))

    def constants(values: Array) -> tuple[float, float]:
        by_side = dict(zip([p.name for p in parameters], values, strict=False))
        return by_side.get("ahead", 0.0), by_side.get("astern", 0.0)

    def without(values: Array) -> Array:
        return np.asarray(bollard_pull(command, *constants(values)))

    def with_band(values: Array) -> Array:
        return np.asarray(bollard_pull(command, *constants(values[:-1]), values[-1]))

    simple = fit("quadratic thrust", without, parameters, thrust, thrust_sd)
    richer = fit("quadratic thrust with a deadband", with_band, [*parameters, deadband], thrust, thrust_sd)
    fits = (richer, simple) if adds_something(simple, richer) else (simple, richer)
    return TankAnalysis(
        answer=_constants_in_words(fits[0]),
        fits=fits,
        panels=(_static_panel(command, thrust, thrust_sd, fits[0], unit),),
        remarks=_asymmetry(fits[0]) + (() if unit == "V" else (_RATE_REMARK,)),
        fragment={"thrusters": [_static_fragment(fits[0])]} if unit == "V" else {},
    )


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


def _static_fragment(best: FittedModel) -> dict[str, Any]:
    fragment: dict[str, Any] = {"name": "thruster"}
    for estimate in best.estimates:
        its_unit = "N/V^2" if estimate.name != "deadband" else "V"
        fragment[estimate.name] = {"mean": f"{estimate.value:.5g} {its_unit}", "sd": f"{estimate.sd:.2g} {its_unit}"}
    return fragment


def _static_panel(command: Array, thrust: Array, thrust_sd: Array | None, best: FittedModel, unit: str) -> FitPanel:
    line = np.linspace(command.min(), command.max(), 200)
    ahead = best["ahead"].value if "ahead" in best else 0.0
    astern = best["astern"].value if "astern" in best else 0.0
    band = best["deadband"].value if "deadband" in best else 0.0
    return FitPanel(
        "static-thrust",
        "voltage [V]" if unit == "V" else "shaft rate [rev/s]",
        "thrust [N]",
        command,
        thrust,
        np.full_like(thrust, np.nan) if thrust_sd is None else thrust_sd,
        best.fitted,
        (FitCurve(best.name, line, np.asarray(bollard_pull(line, ahead, astern, band))),),
        "Static thrust against the command with the preferred fit.",
    )


def _under_way(data: TankData, geometry: ThrusterGeometry, speed: Array) -> TankAnalysis:
    """Fit K_3 and c to forces and, where moments are given, the centre of suction: k of Eq. 6, or a constant x_S."""
    turning = data.columns["rpm"] != 0.0
    revolutions, speed = data.columns["rpm"][turning] / 60.0, speed[turning]
    force = data.columns["thrust_n"][turning]
    moments = data.columns.get("moment_n_m")
    jet = _Jet(geometry, data.density, revolutions, speed)
    force_sd = np.full_like(force, data.settings.noise.thrust or np.nan)
    start = float(np.median(np.abs(force) / revolutions**2))
    parameters = [
        Parameter("thrust_constant", "K₃", "N*s^2", start, low=0.0),
        Parameter("decay", "c", "", 5.0, low=0.0, high=50.0),
    ]
    forces = fit(
        "force under way", jet.force, parameters, force, None if data.settings.noise.thrust is None else force_sd
    )
    if moments is None or np.all(np.isnan(moments)):
        fits: tuple[FittedModel, ...] = (forces,)
    else:
        fits = _with_moments(jet, parameters, forces, force, moments[turning], data.settings.noise.moment)
    best = fits[0]
    return TankAnalysis(
        answer=f"The static constant is {best['thrust_constant'].value:.4g} N s², and speed takes thrust away with c = "
        f"{best['decay'].value:.2f} (90 % interval {best['decay'].low:.2f} to {best['decay'].high:.2f}).",
        fits=fits,
        panels=jet.panels(best, force, moments[turning] if len(fits) > 1 and moments is not None else None),
        remarks=jet.remarks(best),
        fragment={"thrusters": [_tunnel_fragment(best, geometry)]},
    )


class _Jet:
    """Forces and moments of a tunnel thruster at the measured shaft rates and speeds."""

    def __init__(self, geometry: ThrusterGeometry, density: float, revolutions: Array, speed: Array) -> None:
        self.geometry, self.density, self.revolutions, self.speed = geometry, density, revolutions, speed

    def thruster(self, values: Array) -> tt.TunnelThruster:
        """Thruster of K_3 and c."""
        return tt.TunnelThruster(self.geometry.diameter, values[0], values[1], position=self.geometry.position)

    def force(self, values: Array) -> Array:
        return np.asarray(tt.thruster_load(self.thruster(values), self.revolutions, self.speed, self.density).force)

    def ratio(self, values: Array) -> Array:
        return np.asarray(tt.thruster_load(self.thruster(values), self.revolutions, self.speed, self.density).ratio)

    def moment(self, values: Array, gradient: float, offset: float) -> Array:
        thruster = tt.TunnelThruster(
            self.geometry.diameter,
            values[0],
            values[1],
            self.geometry.position,
            suction_gradient=gradient,
            suction_offset=offset,
        )
        return np.asarray(tt.thruster_load(thruster, self.revolutions, self.speed, self.density).moment)

    def panels(self, best: FittedModel, force: Array, moments: Array | None) -> tuple[FitPanel, ...]:
        values = np.array([best["thrust_constant"].value, best["decay"].value])
        ratio, static = self.ratio(values), tt.static_thrust(values[0], self.revolutions)
        line = np.linspace(0.0, max(float(ratio.max()), 0.1), 100)
        factor = np.asarray(tt.force_factor(line, values[1]))
        unknown = np.full_like(force, np.nan)
        count = len(force)
        k_f = FitPanel(
            "force-factor",
            "speed ratio u/u_j",
            "K_F",
            ratio,
            force / static,
            unknown,
            best.fitted[:count] / static,
            (FitCurve("exp(-c (u/u_j)²)", line, factor),),
            "Share of the static force that the vehicle feels against speed ratio, falling to little as speed rises.",
        )
        if moments is None or self.geometry.position == 0.0:
            return (k_f,)
        at_rest = static * self.geometry.position
        gradient = best["suction_gradient"].value if "suction_gradient" in best else 0.0
        offset = best["suction_offset"].value if "suction_offset" in best else 0.0
        centre = self.geometry.position - offset - gradient * self.geometry.diameter * line
        k_n = FitPanel(
            "moment-factor",
            "speed ratio u/u_j",
            "K_N",
            ratio,
            moments / at_rest,
            unknown,
            best.fitted[count:] / at_rest,
            (FitCurve(best.name, line, np.asarray(tt.moment_factor(factor, centre / self.geometry.position))),),
            "Moment over the static moment against speed ratio.",
        )
        return (k_f, k_n)

    def remarks(self, best: FittedModel) -> tuple[str, ...]:
        values = np.array([best["thrust_constant"].value, best["decay"].value])
        limit = float(np.asarray(tt.highest_ratio(values[1])))
        beyond = int(np.sum(tt.out_of_range(self.ratio(values), values[1])))
        remarks = [f"The exponential holds up to u/u_j = {limit:.2f}; beyond, forces may recover as ships' do."]
        if beyond:
            remarks.append(f"{beyond} of {len(self.speed)} points lie beyond that.")
        return tuple(remarks)


def _with_moments(
    jet: _Jet, parameters: list[Parameter], forces: FittedModel, force: Array, moments: Array, moment_sd: float | None
) -> tuple[FittedModel, ...]:
    """Fit forces and moments together, with both laws of the centre of suction; the better one first."""
    values = np.array([estimate.value for estimate in forces.estimates])
    laws = {
        "centre of suction moves aft with speed": Parameter("suction_gradient", "k", "", 1.0),
        "centre of suction stays": Parameter("suction_offset", "x_T - x_S", "m", 0.1),
    }
    fits = []
    for name, law in laws.items():
        linear = law.name == "suction_gradient"

        def moment_of(both: Array, place: float, linear: bool = linear) -> Array:
            return jet.moment(both, place if linear else 0.0, 0.0 if linear else place)

        def moment_alone(v: Array, of: Any = moment_of) -> Array:
            return np.asarray(of(values, v[0]))

        def together(v: Array, of: Any = moment_of) -> Array:
            return np.concatenate([jet.force(v[:2]), of(v[:2], v[2])])

        alone = fit(name, moment_alone, [law], moments)
        scatter = moment_sd if moment_sd is not None else alone.residual_sd
        sd = np.concatenate(
            [np.full_like(force, max(forces.residual_sd, 1e-12)), np.full_like(moments, max(scatter, 1e-12))]
        )
        fits.append(fit(name, together, [*parameters, law], np.concatenate([force, moments]), sd))
    return tuple(sorted(fits, key=lambda fitted: fitted.chi_squared))


def _tunnel_fragment(best: FittedModel, geometry: ThrusterGeometry) -> dict[str, Any]:
    fragment: dict[str, Any] = {
        "name": "tunnel thruster",
        "diameter": f"{geometry.diameter:.6g} m",
        "position": f"{geometry.position:.6g} m",
        "thrust_constant": {
            "mean": f"{best['thrust_constant'].value:.5g} N*s^2",
            "sd": f"{best['thrust_constant'].sd:.2g} N*s^2",
        },
        "decay": {"mean": round(best["decay"].value, 3), "sd": round(best["decay"].sd, 3)},
    }
    if "suction_gradient" in best:
        fragment["suction_gradient"] = round(best["suction_gradient"].value, 3)
    if "suction_offset" in best:
        fragment["suction_offset"] = f"{best['suction_offset'].value:.4g} m"
    return fragment
