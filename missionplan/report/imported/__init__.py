"""Report of `import`: what was made of the logs, what the legs can and cannot show, and what to type next."""

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.ticker import MaxNLocator

from missionplan.arrays import Array
from missionplan.errors import counted
from missionplan.report.axes import name_axis
from missionplan.report.imported.leg_basis import (
    COLUMNS,
    basis_rows,
    common_words,
    explained_rows,
    explained_section,
    inside,
)
from missionplan.report.page import (
    BLUE,
    GREY,
    ORANGE,
    PINK,
    SKY,
    Block,
    Cells,
    Figure,
    Listing,
    Page,
    PageSection,
    Table,
    to_figure,
    typed,
)
from missionplan.report.quantities import quantity, reader_unit
from missionplan.results.imported import ImportedData

_HOUR = 3600.0
_WIDTH = 6.0
_KM = 5000.0
"""Extent from which maps are drawn in kilometres [m]."""


def track_figure(result: ImportedData) -> Figure:
    """Draw fixes, the dead-reckoned way of each dive, and an arrow from its end to the fix that shows its error."""
    counts, word = result.dives["ok"].to_numpy() == 1, _map_unit(result)[1]
    points = _drawn(result)
    size = np.maximum(np.ptp(points, axis=1), 1.0) if points.size else np.ones(2)
    figure = MatplotlibFigure(figsize=(_WIDTH, float(np.clip(0.9 + (_WIDTH - 0.9) * size[1] / size[0], 3.0, 8.0))))
    draw_track(figure.add_subplot(), result)
    return to_figure(
        figure,
        "track",
        f"Map of the track: {counted(int(counts.sum()), 'leg')} that count, "
        f"{counted(int((~counts).sum()), 'dive')} left out, and fixes; axes in {word}, north is up.",
        "Dead-reckoned way of each dive; the arrow goes from where it ends to the fix, the leg's error. Both axes have "
        "the same scale.",
    )


def _drawn(result: ImportedData) -> Array:
    lines = result.lines
    return np.concatenate([lines.fixes, *(line for line in lines.reckoned if line.size)], axis=1)


def _map_unit(result: ImportedData) -> tuple[float, str]:
    """Unit of the map's axes, as its size [m] and its name."""
    drawn = _drawn(result)
    extent = float(np.ptp(drawn, axis=1).max()) if drawn.size else 1.0
    return (1000.0, "km") if extent > _KM else (1.0, "m")


def draw_track(axes: Axes, result: ImportedData) -> None:
    """Draw fixes, dead-reckoned ways, and the errors as arrows."""
    lines, counts = result.lines, result.dives["ok"].to_numpy() == 1
    unit, word = _map_unit(result)
    for keep, colour, label in ((counts, BLUE, "legs that count"), (~counts, GREY, "dives left out")):
        chosen = [line.T / unit for line, kept in zip(lines.reckoned, keep, strict=True) if kept and line.shape[1] > 1]
        if chosen:
            axes.add_collection(LineCollection(chosen, colors=colour, linewidths=1.2, label=label))
    axes.plot(*(lines.fixes / unit), ".", color=SKY, markersize=3, label="fixes", zorder=2.5)
    near = inside(lines.rejected, lines.fixes, margin=0.5)
    if near.size:
        axes.plot(*(near / unit), "x", color=PINK, markersize=6, label="fixes rejected", zorder=4)
    ends = lines.leg_ends[:, :, counts] / unit  # by dead reckoning, and by the fixes after them
    if ends.size:
        arrows: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "width": 0.004, "zorder": 3}
        axes.quiver(*ends[0], *(ends[1] - ends[0]), color=ORANGE, label="errors", **arrows)
    axes.set(aspect="equal")
    name_axis(axes.xaxis, "east", word)
    name_axis(axes.yaxis, "north", word)
    axes.margins(0.06)
    points = _drawn(result) / unit
    if points.size:  # at least a quarter of the extent along each axis: a track due north has no width of its own
        low, high = points.min(axis=1), points.max(axis=1)
        least = 0.25 * max(float((high - low).max()), 1.0)
        west, south = np.where(high - low < least, 0.5 * (low + high - least), np.nan)
        if np.isfinite(west):
            axes.set_xlim(west, west + least)
        if np.isfinite(south):
            axes.set_ylim(south, south + least)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)


