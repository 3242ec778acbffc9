"""What each leg of an import rests on: one table of all, and a picture with its table of one."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREY, ORANGE, PINK, SKY, PageSection, Table, to_figure
from missionplan.report.quantities import quantity
from missionplan.results.imported import Basis, ImportedData, LegPicture

COLUMNS = ("leg", "counts?", "fix before", "fix after", "dead reckoning", "surfaced by", "depth", "heading", "speed")
_JUDGED = {
    "flag": "valid by its flag",
    "quality": "good by its stated quality",
    "neighbours": "poor by its stated quality, confirmed by a good fix near in time",
    "place": "nothing is stated of it; it does not jump from its neighbours",
}
_ZERO = {"state": "by the vehicle's own state", "fixes": "by its depth at the fixes", "assumed": "assumed"}
_SHORT = {"neighbours": "neighbours", "flag": "flag", "quality": "quality", "place": "no jump"}


def basis_rows(dives: pd.DataFrame, basis: Basis) -> list[tuple[str, ...]]:
    """Rows of the table of all legs, shape as `COLUMNS`."""
    return [
        (
            str(dive["leg"]),
            "yes" if dive["ok"] else str(dive["reason"]),
            *(_doubted(_SHORT[dive[f"fix_{side}_by"]], ", ", dive[f"fix_{side}_sd_m"]) for side in ("before", "after")),
            _doubted(dive["dr_by"], " ± ", dive["dr_sd_m"]),
            "depth" if dive["depth_readings"] else "the fix",
            quantity(dive["depth_m"], "m", ".0f") if math.isfinite(dive["depth_m"]) else "none",
            f"{dive['heading_deg']:.0f} deg" if dive["heading_readings"] else "none",
            quantity(dive["speed_m_s"], "m/s", ".2f") if math.isfinite(dive["speed_m_s"]) else "none",
        )
        for _, dive in dives.iterrows()
    ]


def _doubted(by: str, sign: str, sd: float) -> str:
    return f"{by}{sign}{quantity(sd, 'm', '.0f')}" if math.isfinite(sd) else by


def common_words(basis: Basis) -> str:
    """Say what all legs rest on alike."""
    return (
        f"The surface is {quantity(basis.surface_depth, 'm', '.1f')} below what the gauge reads there, "
        f"{quantity(basis.gauge_zero, 'm', '.1f')} ({_ZERO[basis.gauge_zero_by]}); a dive reaches "
        f"{quantity(basis.dive_depth, 'm', '.1f')}. Headings: from {basis.heading}. Speeds: {basis.speed}. A leg "
        f"lasts {basis.shortest / 60.0:.3g} min at least, with no gap in the log under water above "
        f"{basis.longest_gap:.0f} s."
    )


def explained_rows(result: ImportedData, picture: LegPicture) -> Iterator[tuple[str, str]]:
    """Say of one leg what it rests on, and why it counts or does not."""
    dive, basis = result.dives.iloc[picture.row], result.basis
    if basis is None:
        return
    yield "counts?", "yes" if dive["ok"] else f"no: {dive['reason']}"
    for side, t in (("before", dive["t_start"]), ("after", dive["t_end"])):
        sd = dive[f"fix_{side}_sd_m"]
        stated = f"{quantity(sd, 'm', '.1f')} each axis" if math.isfinite(sd) else "its accuracy is not stated"
        yield f"fix {side}", f"{t}: {_JUDGED[dive[f'fix_{side}_by']]}; {stated}"
    if picture.reasons:
        yield (
            "fixes left out near it",
            "; ".join(f"{picture.reasons.count(reason)}: {reason}" for reason in dict.fromkeys(picture.reasons)),
        )
    lag = dive["lag_dr_end_s"]
    last = f", the last {lag:.0f} s before the fix" if math.isfinite(lag) else ""
    doubt = dive["dr_sd_m"]
    by = f"; in doubt by {quantity(doubt, 'm', '.0f')}" if math.isfinite(doubt) else ""
    yield "dead reckoning", f"{dive['dr_by']} ({result.reckoning}): {dive['dr_positions']} positions{last}{by}"
    yield "share of its time covered", f"{100.0 * dive['covered']:.0f} %"
    if dive["depth_readings"]:
        yield "surfaced", f"{dive['surface_s']:.0f} s before the fix, where it came above the surface's depth"
        depths = f"mean {quantity(dive['depth_m'], 'm', '.1f')}, greatest {quantity(dive['max_depth_m'], 'm', '.1f')}"
        yield "depth", f"{depths}, {dive['depth_readings']} readings"
    else:
        yield "surfaced", "at the fix: no depth was logged"
    yield "longest gap under water", f"{dive['gap_s']:.0f} s ({basis.longest_gap:.0f} s at most)"
    if dive["heading_readings"]:
        average = f"{dive['heading_deg']:.0f} deg on average"
        yield "heading", f"{average}, {dive['heading_readings']} readings, {basis.heading}"
    if math.isfinite(dive["speed_m_s"]):
        yield "speed", f"{quantity(dive['speed_m_s'], 'm/s', '.2f')} by {basis.speed}"
    duration = (dive["t_end_s"] - dive["t_start_s"]) / 60.0
    yield "from fix to fix", f"{duration:.1f} min ({basis.shortest / 60.0:.3g} min at least)"
    if math.isfinite(dive["error_m_s"]):
        error = quantity(dive["error_m_s"] * duration * 60.0, "m", ".0f")
        yield "error", f"{error}, {quantity(dive['error_m_s'], 'm/s', '.3f')} over that time"


def explained_section(result: ImportedData, picture: LegPicture) -> PageSection:
    """Section of one leg: its picture and its table."""
    leg = result.dives["leg"].iloc[picture.row]
    table = Table(("", f"leg {leg}"), list(explained_rows(result, picture)), text_columns=2)
    figure = MatplotlibFigure(figsize=(6.0, 6.4))
    places, times = figure.subplots(2, 1, gridspec_kw={"height_ratios": (3, 2)})
    draw_places(places, result, picture)
    draw_times(times, result, picture)
    alt = (
        f"Leg {leg}: above, a map of the fixes about it, its dead-reckoned way and the error; below, the depth against "
        "time, with the moments of the fixes."
    )
    caption = (
        "Fixes from a quarter of an hour before the leg to one after it. Dotted: surfacing (grey) and the last "
        "dead-reckoned position (blue); the level line is the surface."
    )
    drawn = to_figure(figure, f"leg-{leg}", alt, caption)
    return PageSection(f"Leg {leg}: what it rests on", [drawn, table])


def draw_places(axes: Axes, result: ImportedData, picture: LegPicture) -> None:
    """Draw fixes, dead-reckoned way and error of a leg."""
    dive = result.dives.iloc[picture.row]
    end = picture.fix_t == dive["t_end_s"] - dive["t_start_s"]
    after, lines = picture.fixes[:, end], [picture.fixes, picture.reckoned]
    if picture.reckoned.size:
        axes.plot(
            *picture.reckoned, color=BLUE if dive["ok"] else GREY, label="dead-reckoned", marker=".", markersize=2
        )
        if after.size:
            pair = np.stack([picture.reckoned[:, -1], after[:, 0]], axis=1)
            axes.plot(*pair, color=ORANGE, linewidth=2, label="error")
    axes.plot(*picture.fixes, "o", color=SKY, markersize=4, label="fixes")
    near = inside(picture.rejected, np.concatenate(lines, axis=1))
    if near.size:
        axes.plot(*near, "x", color=PINK, label="fixes left out")
    axes.plot(0.0, 0.0, "^", color=ORANGE, label="fix before")
    axes.plot(*after, "v", color=ORANGE, label="fix after")
    axes.set_aspect("equal", adjustable="datalim")
    name_axis(axes.xaxis, "east of the fix before", "m")
    name_axis(axes.yaxis, "north of it", "m")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)


def inside(points: Array, shown: Array, *, margin: float = 1.0) -> Array:
    """Points within what is drawn, and a share of it about it."""
    if not points.size or not shown.size:
        return np.empty((2, 0))
    low, high = shown.min(axis=1, keepdims=True), shown.max(axis=1, keepdims=True)
    about = margin * (high - low)
    return np.asarray(points[:, np.all((points >= low - about) & (points <= high + about), axis=0)])


def draw_times(axes: Axes, result: ImportedData, picture: LegPicture) -> None:
    """Draw the depth of a leg against time, with the moments of fixes, surfacing and last dead-reckoned position."""
    dive, basis = result.dives.iloc[picture.row], result.basis
    duration = float(dive["t_end_s"] - dive["t_start_s"])
    if len(picture.depth):
        axes.plot(picture.depth_t / 60.0, picture.depth, color=BLUE, linewidth=0.9, marker=".", markersize=2)
    if basis is not None:
        axes.axhline(basis.surface_depth, color=GREY, linewidth=0.7)
    _ticks(axes, picture.fix_t, SKY)
    _ticks(axes, picture.rejected_t, PINK)
    _ticks(axes, [0.0, duration], ORANGE)
    axes.axvline((duration - float(dive["surface_s"])) / 60.0, color=GREY, linestyle=":")
    if len(picture.reckoned_t):
        axes.axvline(picture.reckoned_t[-1] / 60.0, color=BLUE, linestyle=":")
    axes.set(xlabel="time since the fix before (min)")
    name_axis(axes.yaxis, "depth", "m")
    axes.invert_yaxis()


def _ticks(axes: Axes, t: Sequence[float] | np.ndarray, colour: str) -> None:
    """Draw moments as ticks on the upper edge."""
    axes.plot(
        np.asarray(t) / 60.0,
        np.full(len(t), 1.0),
        "v",
        color=colour,
        transform=axes.get_xaxis_transform(),
        clip_on=False,
        markersize=5,
    )
