"""`identify`: hydrodynamic and thruster parameters, with their errors, from tank data.

A propeller's constants from a transient: quasi-steady, and with axial-flow dynamics (Blanke et al.). Other kinds of
data have a module each; `fits` has the one fitting routine.
"""

import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets import files_outside
from missionplan.datasets.tank import (
    DragSettings,
    OscillationSettings,
    PropellerGeometry,
    PropellerSettings,
    TankData,
    ThrusterSettings,
    read_tank_data,
)
from missionplan.errors import InputError, Problem
from missionplan.physics.drag import disc_area
from missionplan.physics.propeller import Propeller, thrust
from missionplan.physics.propulsion import propeller_response
from missionplan.report.wording import MINUS, significant
from missionplan.results import Provenance
from missionplan.studies.identification.drag import identify_drag
from missionplan.studies.identification.fits import (
    FitCurve,
    FitPanel,
    FitParameter,
    FittedModel,
    Identification,
    TankAnalysis,
    f_test_prefers,
    fit,
    scaled_estimate,
)
from missionplan.studies.identification.oscillation import identify_oscillation
from missionplan.studies.identification.thruster import identify_thruster
from missionplan.studies.run import identified_datasets

TURN = 2.0 * math.pi
_TORQUE_REMARK = "A vehicle file also needs `torque_coefficient`, which thrust alone does not tell: add it."


def identify_propeller(data: TankData, settings: PropellerSettings) -> TankAnalysis:
    """Fit T_nn and T_nu with the flow in the disc settled, then T_nn, T° and m_f with dynamics of the flow.

    The damping of the flow is given (2ρA_p, or the data set's): at rest, thrust alone does not determine one
    combination of T°, m_f and d_f.

    Raises InputError when the shaft rate was not measured and the data set lacks what it follows from.
    """
    geometry = settings.geometry
    run = TransientRun(data, geometry)
    measured = data.columns["thrust_n"]
    thrust_sd = settings.noise.thrust
    steady, dynamic = _fits(run, measured, thrust_sd)
    prefers_dynamic = f_test_prefers(steady, dynamic) and dynamic.residual_sd < steady.residual_sd
    fits = (dynamic, steady) if prefers_dynamic else (steady, dynamic)
    # the thrust coefficient against the advance ratio
    unit = TURN**2 / (run.density * geometry.diameter**4)
    per_ratio = TURN * (1.0 + geometry.axial_flow_factor) / (run.density * geometry.diameter**3)
    level = scaled_estimate("thrust_coefficient", "α₀", "", fits[0]["thrust_nn"], unit)
    slope = scaled_estimate("thrust_coefficient_slope", "α₁", "", fits[0]["thrust_nu"], per_ratio)
    return TankAnalysis(
        answer=(
            f"Thrust follows {fits[0].name}: K_T = {significant(level.value, level.sd)} {MINUS} "
            f"{significant(-slope.value, slope.sd)} J."
        ),
        fits=fits,
        panels=(
            FitPanel(
                name="thrust",
                x_label="time [s]",
                y_label="thrust [N]",
                x=run.time,
                y=measured,
                y_sd=thrust_sd,
                fitted=fits[0].fitted,
                curves=tuple(FitCurve(fitted.name, run.time, fitted.fitted) for fitted in fits),
                alt="Thrust against time with the fits of both models.",
            ),
        ),
        remarks=(
            f"Residuals: {dynamic.residual_sd:.3g} N with axial-flow dynamics, {steady.residual_sd:.3g} N without.",
            f"The flow's damping is taken as {run.damping:.4g} kg/m.",
            *(() if geometry.torque_coefficient else (_TORQUE_REMARK,)),
        ),
        fragment={"propulsion": _fragment(geometry, fits, level.value, slope.value)},
        derived=(level, slope),
    )


def _fits(run: "TransientRun", measured: Array, thrust_sd: float | None) -> tuple[FittedModel, FittedModel]:
    diameter = run.geometry.diameter
    unit = run.density * diameter**4 / TURN**2
    constants = [
        FitParameter("thrust_nn", "T_nn", "N*s^2", 0.4 * unit, low=0.0),
        FitParameter("thrust_nu", "T°_nu", "kg", -0.8 * unit * TURN / diameter, high=0.0),
    ]
    water = run.density * float(disc_area(diameter)) * diameter
    flow_mass = FitParameter("flow_mass", "m_f", "kg", water, low=0.01 * water, high=100.0 * water)
    steady = fit("quasi-steady thrust", run.quasi_steady, constants, measured, thrust_sd, in_sequence=True)
    dynamic = fit("axial-flow dynamics", run.axial_flow, [*constants, flow_mass], measured, thrust_sd, in_sequence=True)
    return steady, dynamic


def _fragment(
    geometry: PropellerGeometry, fits: tuple[FittedModel, ...], level: float, slope: float
) -> dict[str, object]:
    fragment: dict[str, object] = {
        "diameter": f"{geometry.diameter:.6g} m",
        "thrust_coefficient": [round(level, 5), round(slope, 5)],
        "wake_fraction": geometry.wake_fraction,
        "axial_flow_factor": geometry.axial_flow_factor,
    }
    if geometry.torque_coefficient is not None:
        fragment["torque_coefficient"] = list(geometry.torque_coefficient)
    if "flow_mass" in fits[0]:
        fragment["flow_mass"] = f"{fits[0]['flow_mass'].value:.4g} kg"
    return fragment