def _span(values: Array) -> tuple[float, float] | None:
    """Ends of a histogram: at least a tenth of the values apart, so that equal legs look equal."""
    if not values.size or not np.max(values) > 0.0:
        return None
    middle, half = 0.5 * (values.min() + values.max()), 0.5 * max(float(np.ptp(values)), 0.1 * float(values.max()))
    return float(middle - half), float(middle + half)


def histograms(result: ImportedData) -> Figure:
    """Draw how long the legs are that count, and where they go."""
    kept = result.dives["ok"].to_numpy() == 1
    start, end = result.lines.leg_starts[:, kept], result.lines.leg_ends[0][:, kept]
    way = end - start
    length, course = np.hypot(*way), np.arctan2(*way)
    unit, word = (1000.0, "km") if len(length) and length.max() > 2000.0 else (1.0, "m")
    figure = MatplotlibFigure(figsize=(_WIDTH, 2.8))
    left = figure.add_subplot(1, 2, 1)
    left.hist(length / unit, bins=min(max(len(length) // 2, 5), 20), range=_span(length / unit), color=SKY)
    left.yaxis.set_major_locator(MaxNLocator(integer=True))
    left.set(ylabel="legs")
    name_axis(left.xaxis, "length of a leg", word)
    right = figure.add_subplot(1, 2, 2, projection="polar")
    counts, edges = np.histogram(np.remainder(course, 2.0 * math.pi), bins=24, range=(0.0, 2.0 * math.pi))
    right.bar(edges[:-1], counts, width=np.diff(edges), align="edge", color=SKY)
    right.set(theta_zero_location="N", theta_direction=-1)
    right.set_xticks(np.radians([0, 90, 180, 270]), ["N", "E", "S", "W"])
    right.tick_params(axis="y", labelsize=7)
    return to_figure(
        figure,
        "legs",
        f"Two histograms of {counted(len(length), 'leg')}: their lengths, and the courses they go, as a rose.",
        "Lengths of the legs that count, by dead reckoning, and their courses (legs a sector of 15 deg).",
    )


def depth_figure(result: ImportedData) -> Figure | None:
    """Draw the depth against time while the vehicle dived, if it was logged: a clock that was wrong is not drawn."""
    lines, dives = result.lines, result.dives
    begin, end = float(dives["t_start_s"].min()), float(dives["t_end_s"].max())
    during = (lines.depth_t >= begin - _HOUR) & (lines.depth_t <= end + _HOUR)
    if np.count_nonzero(during) < 2:
        return None
    figure = MatplotlibFigure(figsize=(_WIDTH, 2.2))
    axes = figure.add_subplot()
    axes.plot((lines.depth_t[during] - begin) / _HOUR, lines.depth[during], color=BLUE, linewidth=0.7)
    axes.set(xlabel="time since the first dive (h)")
    name_axis(axes.yaxis, "depth", "m")
    axes.invert_yaxis()
    left = np.count_nonzero(~during)
    outside = f"{left} readings more than an hour from every dive are not drawn." if left else ""
    return to_figure(figure, "depth", f"Depth against time over {(end - begin) / _HOUR:.1f} h.", outside)


_LISTED = 60
"""Rows of a table on the page; the files hold all."""


def page(result: ImportedData) -> Page:
    """Build the page of an import."""
    common = f" {common_words(result.basis)}" if result.basis is not None and not result.pictures else ""
    return Page(
        title=f"Import: {result.name}",
        answer=answer(result),
        draw=lambda: track_figure(result) if result.kind == "transit" else None,
        numbers=_numbers(result),
        write=lambda: _sections(result),
        verdict="" if result.counted else "bad",
        rerun=typed("import", "SOURCE", out="DATASET", kind=result.kind, format=result.format),
        sentence=f"{answer(result)} Next, in that folder: {result.next_commands[0]}{common}",
        table=lambda: _cells(result),
        plots={"track": draw_track},
    )


def _sections(result: ImportedData) -> list[PageSection]:
    depth, mission = depth_figure(result), Listing(result.mission_text)
    starter = "In this folder; mission.yaml is a starter mission with what the log says, for you to correct:"
    lacking = any(verdict.startswith("no") for _, verdict in result.can_show)
    shows = "What these data can show, and what they cannot" if lacking else "What these data can show"
    blocks: list[Block] = [
        f"{counted(len(result.sources), 'file')} of the format {result.format}; checksums are in import.json."
    ]
    if len(result.rejected_fixes):
        counts = "; ".join(f"{count}: {reason}" for reason, count in result.rejected_reasons.items())
        blocks.append(
            f"Fixes that do not count: {len(result.rejected_fixes)} ({counts}). They are in rejected-fixes.csv."
        )
    if result.passed_over:
        blocks.append(f"Passed over: {counted(len(result.passed_over), 'file')}.")
        blocks.append(Listing("\n".join(result.passed_over[:_LISTED])))
    sections = [
        PageSection(shows, [Table(("what", "can it be seen?"), result.can_show, text_columns=2)]),
        PageSection("What to type next", [starter, Listing("\n".join(result.next_commands)), mission]),
        PageSection(_dives_heading(result), [*([depth] if depth else []), _dives_table(result)]),
        *(explained_section(result, picture) for picture in result.pictures),
        PageSection("What was read", blocks),
    ]
    if result.kind == "transit" and result.counted:
        sections.insert(1, PageSection("How long the legs are, and where they go", [histograms(result)]))
    return sections


def _cells(result: ImportedData) -> Cells:
    """Tabulate for a terminal: what legs rest on, or how many dives count and why others do not."""
    if result.pictures:
        rows = [
            row
            for picture in result.pictures
            for row in (("leg", str(result.dives["leg"].iloc[picture.row])), *explained_rows(result, picture))
        ]
        return ("what a leg rests on", ""), rows
    if result.basis is not None:
        return COLUMNS, basis_rows(result.dives.head(_LISTED), result.basis)
    return ("", "dives"), [
        ("dives that count", str(result.counted)),
        *((why, str(n)) for why, n in result.reasons.items()),
    ]


def answer(result: ImportedData) -> str:
    """Say what the logs hold."""
    things = "dives between fixes" if result.kind == "transit" else "dives"
    counted = f"{result.counted} of {len(result.dives)} {things} count"
    if result.kind != "transit":
        return f"{counted}."
    doubt = result.figures.made_reckoning_sd
    if doubt is not None and math.isfinite(doubt):
        return (
            f"The logs hold no dead reckoning: it was {result.reckoning}, and is in doubt by "
            f"{quantity(doubt, 'm', '.0f')} a leg (median). {counted} as legs."
        )
    return f"{counted} as legs; dead reckoning: {result.reckoning}."


def _numbers(result: ImportedData) -> list[tuple[str, str]]:
    if not result.is_of_legs:
        return []
    values = result.figures.summary()
    about = f"{values['velocity_error_mean_east_m_s']:.3f}, "
    about += quantity(values["velocity_error_mean_north_m_s"], "m/s", ".3f")
    return [
        ("Velocity error, each axis", f"{quantity(values['velocity_error_sigma_m_s'], 'm/s', '.3f')} about {about}"),
        ("Leg, median", f"{quantity(values['leg_length_m'], 'm', '.0f')} in {values['leg_duration_s'] / 60.0:.0f} min"),
        ("Fix, each axis", quantity(values["fix_sd_m"], "m", ".1f")),
    ]


def _dives_heading(result: ImportedData) -> str:
    left = len(result.dives) - result.counted
    return f"Every dive: {left} of {len(result.dives)} left out" if left else f"All {len(result.dives)} dives count"


def _dives_table(result: ImportedData) -> Table:
    shown = result.dives.head(_LISTED)
    more = f"The first {_LISTED} of {len(result.dives)}. " if len(result.dives) > _LISTED else ""
    if result.basis is not None:
        caption = f"{more}What each rests on. {common_words(result.basis)} All of it is in all-dives.csv."
        return Table(COLUMNS, basis_rows(shown, result.basis), caption, text_columns=len(COLUMNS))
    begins = shown["t_start"] if "t_start" in shown else pd.Series("", index=shown.index)
    reasons = shown["reason"].where(shown["ok"] == 0, "yes")
    unit = reader_unit("m", float(shown["max_depth_m"].max()))
    columns = (shown.iloc[:, 0], begins, result.durations[:_LISTED] / 60.0, shown["max_depth_m"], reasons)
    rows = [
        (str(name), str(begin).replace("T", "\u00a0")[:19], str(reason), f"{minutes:.1f}", unit.cell(depth, ".1f"))
        for name, begin, minutes, depth, reason in zip(*columns, strict=True)
    ]
    caption = f"{more}Times are UTC. All of it is in all-dives.csv."
    return Table(("dive", "begins", "counts?", "minutes", f"greatest depth{unit.axis}"), rows, caption, text_columns=3)
