"""Report of `tide`: how much of the current is tide, how well that forecasts, and the fragment of a mission."""

import math
from datetime import UTC, datetime
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.phases.recorded_currents import DEPTH_MARGIN
from missionplan.report.axes import mark_times, name_axis
from missionplan.report.diagnosis.kind_report import part
from missionplan.report.page import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PINK,
    SKY,
    YELLOW,
    Cells,
    Figure,
    Listing,
    Page,
    PageSection,
    Table,
    to_figure,
    typed,
)
from missionplan.report.quantities import Unit, quantity, reader_unit, with_error
from missionplan.report.wording import number
from missionplan.studies.tide.harmonic_analysis import ellipse_velocity
from missionplan.studies.tide.result import Constituent, DepthTide, TideResult

_COLOURS = (BLUE, ORANGE, GREEN, PINK, YELLOW, SKY)
_DRAWN = len(_COLOURS)


def draw_ellipses(axes: Axes, result: TideResult) -> None:
    """Draw the largest ellipses, each with a spoke to where the current is when the equilibrium tide is highest."""
    tide = result.shown
    angle = np.linspace(0.0, 2.0 * np.pi, 121)
    for wave, colour in zip(tide.constituents[:_DRAWN], _COLOURS, strict=False):
        east, north = ellipse_velocity(wave, angle)
        axes.plot(east, north, color=colour, label=f"{wave.name}{' (inferred)' if wave.inferred_from else ''}")
        axes.plot([0.0, east[0]], [0.0, north[0]], color=colour, linewidth=0.8)
    axes.plot([0.0, tide.east], [0.0, tide.north], color=GREY, linewidth=2.0, label="mean")
    axes.set(aspect="equal")
    name_axis(axes.xaxis, "east", "m/s")
    name_axis(axes.yaxis, "north", "m/s")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4)


def ellipses_figure(result: TideResult) -> Figure:
    """Draw the ellipses at the depth that is shown."""
    figure = MatplotlibFigure(figsize=(5.4, 4.2))
    axes = figure.add_subplot()
    draw_ellipses(axes, result)
    axes.set_aspect("equal", adjustable="datalim")
    names = ", ".join(wave.name for wave in result.shown.constituents[:_DRAWN])
    depth = quantity(result.shown_depth, "m", "g")
    return to_figure(
        figure,
        "ellipses",
        f"Tidal ellipses of {names or 'no constituent'} at {depth}, and the mean current.",
        f"The current at {depth} goes round each ellipse once a period; the spoke ends where it is when the "
        "equilibrium tide is highest at Greenwich.",
    )


def draw_record(axes: Axes, result: TideResult, component: Literal["east", "north"] = "east") -> None:
    """Draw one component of the record, and of the tide with the mean."""
    row = ("east", "north").index(component)
    axes.plot(_moments(result), result.measured[row], color=GREY, linewidth=0.7, label="measured")
    axes.plot(_moments(result), result.fitted[row], color=BLUE, linewidth=0.9, label="tide and mean")
    name_axis(axes.yaxis, component, "m/s")
    mark_times(axes.xaxis)


def record_figure(result: TideResult) -> Figure:
    """Draw the record and the tide with the mean, east above north, and what is left."""
    figure = MatplotlibFigure(figsize=(6.4, 5.4))
    upper, middle, lower = figure.subplots(3, 1, sharex=True)
    draw_record(upper, result, "east")
    draw_record(middle, result, "north")
    colours = {"east": ORANGE, "north": GREEN}
    for component, left in zip(colours, result.measured - result.fitted, strict=True):
        lower.plot(_moments(result), left, color=colours[component], linewidth=0.7, label=component)
    name_axis(lower.yaxis, "left", "m/s")
    lower.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    lower.set(xlabel="UTC")
    upper.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    at = f"The current at {quantity(result.shown_depth, 'm', 'g')}"
    alt = f"{at} as measured, and the tide with the mean, against time."
    return to_figure(figure, "record", alt, f"{at}; at the bottom what is left when tide and mean are taken out.")


def _moments(result: TideResult) -> Array:
    """Matplotlib's days: since the start of 1970."""
    return np.asarray(result.time / 86400.0)


_NINETY = 1.645
_AS_IT_IS = Unit("", 1.0)


def page(result: TideResult) -> Page:
    """Build the page of a tidal analysis."""
    made = result.provenance
    latitude, start = f"{made.options['latitude_deg']} deg", made.options["start"] or None
    return Page(
        title=f"Tide: {result.provenance.mission}",
        answer=answer(result),
        draw=lambda: ellipses_figure(result),
        numbers=_numbers(result.shown),
        write=lambda: [
            PageSection("What was measured, and the tide in it", [record_figure(result)]),
            _how_far(result),
            _in_a_mission(result),
            *(_constituents(tide) for tide in result.depths),
        ],
        rerun=typed("tide", made.file, latitude=latitude, start=start),
        table=lambda: _cells(result),
        plots={"ellipses": draw_ellipses, "record": draw_record},
    )


def _cells(result: TideResult) -> Cells:
    shown, speed = result.shown, reader_unit("m/s", 0.0)
    at = f"at {quantity(shown.depth, 'm', 'g')}"
    columns = (at, f"major{speed.axis}", f"minor{speed.axis}", "toward (°)", "phase (°)")
    return columns, [_row(wave) for wave in shown.constituents]