class TransientRun:
    """A measured run, and the thrust that a propeller would make in it."""

    def __init__(self, data: TankData, geometry: PropellerGeometry) -> None:
        self.time, self.speed = data.columns["t_s"], data.columns["speed_m_s"]
        self.density, self.geometry = data.density, geometry
        momentum = 2.0 * self.density * float(disc_area(geometry.diameter))
        self.damping = momentum if geometry.flow_damping is None else geometry.flow_damping
        self.torque = data.columns.get("shaft_torque_n_m")
        self.shaft_rate = data.columns["rpm"] * TURN / 60.0 if "rpm" in data.columns else None
        needed = ("torque_coefficient", "shaft_inertia")
        missing = [key for key in needed if self.shaft_rate is None and getattr(geometry, key) is None]
        if missing:
            words = "needed to find the shaft rate from the torque, as there is no column rpm"
            raise InputError([Problem(f"missing; {words}", "dataset.yaml", key=f"geometry.{key}") for key in missing])

    def propeller(self, values: Array) -> Propeller:
        """Build a propeller of T_nn, T° and m_f."""
        level, slope = self.geometry.torque_coefficient or (0.0, 0.0)
        diameter, a = self.geometry.diameter, self.geometry.axial_flow_factor
        return Propeller(
            diameter=diameter,
            thrust_nn=float(values[0]),
            thrust_nu=float(values[1]),
            torque_nn=self.density * diameter**5 * level / TURN**2,
            torque_nu=self.density * diameter**4 * slope / TURN / (1.0 + a),
            axial_flow_factor=a,
            wake_fraction=self.geometry.wake_fraction,
            thrust_deduction=0.0,
            shaft_inertia=self.geometry.shaft_inertia or math.inf,
            flow_mass=float(values[2]) if len(values) > 2 else 1.0,
            flow_damping_linear=0.0,
            flow_damping_quadratic=self.damping,
        )

    def axial_flow(self, values: Array) -> Array:
        """Thrust with dynamics of the flow in the disc."""
        propeller = self.propeller(values)
        rate, flow = propeller_response(
            propeller, self.time, self.speed, shaft_rate=self.shaft_rate, motor_torque=self.torque
        )
        return np.asarray(thrust(propeller, rate, flow))

    def quasi_steady(self, values: Array) -> Array:
        """Thrust with the flow in the disc at (1 + a)(1 - w)u."""
        propeller = self.propeller(values)
        if self.shaft_rate is None:
            unloaded = self.propeller(np.array([*values, 1.0]))
            rate, _ = propeller_response(unloaded, self.time, self.speed, motor_torque=self.torque)
        else:
            rate = self.shaft_rate
        return np.asarray(thrust(propeller, rate, propeller.flow_ratio * self.speed))


def identify(dataset: str | Path, *, allow_outside: bool = False) -> Identification:
    """Find the parameters that a data set from a tank determines.

    Parameters
    ----------
    dataset : str or Path
        Folder with `dataset.yaml`, of kind drag, free-oscillation, thruster or propeller-transient.
    allow_outside : bool
        Whether its tables may lie outside the folder.

    Returns
    -------
    Identification
        Parameters with standard errors and 90 % intervals, fits, and a fragment for a vehicle file.

    Raises
    ------
    InputError
        With every problem of the data set.
    RunError
        When the data do not determine the parameters.
    """
    started = time.perf_counter()
    with files_outside(allowed=allow_outside):
        data = read_tank_data(dataset)
    match data.settings:
        case DragSettings() as settings:
            analysis = identify_drag(data, settings)
        case OscillationSettings() as settings:
            analysis = identify_oscillation(data, settings)
        case ThrusterSettings() as settings:
            analysis = identify_thruster(data, settings)
        case PropellerSettings() as settings:
            analysis = identify_propeller(data, settings)
    provenance = Provenance(
        command="identify",
        mission=data.name,
        file=str(dataset),
        elapsed_s=time.perf_counter() - started,
        data=data.raw,
        notices=data.notices,
        inputs=identified_datasets([Path(dataset)]),
    )
    kind, answered = data.settings.kind, vars(_headed(analysis))
    return Identification(**answered, provenance=provenance, kind=kind, name=data.name, source=data.source)


def _headed(analysis: TankAnalysis) -> TankAnalysis:
    """Lead with it where the preferred model does not fit, and say what its numbers are then."""
    best = analysis.fits[0]
    if not best.does_not_fit:
        return analysis
    larger = math.sqrt(best.chi_squared / best.degrees_of_freedom)
    headline = (
        f"The model does not fit ({best.name}): chi-squared is {best.chi_squared:.0f} on {best.degrees_of_freedom} "
        f"degrees of freedom, the residuals are {larger:.1f} times the stated errors. These are the numbers of the "
        "best fit, without an interval. "
    )
    remark = (
        "What a model leaves out can shift its parameters by more than any standard error says, so no interval is "
        "given. Look at the residuals for what is missing. If the stated errors are too small, correct them or leave "
        "them out: the interval then follows from the scatter. Errors in the vehicle's fragment take the misfit for "
        f"scatter: they are {best.widened:.1f} times those that follow from the stated errors."
    )
    return replace(analysis, answer=headline + analysis.answer, remarks=(remark, *analysis.remarks))
