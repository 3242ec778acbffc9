"""Figures of an exploration: curves along one axis, maps over two, and the front of what can be had."""

from datetime import UTC, datetime

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure as MatplotlibFigure
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.report.axes import mark_times, name_axis
from missionplan.report.page import BLUE, GREEN, GREY, INK, ORANGE, Figure, to_figure
from missionplan.report.quantities import PERCENT, Unit, unit_for, value_on
from missionplan.report.wording import capitalised, in_words, keys_in_words
from missionplan.results.decision import Axis
from missionplan.studies.exploration.result import DURATION, ENERGY, Cell, Exploration

_LEVELS = (50.0, 90.0, 99.0)
"""Contours of P(success) [%]."""
_FINE = 8
"""Least number of values of each key for contours: on a coarser map they cross the cells and one another."""


def name_of(axis: Axis) -> str:
    """Write what is varied: ``speed (ingress, egress)``."""
    return keys_in_words(axis.keys)


def quantities_shown(result: Exploration) -> list[str]:
    """Quantities and events of the cells that some trial reached."""
    keys = dict.fromkeys(key for cell in result.valid for key in (*cell.quantities, *cell.events))
    return [key for key in keys if any(np.isfinite(_mean(cell, key)) for cell in result.valid)]


def curves_figure(result: Exploration) -> Figure:
    """Draw P(success) and each quantity along the only axis."""
    keys = ["success", *quantities_shown(result)]
    figure = MatplotlibFigure(figsize=(6.0, 0.7 + 1.75 * len(keys)))
    panels = figure.subplots(len(keys), sharex=True, squeeze=False)[:, 0]
    axis = result.axes[0]
    x = positions(axis)
    for axes, key in zip(panels, keys, strict=True):
        _draw_curve(axes, result, key, x)
    _mark_axis(panels[-1], axis, x)
    best = result.best_cell
    return to_figure(
        figure,
        "explore",
        alt=f"Probability of success, energy and duration against {name_of(axis)}"
        + (f"; the best is {value_on(axis, best.place[0])}" if best else ""),
        caption="Bands: 95 % intervals of probabilities; between the 5 % and 95 % points of the trials of quantities. "
        "Filled circle: the best; open circles: the trials cannot tell them from it. "
        + ("Shaded: all requirements are met. " if result.windows else "")
        + "Gaps: no trial reaches the quantity, or the mission cannot be run.",
    )


def _draw_curve(axes: Axes, result: Exploration, key: str, x: "Array | NDArray[np.object_]") -> None:
    unit = _unit(result, key)
    low, middle, high = np.array([_spread(cell, key) for cell in result.cells]).T / unit.size
    if result.axes[0].numbers is None:
        axes.errorbar(x, middle, [middle - low, high - middle], fmt="o", color=BLUE, markersize=4)
    else:
        axes.fill_between(x, low, high, color=BLUE, alpha=0.2, linewidth=0.0)
        axes.plot(x, middle, ".-", color=BLUE, markersize=4, linewidth=1.0)
        for window in result.windows:  # those of one cell alone as a line
            if window.first == window.last:
                axes.axvline(x[window.first], color=GREEN, alpha=0.35, linewidth=4.0, zorder=0)
            else:
                axes.axvspan(x[window.first], x[window.last], color=GREEN, alpha=0.15, linewidth=0.0, zorder=0)
    good = np.array([cell.as_good for cell in result.cells])
    axes.plot(x[good], middle[good], "o", color=ORANGE, fillstyle="none", markersize=7)
    if result.best is not None:
        axes.plot(x[result.best], middle[result.best], "o", color=ORANGE, markersize=7)
    axes.set_title(f"{capitalised(_title(key))}{unit.axis}")
    if unit is PERCENT:
        axes.set_ylim(-4.0, 104.0)


def maps_figure(result: Exploration, key: str) -> Figure:
    """Draw P(success) or the mean of a quantity over two axes."""
    figure = MatplotlibFigure(figsize=(6.0, 4.3))
    _draw_map(figure.subplots(), result, key)
    first, second = result.axes
    return to_figure(
        figure,
        "explore" if key == "success" else f"map-{key.replace('.', '-')}",
        alt=f"Map of {_title(key)} over {name_of(second)} and {name_of(first)}",
        caption="Star: the best; dots: the trials cannot tell them from it. "
        + ("Orange outline: all requirements are met. " if result.has_requirements else "")
        + "Grey: the mission cannot be run, or no trial reaches the quantity.",
    )


def draw_exploration(axes: Axes, result: Exploration, quantity: str = "success") -> None:
    """Draw P(success) or the mean of a quantity: a curve along one key, a map over two."""
    if len(result.axes) == 2:
        _draw_map(axes, result, quantity)
        return
    x = positions(result.axes[0])
    _draw_curve(axes, result, quantity, x)
    _mark_axis(axes, result.axes[0], x)


