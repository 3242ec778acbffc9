"""The sheet for the boat: when the vehicle is expected, when to worry, and where to search."""

import math
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta

import numpy as np
from matplotlib.axes import Axes

from missionplan.arrays import Array
from missionplan.errors import counted
from missionplan.exporters.geojson import collection, feature, longitudes_latitudes
from missionplan.moments import moment_of, zone_written
from missionplan.report.axes import column_of_panels, name_axis
from missionplan.report.page import BLUE, GREEN, INK, ORANGE, PINK, Block, Figure, PageSection, Table, to_figure
from missionplan.report.plan_view import WIDTH, frame
from missionplan.report.quantities import in_reader_units, quantity, reader_system, reader_unit
from missionplan.report.simulation.quantities import failure_in_words
from missionplan.report.wording import listed, number, portion_in_words
from missionplan.results.simulation import Outcome
from missionplan.results.whereabouts import SHARES, Overdue, SearchArea

_COLOURS = {"not released": GREEN, "adrift at the surface": ORANGE, "on the seafloor": PINK, "still under way": BLUE}
_LABEL_OFF = 0.04
"""Distance of a label from its area, as a share of the map's width."""
_SIDES = np.array([(np.sin(angle), np.cos(angle)) for angle in np.radians(np.arange(0.0, 360.0, 30.0))])
"""Directions from an area in which its label may stand, north first."""


def overdue_section(outcome: Outcome) -> Iterator[PageSection]:
    """Build the sheet, where enough trials come back to make one."""
    sheet = outcome.overdue
    if sheet is None:
        return
    start = _start(outcome)
    blocks: list[Block] = [_why(sheet, start), _times(sheet, start), _map(outcome, sheet), _areas(outcome, sheet)]
    words = (
        "Not released: within the circle about the mooring, line and all. Adrift: from a surfacing after the mooring "
        "on (from any where there is none), or from where the trials that failed were last at a fix. On the "
        "seafloor, and still under way: on the legs. “Assumed”: too few trials failed so, and all are assumed "
        "to, at a moment as likely as any other. The shares are those of the model, which assumes: "
    )
    yield PageSection(
        f"If it does not come back: worry after {_clock(sheet.worry_after, start)}",
        [
            *blocks,
            words + in_reader_units(" ".join(sheet.assumptions)),
            *_battery(sheet),
        ],
        is_sheet=True,
    )


def _start(outcome: Outcome) -> datetime | None:
    """The mission's start in the zone in which the mission has it; None where it gives none."""
    written = outcome.provenance.data.get("start")
    try:
        return None if written is None else moment_of(written).astimezone(zone_written(written))
    except (ValueError, OverflowError):
        return None


def _clock(seconds: float, start: datetime | None) -> str:
    """Write a time since the start in hours and minutes, rounded up, with the time of day where it is known.

    Empty for a time that the trials cannot tell.
    """
    if math.isnan(seconds):
        return ""
    words = f"{_hours_minutes(seconds)}\u00a0h"
    if start is None:
        return words
    moment = start + timedelta(minutes=math.ceil(seconds / 60.0))
    local = "" if not start.utcoffset() else f", {moment:%d %b %H:%M} {moment.isoformat()[-6:]}"
    return f"{words} ({moment.astimezone(UTC):%d %b %H:%M} UTC{local})"


def _hours_minutes(seconds: float) -> str:
    if math.isnan(seconds):
        return ""
    minutes = math.ceil(seconds / 60.0)
    return f"{minutes // 60}:{minutes % 60:02d}"


def _why(sheet: Overdue, start: datetime | None) -> str:
    back = sheet.times[-1]
    of = {0.999: "999 of 1000", 0.99: "99 of 100", 0.95: "19 of 20"}[sheet.worry_share]
    words = (
        f"By {_clock(sheet.worry_after, start)} after the start, {of} missions that come back are back; half "
        f"are by {_clock(back.p50, None)}."
    )
    if sheet.worry_share < 0.999:
        words += " So few trials tell of no later hour; some 2300 that come back tell of 999 in 1000."
    if not sheet.missing:
        return f"{words} In the model every mission comes back: what keeps it away is not in the model."
    worst = max(sheet.missing, key=lambda step: sheet.missing[step])
    share = 100.0 * sum(sheet.missing.values())
    most = "most of them" if 100.0 * sheet.missing[worst] > 0.5 * share else "most often"
    reason = failure_in_words(worst)
    return f"{words} {number(share, 0.1 * share)} % never do in the model, {most} because of {reason}."


