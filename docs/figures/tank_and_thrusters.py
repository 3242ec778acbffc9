"""Figures of docs/tank-identification.md, propeller.md, tunnel-thrusters.md and transition.md.

Run from the project's root: ``python docs/figures/tank_and_thrusters.py``.
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure as MatplotlibFigure

import missionplan
from missionplan.physics import tunnel_thruster as tunnel
from missionplan.report.page import BLUE, GREEN, GREY, ORANGE, Figure, style, to_figure
from missionplan.studies.identification import identify
from missionplan.studies.identification import page as pictures
from missionplan.studies.sweep_transition import sweep_transition
from missionplan.studies.transition_page import energy_figure, history_figure, pitch_by_variant, unassisted_figure
from tests.physics import avila_example as avila
from tests.physics import propeller_example as example

HERE = Path(__file__).parent
MISSIONS = HERE.parents[1] / "missions"


def blanke() -> list[Figure]:
    """Figs. 4 and 5 of Blanke et al., and the open-water lines of its Fig. 3."""
    step = 0.02
    torque = example.eq_36_torque(step)
    run = example.simulate_propulsion(example.table_1(), example.TABLE_1_RESISTANCE, torque, step)
    fig_4 = MatplotlibFigure(figsize=(6.0, 4.6))
    speeds, rates = fig_4.subplots(2, 1, sharex=True)
    speeds.plot(run.time, run.axial_flow, color=ORANGE, linewidth=1.2, label="flow in the disc $u_p$")
    speeds.plot(run.time, run.speed, color=BLUE, label="vehicle $u$")
    speeds.set_ylabel("speed [m/s]")
    speeds.legend(loc="lower left")
    rates.plot(run.time, run.shaft_rate / (2.0 * math.pi), color=BLUE)
    rates.set_ylabel("shaft rate [rev/s]")
    rates.set_xlabel("time [s]")
    fig_5 = MatplotlibFigure(figsize=(6.0, 4.6))
    thrusts, torques = fig_5.subplots(2, 1, sharex=True)
    thrusts.plot(run.time, run.thrust, color=BLUE)
    thrusts.set_ylabel("thrust [N]")
    torques.plot(run.time, run.torque, color=BLUE, label="propeller (hydrodynamic)")
    torques.plot(run.time[1:], torque, color=GREY, linestyle=":", label="motor")
    torques.set_ylabel("torque [N m]")
    torques.set_xlabel("time [s]")
    torques.legend(loc="lower right")
    alt_4 = "Flow in the disc runs ahead of the vehicle's speed after each change of torque, then both settle together."
    return [
        to_figure(fig_4, "blanke-fig-4", alt_4),
        to_figure(fig_5, "blanke-fig-5", "Thrust and torque under the test sequence of 5, -5 and 2.5 N m."),
    ]


def avila_step_response() -> Figure:
    """Fig. 5 of Avila et al."""
    figure = MatplotlibFigure()
    axes = figure.subplots()
    time = np.linspace(0.0, 8.0, 200)
    rows = (("surge", 2.24, 81.81, 0.75 * 497.8), ("sway", 2.73, 126.11, 0.75 * 348.6), ("heave", 3.62, 250.71, 772.0))
    for (name, coefficient, added, force), colour in zip(rows, (BLUE, ORANGE, GREEN), strict=True):
        top = avila.top_speed(force, 1.0, coefficient, 0.329, 1000.0)
        axes.plot(time, avila.step_response(time, top, force, 420.0 + added), color=colour)
        axes.annotate(f"{name} {top:.3f} m/s", (time[-1], float(top)), ha="right", va="bottom", color=colour)
    axes.set_xlabel("time since full thrust [s]")
    axes.set_ylabel("speed [m/s]")
    axes.set_ylim(0.0, 1.3)
    return to_figure(figure, "avila-fig-5", "Speed against time after a step of full thrust in surge, sway and heave.")


def tunnel_factors() -> Figure:
    """Force and moment factors of a forward and an aft thruster, after Fig. 8 of Palmer et al. (2009)."""
    figure = MatplotlibFigure()
    axes = figure.subplots()
    ratio = np.linspace(0.0, 1.0, 200)
    forward = tunnel.TunnelThruster(0.07, 0.02, 7.0, position=0.8, suction_gradient=10.0)
    aft = tunnel.TunnelThruster(0.07, 0.02, 3.0, position=-0.8, suction_offset=0.72)
    for name, thruster, colour in (("forward", forward, BLUE), ("aft", aft, ORANGE)):
        factor = np.asarray(tunnel.force_factor(ratio, thruster.decay))
        centre = np.asarray(tunnel.suction_centre(thruster, ratio)) / thruster.position
        checked = ~tunnel.out_of_range(ratio, thruster.decay)
        axes.plot(ratio[checked], factor[checked], color=colour, label=f"$K_F$ {name}")
        axes.plot(
            ratio[checked], tunnel.moment_factor(factor, centre)[checked], "--", color=colour, label=f"$K_N$ {name}"
        )
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.set_xlabel("speed ratio $u/u_j$")
    axes.set_ylabel("ratio to the value at rest")
    axes.legend()
    alt = "Force and moment factors fall with the speed ratio; the aft thruster's moment changes sign near one half."
    return to_figure(figure, "tunnel-factors", alt)


def main() -> None:
    """Write every figure to this folder."""
    with style():
        figures = [("", figure) for figure in (*blanke(), avila_step_response(), tunnel_factors())]
        for name in ("avila-drag", "avila-added-mass"):
            analysis = identify(MISSIONS / "measured" / name)
            figures += [("avila-", pictures.panel_figure(panel)) for panel in analysis.panels]
        sweep = sweep_transition(missionplan.load(MISSIONS / "autosub-transition.yaml"))
        drawn = [unassisted_figure(sweep), *(history_figure(sweep, number) for number in (6, 7, 8, 9))]
        drawn += [energy_figure(sweep, "a"), energy_figure(sweep, "b"), pitch_by_variant(sweep)]
        figures += [("transition-", figure) for figure in drawn]
    for prefix, figure in figures:
        (HERE / f"{prefix}{figure.name}.svg").write_text(figure.svg, encoding="utf-8")


if __name__ == "__main__":
    main()