def _draw_map(axes: Axes, result: Exploration, key: str) -> None:
    first, second = result.axes
    shape = (len(first.values), len(second.values))
    unit = _unit(result, key)
    values = np.array([_mean(cell, key) for cell in result.cells]).reshape(shape) / unit.size
    x, y = positions(second), positions(first)
    colours = "viridis" if unit is PERCENT else "viridis_r"
    shown, norm = np.ma.masked_invalid(values), Normalize(0.0, 100.0) if unit is PERCENT else None
    drawn = axes.pcolormesh(x, y, shown, cmap=colours, norm=norm, shading="nearest")
    without = np.ma.masked_where(np.isfinite(values), np.zeros(shape))
    axes.pcolormesh(x, y, without, cmap=ListedColormap(["#d5d8dc"]), shading="nearest")
    axes.figure.colorbar(drawn, ax=axes, label=f"{capitalised(_title(key))}{unit.axis}")
    inside = values[np.isfinite(values)]
    if min(shape) >= _FINE and inside.size >= 4 and inside.min() < inside.max():
        levels = [level for level in _LEVELS if inside.min() < level < inside.max()] if unit is PERCENT else 6
        if levels:
            lines = axes.contour(x, y, shown, levels=levels, colors=INK, linewidths=0.7)
            axes.clabel(lines, fmt="%g", fontsize=8)
    if min(shape) > 1:
        _outline_met(axes, result, x, y, shape)
    good = [cell.place for cell in result.cells if cell.as_good]
    axes.plot([x[place[1]] for place in good], [y[place[0]] for place in good], ".", color="white", markersize=4)
    if result.best_cell is not None:
        row, column = result.best_cell.place
        axes.plot(x[column], y[row], "*", color=ORANGE, markersize=14, markeredgecolor="white")
    _mark_axis(axes, second, x)
    _mark_axis(axes, first, y, vertical=True)
    axes.grid(visible=False)


def _outline_met(axes: Axes, result: Exploration, x: Array, y: Array, shape: tuple[int, int]) -> None:
    """Draw a line between cells that meet all requirements and those that do not."""
    met = np.array([result.has_requirements and cell.meets_all for cell in result.cells]).reshape(shape)
    framed, across, up = np.pad(met, 1), _edges(x), _edges(y)
    for row, column in zip(*np.nonzero(framed[1:, 1:-1] != framed[:-1, 1:-1]), strict=True):
        axes.plot(across[[column, column + 1]], up[[row, row]], color=ORANGE, linewidth=2.0, clip_on=False)
    for row, column in zip(*np.nonzero(framed[1:-1, 1:] != framed[1:-1, :-1]), strict=True):
        axes.plot(across[[column, column]], up[[row, row + 1]], color=ORANGE, linewidth=2.0, clip_on=False)


def _edges(at: Array) -> Array:
    between = 0.5 * (at[1:] + at[:-1])
    return np.concatenate(([1.5 * at[0] - 0.5 * at[1]], between, [1.5 * at[-1] - 0.5 * at[-2]]))


def positions(axis: Axis) -> Array:
    """Where the values of an axis lie: moments as days for Matplotlib, numbers, or else their order."""
    if axis.numbers is None:
        return np.arange(len(axis.values), dtype=float)
    return np.array(axis.numbers) / 86400.0 if axis.is_time else np.array(axis.numbers)


def _mark_axis(axes: Axes, axis: Axis, at: Array, *, vertical: bool = False) -> None:
    side = axes.yaxis if vertical else axes.xaxis
    words = capitalised(name_of(axis))
    if axis.unit:
        name_axis(side, words, axis.unit)
    else:
        side.set_label_text(words)
    if axis.is_time and axis.numbers is not None:
        days = [datetime.fromtimestamp(number, UTC) for number in axis.numbers]
        mark_times(side, one_day=days[0].date() == days[-1].date())
    elif axis.numbers is None:
        side.set_ticks(at, labels=list(axis.labels))


def front_figure(result: Exploration) -> Figure | None:
    """Draw P(success) against energy, coloured by duration; None where no energy is known."""
    cells = [cell for cell in result.valid if ENERGY in cell.quantities and np.isfinite(_mean(cell, ENERGY))]
    if len(cells) < 2:
        return None
    energy, duration = _unit(result, ENERGY), _unit(result, DURATION)
    figure = MatplotlibFigure(figsize=(6.0, 3.6))
    axes = figure.subplots()
    x = np.array([energy(_mean(cell, ENERGY)) for cell in cells])
    y = np.array([100.0 * cell.success.value for cell in cells])
    colour = np.array([duration(_mean(cell, DURATION)) for cell in cells])
    front = np.array([cell.on_front for cell in cells])
    axes.scatter(x[~front], y[~front], c=GREY, s=10, alpha=0.5, linewidths=0)
    drawn = axes.scatter(x[front], y[front], c=colour[front], cmap="viridis_r", s=45, edgecolors=INK, linewidths=0.6)
    figure.colorbar(drawn, label=f"Duration{duration.axis}")
    low = min(90.0, float(y.min()) - 4.0)
    axes.set(xlabel=f"Mean energy{energy.axis}", ylabel="P(success) (%)", ylim=(low, 100.0 + 0.04 * (100.0 - low)))
    return to_figure(
        figure,
        "front",
        alt="Probability of success against mean energy; the front of what can be had is coloured by duration",
        caption="Each dot is one that was tried; coloured: no other is as good in probability of success, mean "
        "energy and mean duration and better in one of them. Means are of the trials that reach the mission's end.",
    )


def _title(key: str) -> str:
    return "probability of success" if key == "success" else in_words(key)


def _unit(result: Exploration, key: str) -> Unit:
    if key == "success" or any(key in cell.events for cell in result.valid):
        return PERCENT
    phase, _, name = key.rpartition(".")
    typical = np.array([_mean(cell, key) for cell in result.valid])
    means = typical[np.isfinite(typical)]
    return unit_for(
        phase, name, result.provenance.data, typical=float(np.median(means)) if means.size else float("nan")
    )


def _mean(cell: Cell, key: str) -> float:
    return _spread(cell, key)[1]


def _spread(cell: Cell, key: str) -> tuple[float, float, float]:
    """Probability of a cell with its interval, or the mean between the 5 % and 95 % points; nan where it has none."""
    if cell.reason:
        return (float("nan"),) * 3
    if key == "success" or key in cell.events:
        probability = cell.success if key == "success" else cell.events[key]
        return probability.low, probability.value, probability.high
    statistic = cell.quantities[key]
    return statistic.p05, statistic.mean, statistic.p95