def _times(sheet: Overdue, start: datetime | None) -> Table:
    has_energy = any(math.isfinite(time.energy_left) for time in sheet.times)
    digits = 1 + (0.95, 0.99, 0.999).index(sheet.worry_share)
    rows = []
    for time in sheet.times:
        *before, latest = (time.p50, time.p95, time.p99, time.p999)[: digits + 1]
        clocks = [_hours_minutes(value) for value in before]
        last = _clock(latest, start) if start else _hours_minutes(latest)
        energy = [number(time.energy_left, 0.05 * abs(time.energy_left) + 0.1)] if has_energy else []
        rows.append((time.name, portion_in_words(time.share), *clocks, last, *energy))
    columns = ["at the surface", "trials", *("50 %", "95 %", "99 %", "99.9 %")[: digits + 1]]
    caption = "Hours and minutes since the start by which that share of the trials is there."
    if any("" in row for row in rows):
        caption += " Blank: too few trials to tell."
    if has_energy:
        columns.append("battery left (W h)")
        caption += " Battery: all but 5 % have more; use taken as even within each phase."
    return Table(columns, rows, caption)


def _map(outcome: Outcome, sheet: Overdue) -> Figure:
    """Draw the search areas; of the drift, one for each number of hours overdue."""
    drawn = [area for area in sheet.areas if area.share == SHARES[-1]]
    shown = frame([], [area.points for area in drawn], tallest=0.75)  # on paper it stands between two tables
    above = 0.15 + 0.2 * math.ceil(len({area.way for area in drawn}) / 2)
    figure, (axes,) = column_of_panels(WIDTH, [(WIDTH - 0.95) * shown.shape], (0.8, 0.15, 0.5, above))
    named: set[str] = set()
    for area in drawn:
        for ring in (ring for rings in area.polygons for ring in rings):
            label = None if area.way in named else area.way
            named.add(area.way)
            axes.plot(*(ring / 1000.0), color=_COLOURS[area.way], linewidth=1.3, label=label)
    _name_hours(axes, drawn, shown.limits)
    for position in outcome.tracks.targets.values():
        axes.plot(*(np.array(position[0]) / 1000.0), "+", color=INK, markersize=7)  # an area may be too small to see
    limits = shown.limits / 1000.0
    axes.set(xlim=limits[0], ylim=limits[1], aspect="equal")
    name_axis(axes.xaxis, "east", "km")
    name_axis(axes.yaxis, "north", "km")
    figure.legend(loc="upper center", ncols=2)
    words = listed(list(dict.fromkeys(_where(area) for area in drawn)))
    return to_figure(
        figure,
        "search-areas",
        f"Map of search areas, each of which holds 95 % of the trials: {words}.",
        "Each line holds 95 % of the trials. A vehicle adrift is carried by the surface current and the wind; its "
        "areas are for the hours overdue. Crosses: goals and moorings.",
        origin=outcome.tracks.origin,
    )


def _name_hours(axes: Axes, drawn: Sequence[SearchArea], limits: Array) -> None:
    """Write the hours beside the areas of the drift, each where the map's edge, lines and other hours are farthest."""
    taken = np.concatenate([area.points for area in drawn], axis=1)
    several = len({area.after for area in drawn if area.overdue > 0.0}) > 1
    off = _LABEL_OFF * float(np.ptp(limits[0]))
    for area in sorted((area for area in drawn if area.overdue > 0.0), key=lambda area: area.centre_east):
        edges = area.points[:, np.argmax(_SIDES @ area.points, axis=1)]
        places = edges + off * _SIDES.T
        gaps = (places[:, :, None] - taken[:, None, :]) * [[[0.5]], [[1.0]]]  # words are wider than high
        edge = np.min((places - limits[:, :1]) * (limits[:, 1:] - places) > 0.0, axis=0)
        room = np.minimum(np.min(np.hypot(*gaps), axis=1), 0.9 * off)
        best = int(np.argmax(room * edge))
        east, north = place = places[:, best]
        align = ("right", "center", "left")[1 + round(_SIDES[best, 0])]  # away from the area
        taken = np.concatenate((taken, np.tile(place[:, None], 2)), axis=1)
        words = f"{f'{area.after} ' if several else ''}+{area.overdue / 3600.0:.0f}\u00a0h"
        axes.text(east / 1000.0, north / 1000.0, words, fontsize=8, ha=align, va="center", color=INK)