def answer(result: TideResult) -> str:
    """Say how much of the current is tide, and how well it can be forecast."""
    shown = result.shown
    where = f"at {quantity(shown.depth, 'm', 'g')}"
    if not shown.constituents:
        scatter = f"the current scatters by {quantity(shown.residual, 'm/s', '.2g')} about its mean"
        return f"No tide stands out of this record {where}: {scatter}."
    largest, speed = shown.constituents[0], reader_unit("m/s", 0.0)
    first = (
        f"The tide is {part(shown.tidal_share)} of the current's variance {where}, {largest.name} the largest "
        f"with {number(speed(largest.major), speed(largest.major_error))}{speed.suffix}."
    )
    within = quantity(_NINETY * shown.residual, "m/s", ".2g")
    forecast = f"A forecast should be within {within} of a component 9 times in 10"
    if shown.held_out is None:
        return f"{first} {forecast}, if what is left stays as it was; {result.days:.1f} days are too few to test it."
    times = f"{100.0 * shown.held_out.coverage:.0f} times in 100"
    return f"{first} {forecast}: the last quarter of the record, forecast from the rest, was so {times}."


def _numbers(tide: DepthTide) -> list[tuple[str, str]]:
    unit = reader_unit("m/s", max(abs(tide.east), abs(tide.north)))
    east, north, error = unit(tide.east), unit(tide.north), unit(tide.mean_error)
    mean = f"{number(east, error)} and {number(north, error)}{unit.suffix}, each ± {error:.2g}"
    return [
        ("Mean, east and north", mean),
        ("What is left, each component", quantity(tide.residual, "m/s", ".3f")),
        ("What is left lasts", f"{_hours(tide)} h".replace("<", "less than")),
    ]


def _hours(tide: DepthTide) -> str:
    """Write how long an error is remembered; less than six minutes is not told."""
    return f"{tide.residual_time / 3600.0:.1f}" if tide.residual_time >= 360.0 else "< 0.1"


def _how_far(result: TideResult) -> PageSection:
    down, speed = reader_unit("m", result.depths[-1].depth), reader_unit("m/s", 0.0)
    rows = [
        (
            down.cell(tide.depth, "g"),
            str(tide.samples),
            f"{100.0 * tide.tidal_share:.0f}",
            number(speed(tide.east), speed(tide.mean_error)),
            number(speed(tide.north), speed(tide.mean_error)),
            speed.cell(tide.residual, ".3f"),
            _hours(tide),
            f"{100.0 * tide.held_out.coverage:.0f}" if tide.held_out else "–",
        )
        for tide in result.depths
    ]
    columns = (
        f"depth{down.axis}", "samples", "tide, % of variance", f"mean east{speed.axis}", f"mean north{speed.axis}",
        f"left{speed.axis}",
        "lasts (h)", "last quarter within its 90 % (%)",
    )  # fmt: skip
    begins = datetime.fromtimestamp(result.begins, UTC)
    caption = (
        f"{result.days:.1f} days from {begins:%Y-%m-%d %H:%M} UTC, at latitude {math.degrees(result.latitude):.2f}°. "
        "What is left is one standard deviation of a component, the fit's own errors included."
    )
    short = [f"The record is {words}." for words in result.unresolved]
    return PageSection("How far it can be trusted", [Table(columns, rows, caption, text_columns=0), *short])


def _in_a_mission(result: TideResult) -> PageSection:
    lines = ["site:", "  current:", "    tide: tide.yaml", f"    error: {result.forecast_error}"]
    said = [
        "The error is what the tide does not forecast, at the depth where it is largest; without it the current would "
        "be taken as known."
    ]
    if result.depths[0].depth > DEPTH_MARGIN:
        lines.append("    outside: hold")
        said.append(
            "At the surface, where the vehicle takes its fixes, nothing was measured: `outside: hold` takes there the "
            "current of the shallowest depth. Without it the trials fail that come so far above the measurements."
        )
    first = "tide.yaml, in this folder, is the current of a mission that has a start and an origin:"
    return PageSection("In a mission", [first, Listing("\n".join(lines)), *said])


def _constituents(tide: DepthTide) -> PageSection:
    caption = (
        "One standard error after ±. A negative minor axis turns clockwise. The direction is that of the major axis, "
        "clockwise from north."
    )
    rows, speed = [_row(wave) for wave in tide.constituents], reader_unit("m/s", 0.0)
    columns = ("constituent", f"major{speed.axis}", f"minor{speed.axis}", "toward (°)", "Greenwich phase (°)")
    return PageSection(f"Constituents at {quantity(tide.depth, 'm', 'g')}", [Table(columns, rows, caption)])


def _row(wave: Constituent) -> tuple[str, ...]:
    speed = reader_unit("m/s", 0.0)
    pairs = [(speed(wave.major), speed(wave.major_error)), (speed(wave.minor), speed(wave.minor_error))]
    pairs += [(math.degrees(wave.toward), math.degrees(wave.toward_error))]
    pairs += [(math.degrees(wave.phase), math.degrees(wave.phase_error))]
    name = f"{wave.name} (from {wave.inferred_from})" if wave.inferred_from else wave.name
    cells = (
        number(value, max(0.01 * abs(value), 0.0001)) if math.isnan(error) else with_error(value, error, _AS_IT_IS)
        for value, error in pairs
    )
    return name, *cells
