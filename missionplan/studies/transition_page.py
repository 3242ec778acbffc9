"""Report of `sweep-transition`: depth, pitch and energy of slowing down to hover, after Palmer, Hearn & Stevenson."""

from collections.abc import Callable

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.errors import counted
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREEN, GREY, ORANGE, Cells, Figure, Page, PageSection, Table, to_figure, typed
from missionplan.report.quantities import as_written, quantity, span_of
from missionplan.studies.sweep_transition import FORCE, PAIR, SUCTION, TimeHistory, TransitionSweep

_SHOWN_UNTIL = 260.0
"""End of the histories, after the deceleration began [s]."""


def unassisted_figure(result: TransitionSweep) -> Figure:
    """Draw sternplane, pitch and depth without thrusters (Fig. 3)."""
    track = result.unassisted
    shown = (track.time >= -20.0) & (track.speed > 0.2)
    figure = MatplotlibFigure(figsize=(6.0, 5.0))
    angles, depth = figure.subplots(2, 1, sharex=True)
    angles.plot(track.time[shown], np.degrees(track.pitch[shown]), color=BLUE, label="pitch")
    angles.plot(track.time[shown], np.degrees(track.sternplane[shown]), color=ORANGE, label="sternplane")
    angles.set_ylabel("angle (°)")
    depth.plot(track.time[shown], -track.depth[shown], color=BLUE)
    name_axis(depth.yaxis, "rise above target", "m")
    depth.set_xlabel("time since the deceleration began (s)")
    if np.isfinite(result.saturation_speed):
        crossing = track.time[np.argmax(track.speed < result.saturation_speed)]
        for axes in (angles, depth):
            axes.axvline(crossing, color=GREY, linewidth=1.0, linestyle=":")
        point, corner = f"A: {quantity(result.saturation_speed, 'm/s', '.2f')}", (crossing, depth.get_ylim()[1])
        depth.annotate(point, corner, (-4, -4), textcoords="offset points", ha="right", va="top")
    angles.legend(loc="upper left")
    alt = "Pitch, sternplane and rise against time without thrusters."
    caption = "Without thrusters (the paper's Fig. 3); speed falls with time."
    return to_figure(figure, "fig-3-no-thrusters", alt, caption)


def _draw_histories(
    axes: Axes, result: TransitionSweep, y: Callable[[TimeHistory], Array], label: str, by_steepness: bool
) -> None:
    """Draw a line against time for each mid-transition speed, or for each steepness."""
    tracks = result.by_steepness if by_steepness else result.by_mid_speed
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(tracks)))
    for track, colour in zip(tracks, colours, strict=True):
        shown = (track.time >= 0.0) & (track.time <= _SHOWN_UNTIL)
        axes.plot(track.time[shown], y(track)[shown], color=colour, label=as_written(track.label, "m/s"), linewidth=1.3)
    axes.set_xlabel("time since the deceleration began (s)")
    axes.set_ylabel(label)
    axes.legend(ncols=2)


def history_figure(result: TransitionSweep, number: int) -> Figure:
    """Draw rise or pitch against time for each mid-transition speed or steepness (Figs. 6 to 9)."""
    by_steepness, figure = number in (7, 9), MatplotlibFigure()
    draw, what, word = (rise, "Rise above the target depth", "depth") if number < 8 else (pitch, "Pitch", "pitch")
    draw(figure.subplots(), result, by_steepness=by_steepness)
    varied = "steepness of the interchange" if by_steepness else "mid-transition speed u*"
    alt = f"{what} against time for each {varied}."
    return to_figure(figure, f"fig-{number}-{word}", alt, f"By {varied} (the paper's Fig. {number}).")


def rise(axes: Axes, result: TransitionSweep, *, by_steepness: bool = False) -> None:
    """Draw the rise above the target depth for each mid-transition speed, or for each steepness."""
    _draw_histories(axes, result, lambda track: -track.depth, "rise above target (m)", by_steepness)


def pitch(axes: Axes, result: TransitionSweep, *, by_steepness: bool = False) -> None:
    """Draw the pitch for each mid-transition speed, or for each steepness."""
    _draw_histories(axes, result, lambda track: np.degrees(track.pitch), "pitch (°)", by_steepness)


def energy_figure(result: TransitionSweep, option: str) -> Figure:
    """Draw energy against mid-transition speed for each steepness (Figs. 10 and 11)."""
    figure = MatplotlibFigure()
    draw_energy(figure.subplots(), result, option)
    until = "until the slowest run of the set hovers" if option == "a" else "until each run hovers"
    number = "10" if option == "a" else "11"
    alt = f"Thruster energy {until} against mid-transition speed, one line a steepness."
    caption = f"Energy {until}: option ({option}), the paper's Fig. {number}."
    return to_figure(figure, f"fig-{number}-energy", alt, caption)


def draw_energy(axes: Axes, result: TransitionSweep, option: str = "a") -> None:
    """Draw energy against mid-transition speed, a line for each steepness."""
    table = result.energy(FORCE, option)
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(table.columns)))
    for steepness, colour in zip(table.columns, colours, strict=True):
        label = quantity(float(steepness), "m/s", "g")
        axes.plot(table.index, table[steepness], "o-", color=colour, markersize=3, label=label)
    name_axis(axes.xaxis, "mid-transition speed", "m/s")
    axes.set_ylabel("energy (W\u202fh)")
    axes.set_ylim(bottom=0.0)
    axes.legend(title="steepness", ncols=2)