def _areas(outcome: Outcome, sheet: Overdue) -> Table:
    """One row a way and hour: where to begin, and how large the area of 95 % is."""
    rows = [
        (
            f"{_where(area)}, {'assumed' if area.is_assumed else counted(area.trials, 'trial')}",
            _hours(area),
            _place(outcome, (area.densest_east, area.densest_north)),
            _size(area),
            _area(area),
            *([portion_in_words(area.missed)] if sheet.searches else []),
        )
        for area in sheet.areas
        if area.share == SHARES[-1]
    ]
    columns = ["way to fail", "overdue", "begin at", "half axes", "area"]
    caption = (
        "Overdue: hours after the time at which to worry. Begin at: where the vehicle is most likely. Half axes: of "
        "the ellipse that is like the area, and the course of the longer. Areas hold 95 % of the trials; "
        "search-areas.csv and the GeoJSON have those of 50 and 90 % too."
    )
    if sheet.searches:
        columns.append("missed by searches")
        caption += f" What is left after nothing was found in {counted(sheet.searches, 'searched area')}."
    return Table(columns, rows, caption)


def _where(area: SearchArea) -> str:
    if not area.after:
        return area.way
    return f"{area.way} ({'at' if area.way == 'not released' else 'after'} {area.after})"


def _hours(area: SearchArea) -> str:
    drifts = area.way == "adrift at the surface"
    return f"{area.overdue / 3600.0:.0f}\u00a0h" if drifts else "at any time"


def _size(area: SearchArea) -> str:
    if area.half_length == area.half_width:
        return f"{quantity(area.half_length, 'm', '.0f')} (circle)"
    unit = reader_unit("m", area.half_length)
    length, width = (number(unit(half), 0.02 * unit(half)) for half in (area.half_length, area.half_width))
    return f"{length} × {width}{unit.suffix}, {math.degrees(area.toward):.0f}°"


_AREAS = {
    "": (("m²", 1.0), ("km²", 1e6)),
    "nautical": (("m²", 1.0), ("nmi²", 1852.0**2)),
    "imperial": (("ft²", 0.3048**2), ("mi²", 1609.344**2)),
}
"""Units of small and of large areas by the reader's system, and their sizes [m²]."""


def _area(area: SearchArea) -> str:
    """Write an area in squares of the reader's unit of distance."""
    small, large = _AREAS.get(reader_system(), _AREAS[""])
    unit, size = small if area.area < 1e4 else large
    return f"{number(area.area / size, 0.05 * area.area / size)}\u00a0{unit}"


def _place(outcome: Outcome, place: tuple[float, float]) -> str:
    """Write a place in degrees and minutes, as charts have them."""
    origin = outcome.tracks.origin
    if origin is None:
        return f"{quantity(place[0], 'm', '.0f')} E, {quantity(place[1], 'm', '.0f')} N"
    ((longitude, latitude),) = longitudes_latitudes(np.array(place)[:, None], origin)
    return f"{in_minutes(latitude, 'NS')}, {in_minutes(longitude, 'EW')}"


def in_minutes(angle: float, signs: str) -> str:
    """Write an angle [deg] in degrees and minutes with the sign's letter: ``60° 06.05′ N``."""
    hundredths = round(abs(angle) * 6000.0)
    degrees, minutes = divmod(hundredths, 6000)
    return f"{degrees}°\u00a0{minutes / 100.0:05.2f}′\u00a0{signs[angle < 0.0]}"


def _battery(sheet: Overdue) -> Iterator[str]:
    """Say that the sheet knows nothing of the battery, where it does not."""
    if not any(math.isfinite(time.energy_left) for time in sheet.times):
        yield (
            "Battery: the mission says nothing of it (energy.capacity), so that this sheet cannot tell how long the "
            "vehicle can hold a position, answer or run its beacon."
        )


def search_areas_geojson(outcome: Outcome) -> str | None:
    """Write the search areas as polygons; None without areas or without an origin."""
    sheet, origin = outcome.overdue, outcome.tracks.origin
    if sheet is None or origin is None:
        return None
    features = (
        feature(
            "MultiPolygon",
            [[longitudes_latitudes(ring, origin) for ring in rings] for rings in area.polygons],
            "search area",
            name=f"{_where(area)}, {_hours(area)}, {100.0 * area.share:.0f} %",
            **area.row(),
        )
        for area in sheet.areas
    )
    return collection(outcome.provenance.mission, features)
