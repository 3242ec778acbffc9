"""Constants of propellers and tunnel thrusters from measured thrust, speed and moment."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.tank import NoiseLevels, TankData, ThrusterGeometry, ThrusterSettings
from missionplan.errors import RunError, counted
from missionplan.physics import tunnel_thruster as tt
from missionplan.physics.tunnel_thruster import bollard_pull
from missionplan.report.wording import significant
from missionplan.studies.identification.fits import (
    FitCurve,
    FitPanel,
    FitParameter,
    FittedModel,
    TankAnalysis,
    fit,
    preferred_first,
)


def identify_tunnel_thruster(
    data: TankData, settings: ThrusterSettings, geometry: ThrusterGeometry, speed: Array
) -> TankAnalysis:
    """Fit K_3 and c to forces and, where moments are given, the centre of suction: k of Eq. 6, or a constant x_S.

    Parameters
    ----------
    data : TankData
        With shaft rates and thrust; optionally moments.
    settings : ThrusterSettings
        The data's.
    geometry : ThrusterGeometry
        The settings'.
    speed : array, shape (points,)
        [m/s]
    """
    turning = data.columns["rpm"] != 0.0
    run = TunnelThrusterRun(geometry, data.density, data.columns["rpm"][turning] / 60.0, speed[turning])
    force, moments = data.columns["thrust_n"][turning], data.columns.get("moment_n_m")
    noise = settings.noise
    fits: tuple[FittedModel, ...] = (fit("force under way", run.force, run.parameters(force), force, noise.thrust),)
    measured = None if moments is None or np.all(np.isnan(moments)) else moments[turning]
    if measured is not None:
        fits = _moment_fits(run, fits[0], force, measured, noise)
    best = fits[0]
    values = np.array([best["thrust_constant"].value, best["decay"].value])
    limit = float(np.asarray(tt.highest_ratio(values[1])))
    beyond = int(np.sum(tt.out_of_range(run.load(values).ratio, values[1])))
    remarks = [f"The exponential holds up to u/u_j = {limit:.2f}; beyond, forces may recover as ships' do."]
    if beyond:
        remarks.append(f"Beyond that: {beyond} of {counted(len(run.speed), 'point')}.")
    constant, decay = best["thrust_constant"], best["decay"]
    fragment: dict[str, object] = {
        "name": "tunnel thruster",
        "diameter": f"{geometry.diameter:.6g} m",
        "position": f"{geometry.position:.6g} m",
        "thrust_constant": {"mean": f"{constant.value:.5g} N*s^2", "sd": f"{constant.sd:.2g} N*s^2"},
        "decay": {"mean": round(decay.value, 3), "sd": round(decay.sd, 3)},
    }
    if "suction_gradient" in best:
        fragment["suction_gradient"] = round(best["suction_gradient"].value, 3)
    if "suction_offset" in best:
        fragment["suction_offset"] = f"{best['suction_offset'].value:.4g} m"
    return TankAnalysis(
        answer=f"The static constant is {best['thrust_constant'].in_words}, and speed takes thrust away with c = "
        f"{best['decay'].in_words}.",
        fits=fits,
        panels=_panels(run, best, force, measured),
        remarks=tuple(remarks),
        fragment={"thrusters": [fragment]},
    )


@dataclass(frozen=True)
class TunnelThrusterRun:
    """Model of a tunnel thruster's force and moment at the measured shaft rates and speeds."""

    geometry: ThrusterGeometry
    density: float
    """Of the water [kg/m³]."""
    revolutions: Array
    speed: Array
    """[rev/s, m/s], shape (points,)."""

    def parameters(self, force: Array) -> list[FitParameter]:
        """K_3, starting from measured forces [N], and c."""
        start = float(np.median(np.abs(force) / self.revolutions**2))
        return [
            FitParameter("thrust_constant", "K₃", "N*s^2", start, low=0.0),
            FitParameter("decay", "c", "", 5.0, low=0.0, high=50.0),
        ]

    def force(self, values: Array) -> Array:
        """Force for K_3 and c [N]."""
        return np.asarray(self.load(values).force)

    def load(self, values: Array, gradient: float = 0.0, offset: float = 0.0) -> tt.ThrusterLoad:
        """Return force, moment and speed over the jet's, with gradient and offset [m] of the centre of suction."""
        thruster = tt.TunnelThruster(
            self.geometry.diameter,
            values[0],
            values[1],
            self.geometry.position,
            suction_gradient=gradient,
            suction_offset=offset,
        )
        return tt.thruster_load(thruster, self.revolutions, self.speed, self.density)


def _moment_fits(
    run: TunnelThrusterRun, forces: FittedModel, force: Array, moments: Array, noise: NoiseLevels
) -> tuple[FittedModel, ...]:
    """Fit forces and moments together, with both laws of the centre of suction; the better one first.

    Errors are those of separate fits where they are not stated.
    """
    constants, force_sd = forces.estimates, noise.thrust or max(forces.residual_sd, 1e-12)
    measured = np.concatenate([force, moments])

    def joint(name: str, law: FitParameter) -> FittedModel:
        def moment(both: Array, value: float) -> Array:
            centre = (value, 0.0) if law.name == "suction_gradient" else (0.0, value)
            return np.asarray(run.load(both, *centre).moment)

        def moment_alone(values: Array) -> Array:
            return moment(np.array([estimate.value for estimate in constants]), values[0])

        def together(values: Array) -> Array:
            return np.concatenate([run.force(values[:2]), moment(values[:2], values[2])])

        moment_sd = noise.moment or max(fit(name, moment_alone, [law], moments).residual_sd, 1e-12)
        sd = np.concatenate([np.full_like(force, force_sd), np.full_like(moments, moment_sd)])
        return fit(name, together, [*run.parameters(force), law], measured, sd)

    moving = joint("centre of suction moves aft with speed", FitParameter("suction_gradient", "k", "", 1.0))
    staying = joint("centre of suction stays", FitParameter("suction_offset", "x_T - x_S", "m", 0.1))
    return tuple(sorted((moving, staying), key=lambda fitted: fitted.chi_squared))


