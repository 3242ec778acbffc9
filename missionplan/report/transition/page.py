"""Report of `sweep-transition`: depth, pitch and energy of slowing down to hover."""

import shlex
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from missionplan.report.page import Drawing, Page, PageSection, Table, Terminal
from missionplan.report.quantities import quantity, span_of
from missionplan.report.transition.figures import (
    depth_by_mid_speed,
    depth_by_steepness,
    draw_energy,
    draw_histories,
    energy_figure,
    pitch_by_mid_speed,
    pitch_by_steepness,
    pitch_by_variant,
    pitch_of,
    rise_of,
    unassisted_figure,
)
from missionplan.results.transition import FORCE, PAIR, SUCTION, TransitionSweep


def page(result: TransitionSweep) -> Page:
    """Build the page of a sweep."""
    made = result.provenance
    phase = shlex.quote(str(made.options["phase"]))
    return Page(
        title="Transition from survey speed to hover",
        answer=answer(result),
        figure=unassisted_figure(result),
        numbers=_numbers(result),
        sections=_sections(result),
        rerun=f"missionplan sweep-transition {shlex.quote(made.file)} --phase {phase}",
    )


def terminal(result: TransitionSweep) -> Terminal:
    """Build the terminal's view of a sweep."""
    cells = result.shown(FORCE)
    cells = cells[cells["steepness_m_s"] == cells["steepness_m_s"].median()]
    names = ("mid_speed_m_s", "depth_excursion_m", "pitch_excursion_rad", "energy_common_wh", "energy_to_hover_wh")
    rows = [
        (
            quantity(speed, "m/s", "g"),
            quantity(depth, "m", ".2f"),
            f"{np.degrees(pitch):.1f}°",
            f"{common:.1f} W h",
            f"{own:.1f} W h",
        )
        for speed, depth, pitch, common, own in cells[list(names)].to_numpy(dtype=float)
    ]
    columns = ("mid-transition speed", "depth excursion", "pitch excursion", "energy, all hover", "it hovers")
    return Terminal(answer(result), columns, rows)


def answer(result: TransitionSweep) -> str:
    """Write below which speed the vehicle needs thrusters, and the speed at which they take least energy."""
    best = result.best
    slowest = result.saturation_speed
    alone = (
        f"cannot hold depth below {quantity(slowest, 'm/s', '.2f')}"
        if np.isfinite(slowest)
        else "holds depth at all speeds tried"
    )
    return (
        f"Without thrusters the vehicle {alone}. One tunnel thruster takes it to hover with least energy, "
        f"{best['energy_common_wh']:.1f} W h, at a mid-transition speed of "
        f"{quantity(best['mid_speed_m_s'], 'm/s', 'g')}, the best of those tried; it then strays from its "
        "depth by up to "
        f"{quantity(best['depth_excursion_m'], 'm', '.2f')}."
    )


def _numbers(result: TransitionSweep) -> list[tuple[str, str]]:
    hover, depth = result.hover, result.shown(FORCE)["depth_excursion_m"]
    return [
        ("Hover", f"{hover['revolutions_per_s']:.2f} rev/s, {hover['power_w']:.0f} W"),
        ("Hover with a pair", f"{hover['pair_power_w']:.0f} W"),
        ("Depth excursion", span_of(depth.min(), depth.max(), "m", ".2f")),
    ]


def _sections(result: TransitionSweep) -> list[PageSection]:
    energy = result.shown(FORCE)["energy_common_wh"]
    return [
        PageSection("Lower mid-transition speeds cost depth", [depth_by_mid_speed(result), depth_by_steepness(result)]),
        PageSection(
            "Pitch grows likewise, and keeps swinging at hover",
            [pitch_by_mid_speed(result), pitch_by_steepness(result)],
        ),
        PageSection(
            f"Slowing down takes {energy.min():.1f} to {energy.max():.1f} W h",
            [energy_figure(result, "a"), energy_figure(result, "b"), energy_table(result)],
        ),
        PageSection("A pair of thrusters damps the pitch", [pitch_by_variant(result), variant_table(result)]),
        PageSection("Limits of these results", [_limits(result)]),
    ]


def _limits(result: TransitionSweep) -> str:
    share = result.cells["energy_out_of_range"].max()
    return (
        "Derivatives, inertia, propeller and gains of the example are not Autosub's: the vehicle file marks what is "
        f"assumed or calibrated. At most {100 * share:.1f} % of a run's energy was spent beyond the force minimum, "
        "where the thrusters' exponential loss has not been checked. Stall of the sternplanes is not modelled."
    )


def energy_table(result: TransitionSweep) -> Table:
    """Tabulate the energy by option (a): mid-transition speeds down, steepnesses across."""
    table = result.energy(FORCE, "a")
    rows = [
        (quantity(speed, "m/s", "g"), *(f"{value:.2f}" for value in row))
        for speed, row in zip(table.index, table.to_numpy(), strict=True)
    ]
    return Table(
        ("mid-transition speed", *(quantity(float(s), "m/s", "g") for s in table.columns)),
        rows,
        "Energy until the slowest run of the set hovers (W\u202fh), by steepness.",
    )


def variant_table(result: TransitionSweep) -> Table:
    """Tabulate means over the grid at the shown deceleration, for each variant."""
    rows = []
    for variant in (FORCE, SUCTION, PAIR):
        cells = result.shown(variant)
        rows.append(
            (
                variant,
                quantity(cells["depth_excursion_m"].mean(), "m", ".2f"),
                f"{np.degrees(cells['pitch_excursion_rad']).mean():.1f}°",
                f"{np.degrees(cells['hover_pitch_rad']).mean():.3f}°",
                f"{cells['energy_common_wh'].mean():.2f} W h",
            )
        )
    columns = ("variant", "depth excursion", "pitch excursion", "pitch swing at hover", "energy, all hover")
    return Table(columns, rows, "Means over mid-transition speeds and steepnesses.")


def rise(axes: Axes, result: TransitionSweep) -> None:
    """Draw the rise above the target depth for each mid-transition speed."""
    draw_histories(axes, result.by_mid_speed, rise_of, "rise above target (m)")


def pitch(axes: Axes, result: TransitionSweep) -> None:
    """Draw the pitch for each mid-transition speed."""
    draw_histories(axes, result.by_mid_speed, pitch_of, "pitch (°)")


PLOTS: Mapping[str, Drawing] = {"energy": draw_energy, "rise": rise, "pitch": pitch}
"""Plots on given axes by name, the main one first."""