def pitch_by_variant(result: TransitionSweep) -> Figure:
    """Draw pitch against time for one thruster, one with suction, and a pair (Fig. 14)."""
    figure = MatplotlibFigure()
    axes = figure.subplots()
    for track, colour, dash in zip(result.by_variant, (BLUE, ORANGE, GREEN), ("-", "--", "-"), strict=True):
        shown = track.time >= 0.0
        axes.plot(track.time[shown], np.degrees(track.pitch)[shown], dash, color=colour, label=track.label)
    axes.set_xlabel("time since the deceleration began (s)")
    axes.set_ylabel("pitch (°)")
    axes.legend()
    alt = "Pitch against time of the three variants: one thruster, one with suction, a pair."
    return to_figure(figure, "fig-14-pitch", alt, "The three variants (the paper's Fig. 14).")


def page(result: TransitionSweep) -> Page:
    """Build the page of a sweep."""
    made = result.provenance
    return Page(
        title="Transition from survey speed to hover",
        answer=answer(result),
        draw=lambda: unassisted_figure(result),
        numbers=_numbers(result),
        write=lambda: _sections(result),
        rerun=typed("sweep-transition", made.file, phase=made.options["phase"]),
        table=lambda: _cells(result),
        plots={"energy": draw_energy, "rise": rise, "pitch": pitch},
    )


def _cells(result: TransitionSweep) -> Cells:
    cells = result.shown(FORCE)
    cells = cells[cells["steepness_m_s"] == cells["steepness_m_s"].quantile(interpolation="lower")]
    names = ("mid_speed_m_s", "depth_excursion_m", "pitch_excursion_rad", "energy_common_wh", "energy_to_hover_wh")
    rows = [
        (
            quantity(speed, "m/s", "g"),
            quantity(depth, "m", ".2f"),
            f"{np.degrees(pitch):.1f}°",
            *(f"{energy:.1f} W h" if np.isfinite(energy) else "never" for energy in (common, to_hover)),
        )
        for speed, depth, pitch, common, to_hover in cells[list(names)].to_numpy(dtype=float)
    ]
    columns = ("mid-transition speed", "depth excursion", "pitch excursion", "energy, all hover", "it hovers")
    return columns, rows


def answer(result: TransitionSweep) -> str:
    """Write below which speed the vehicle needs thrusters, and the speed at which they take least energy."""
    best, hovers = result.best, np.isfinite(result.shown(FORCE)["hover_time_s"])
    slowest = result.saturation_speed
    alone = "holds depth at all speeds tried"
    if np.isfinite(slowest):
        alone = f"cannot hold depth below {quantity(slowest, 'm/s', '.2f')}"
    if not hovers.all():
        runs = counted(len(hovers), "run")
        return f"Without thrusters the vehicle {alone}. With one tunnel thruster it hovers in {hovers.sum()} of {runs}."
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
    return [
        PageSection("Depth by speed and steepness of the interchange", [history_figure(result, n) for n in (6, 7)]),
        PageSection("Pitch by the same", [history_figure(result, number) for number in (8, 9)]),
        PageSection("Energy by the same", [*(energy_figure(result, letter) for letter in "ab"), energy_table(result)]),
        PageSection("One thruster, with suction, and a pair", [pitch_by_variant(result), variant_table(result)]),
        PageSection("Limits of these results", [_limits(result)]),
    ]


def _limits(result: TransitionSweep) -> str:
    share = result.cells["energy_out_of_range"].max()
    return (
        "Derivatives, inertia, propeller and gains are those of the vehicle file: see there what is assumed. "
        f"At most {100 * share:.1f} % of a run's energy was spent beyond the force minimum, "
        "where the thrusters' exponential loss has not been checked. Stall of the sternplanes is not modelled."
    )


def _energy(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "–"


def energy_table(result: TransitionSweep) -> Table:
    """Tabulate the energy by option (a): mid-transition speeds down, steepnesses across."""
    table = result.energy(FORCE, "a")
    rows = [
        (quantity(speed, "m/s", "g"), *(_energy(value) for value in row))
        for speed, row in zip(table.index, table.to_numpy(), strict=True)
    ]
    return Table(
        ("mid-transition speed", *(quantity(float(s), "m/s", "g") for s in table.columns)),
        rows,
        "Energy until the slowest run of the set hovers (W\u202fh), by steepness.",
    )


def variant_table(result: TransitionSweep) -> Table:
    """Tabulate means over the grid at the shown deceleration, for each variant."""
    rows = [
        (
            variant,
            quantity(cells["depth_excursion_m"].mean(), "m", ".2f"),
            f"{np.degrees(cells['pitch_excursion_rad']).mean():.1f}°",
            f"{np.degrees(cells['hover_pitch_rad']).mean():.3f}°",
            f"{_energy(cells['energy_common_wh'].mean(skipna=False))} W h",
        )
        for variant in (FORCE, SUCTION, PAIR)
        for cells in (result.shown(variant),)
    ]
    columns = ("variant", "depth excursion", "pitch excursion", "pitch swing at hover", "energy, all hover")
    return Table(columns, rows, "Means over mid-transition speeds and steepnesses.")