def _panels(run: TunnelThrusterRun, best: FittedModel, force: Array, moments: Array | None) -> tuple[FitPanel, ...]:
    """Force factor against speed ratio and, where moments are given about another point, the moment factor."""
    constant, decay = best["thrust_constant"].value, best["decay"].value
    ratio = np.asarray(run.load(np.array([constant, decay])).ratio)
    line = np.linspace(0.0, max(float(ratio.max()), 0.1), 100)
    static, factor = tt.static_thrust(constant, run.revolutions), np.asarray(tt.force_factor(line, decay))
    force_panel = FitPanel(
        name="force-factor",
        x_label="speed ratio u/u_j",
        y_label="K_F",
        x=ratio,
        y=force / static,
        fitted=best.fitted[: len(force)] / static,
        curves=(FitCurve("exp(-c (u/u_j)²)", line, factor),),
        alt="Share of the static force that the vehicle feels against speed ratio, falling to little as speed rises.",
    )
    position = run.geometry.position
    if moments is None or position == 0.0:
        return (force_panel,)
    gradient = best["suction_gradient"].value if "suction_gradient" in best else 0.0
    offset = best["suction_offset"].value if "suction_offset" in best else 0.0
    centre, at_rest = position - offset - gradient * run.geometry.diameter * line, static * position
    moment_panel = FitPanel(
        name="moment-factor",
        x_label="speed ratio u/u_j",
        y_label="K_N",
        x=ratio,
        y=moments / at_rest,
        fitted=best.fitted[len(moments) :] / at_rest,
        curves=(FitCurve(best.name, line, np.asarray(tt.moment_factor(factor, centre / position))),),
        alt="Moment over the static moment against speed ratio.",
    )
    return force_panel, moment_panel


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
    # fit τ = c(|V| - V₀)² with a constant for each direction, without and with the deadband V₀
    at_rest = speed <= AT_REST
    name, unit = ("voltage_v", "V") if "voltage_v" in data.columns else ("rpm", "1/s")
    command = data.columns[name][at_rest] / (1.0 if unit == "V" else 60.0)
    thrust = data.columns["thrust_n"][at_rest]
    if not np.any(command):
        raise RunError(f"thrust: no row at rest has a {name} other than 0")
    thrust_sd = data.settings.noise.thrust
    fits = preferred_first(*_static_fits(command, thrust, thrust_sd, unit))
    best, line = fits[0], np.linspace(command.min(), command.max(), 200)
    by_name = {estimate.name: estimate.value for estimate in best.estimates}
    pull = bollard_pull(line, *(by_name.get(name, 0.0) for name in ("ahead", "astern", "deadband")))
    panel = FitPanel(
        name="static-thrust",
        x_label="voltage [V]" if unit == "V" else "shaft rate [rev/s]",
        y_label="thrust [N]",
        x=command,
        y=thrust,
        y_sd=thrust_sd,
        fitted=best.fitted,
        curves=(FitCurve(best.name, line, np.asarray(pull)),),
        alt="Static thrust against the command with the preferred fit.",
    )
    parts = [f"{significant(e.value, e.sd)} {e.unit} {e.name}" for e in best.estimates if e.name != "deadband"]
    band = f", with a deadband of {best['deadband'].value:.2g} {best['deadband'].unit}" if "deadband" in best else ""
    fragment: dict[str, object] = {"name": "thruster"}
    for e in best.estimates:
        fragment[e.name] = {"mean": f"{e.value:.5g} {e.unit}", "sd": f"{e.sd:.2g} {e.unit}"}
    return TankAnalysis(
        answer=f"Thrust is {' and '.join(parts)}{band}.",
        fits=fits,
        panels=(panel,),
        remarks=_asymmetry(best) + (() if unit == "V" else (_RATE_REMARK,)),
        fragment={"thrusters": [fragment]} if unit == "V" else {},
    )


def _static_fits(command: Array, thrust: Array, thrust_sd: float | None, unit: str) -> tuple[FittedModel, FittedModel]:
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

    every = [*parameters, deadband]

    def pull(values: Array) -> Array:
        by_name = dict(zip([parameter.name for parameter in every], values, strict=False))
        return np.asarray(bollard_pull(command, *(by_name.get(name, 0.0) for name in ("ahead", "astern", "deadband"))))

    simple = fit("quadratic thrust", pull, parameters, thrust, thrust_sd)
    return simple, fit("quadratic thrust with a deadband", pull, every, thrust, thrust_sd)


def _asymmetry(best: FittedModel) -> tuple[str, ...]:
    if "ahead" not in best or "astern" not in best:
        return ()
    ahead, astern = best["ahead"], best["astern"]
    variance = ahead.sd**2 + astern.sd**2
    apart = f" ({abs(ahead.value - astern.value) / np.sqrt(variance):.1f} standard errors)" if variance > 0.0 else ""
    return (f"Astern it makes {100 * astern.value / ahead.value:.0f} % of its thrust ahead{apart}.",)
