"""Axes in the units of the reader: labels and round ticks; what is drawn stays in the units it was given."""

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, DateFormatter
from matplotlib.figure import Figure
from matplotlib.ticker import (
    AutoLocator,
    FixedLocator,
    FuncFormatter,
    Locator,
    LogFormatter,
    LogLocator,
    NullLocator,
    ScalarFormatter,
)

from missionplan.report.quantities import DIMENSIONS, Unit, reader_system, reader_unit
from missionplan.report.wording import typeset

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

_ROUND = (1.0, 2.0, 5.0)
_LARGE = 1e4
"""Extent from which a map is read in kilometres [m]."""


class _InUnit(Locator):
    """Places ticks where an axis of another unit has them.

    `inner`: of the axis in the other unit. `size`: of the other unit, in that of the axis. `bounds`: beyond which there
    is no tick, in the unit of the axis.
    """

    def __init__(self, inner: Locator, size: float, bounds: tuple[float, float]) -> None:
        self.inner, self.size, self.bounds = inner, size, bounds

    def __call__(self) -> list[float]:
        if self.axis is None:
            return []
        low, high = sorted(self.axis.get_view_interval())
        return self.tick_values(low, high)

    def tick_values(self, vmin: float, vmax: float) -> list[float]:
        """Return the places of the ticks between two values."""
        self.inner.set_axis(self.axis)
        ticks = self.size * np.asarray(self.inner.tick_values(vmin / self.size, vmax / self.size))
        margin = 1e-9 * self.size
        kept = ticks[(ticks >= self.bounds[0] - margin) & (ticks <= self.bounds[1] + margin)]
        return [float(tick) for tick in kept]


class _Set(ScalarFormatter):
    """Writes the numbers of ticks as every other number of a report."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return typeset(super().__call__(x, pos))


def set_ticks(drawn: Iterable["Axes"]) -> None:
    """Have the numbers of ticks written with thin spaces between groups of three."""
    for axis in (axis for axes in drawn for axis in (axes.xaxis, axes.yaxis)):
        if type(axis.get_major_formatter()) is ScalarFormatter:
            axis.set_major_formatter(_Set())


def size_of_unit(axis: "Axis") -> float:
    """Size of the unit in which an axis is read, in that in which it was drawn."""
    locator = axis.get_major_locator()
    return locator.size if isinstance(locator, _InUnit) else 1.0


def has_numbers(axis: "Axis") -> bool:
    """Whether an axis has numbers on a scale that can be read off; names and dates are none."""
    is_number = isinstance(axis.get_major_formatter(), ScalarFormatter | LogFormatter)
    is_number |= isinstance(axis.get_major_locator(), _InUnit)
    return is_number and axis.get_scale() in ("linear", "log")


def name_axis(axis: "Axis", words: str, unit: str, *, fontsize: float | None = None) -> None:
    """Name an axis and the unit of what is drawn along it; it is read in the reader's unit."""
    axis.set_label_text(f"{words} ({unit})")
    if fontsize is not None:
        axis.label.set_fontsize(fontsize)
    axis.set_units(unit)


def mark_times(axis: "Axis", *, one_day: bool = False) -> None:
    """Label days by their dates as shortly as can be, or by the time of day alone."""
    locator = AutoDateLocator(minticks=3, maxticks=8)  # type: ignore[no-untyped-call]
    axis.set_major_locator(locator)
    formatter = DateFormatter("%H:%M") if one_day else ConciseDateFormatter(locator)  # type: ignore[no-untyped-call]
    axis.set_major_formatter(formatter)


def draw_in_units(drawn: Iterable["Axes"]) -> None:
    """Convert the labels and ticks of axes to the reader's units, and those of a large map to kilometres."""
    for axes in drawn:
        measured = [axis for axis in (axes.xaxis, axes.yaxis) if _unit(axis) in DIMENSIONS and has_numbers(axis)]
        largest = [max(map(abs, axis.get_view_interval())) for axis in measured]
        is_map = axes.get_aspect() == 1.0
        if is_map:  # both its axes have one unit
            largest = [max(largest, default=0.0)] * len(largest)
        for axis, size in zip(measured, largest, strict=True):
            large = is_map and _unit(axis) == "m" and size >= _LARGE
            if system := reader_system() or ("metric" if large else ""):
                _convert(axis, reader_unit(_unit(axis), size, system))


def _unit(axis: "Axis") -> str:
    """Unit of what is drawn along an axis; empty where `name_axis` has not told it."""
    unit = axis.get_units()  # type: ignore[no-untyped-call]
    return unit if isinstance(unit, str) else ""


def _convert(axis: "Axis", target: Unit) -> None:
    unit = _unit(axis)
    if target.name == unit:
        return
    fixed = axis.get_majorticklocs() if isinstance(axis.get_major_locator(), FixedLocator) else (-math.inf, math.inf)
    inner = LogLocator(subs=_ROUND) if axis.get_scale() == "log" else AutoLocator()
    axis.set_major_locator(_InUnit(inner, target.size, (float(min(fixed)), float(max(fixed)))))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{round(target(value), 9) + 0.0:.6g}".replace("-", "−")))
    axis.set_minor_locator(NullLocator())
    if words := axis.label.get_text():
        axis.set_label_text(f"{words.removesuffix(f'({unit})')}({target.name})")


def round_length(length: float) -> tuple[float, str]:
    """Choose the largest of 1, 2 and 5 × 10ⁿ units up to a length; returns it [m] and in words."""
    unit = reader_unit("m", length, reader_system() or "metric")
    power = 10.0 ** math.floor(math.log10(length / unit.size))
    number = max(step * power for step in _ROUND if step * power <= length / unit.size)
    return number * unit.size, f"{number:g} {unit.name}"


def column_of_panels(
    width: float, heights: "Sequence[float]", margins: tuple[float, float, float, float], gap: float = 0.0
) -> tuple[Figure, "Sequence[Axes]"]:
    """Return a figure with panels of given heights one under the other: where places are known none need be found.

    `margins`: left, right, bottom and top; `gap`: between rows [in].
    """
    left, right, bottom, top = margins
    whole = bottom + top + sum(heights) + gap * (len(heights) - 1)
    figure = Figure(figsize=(width, whole))
    figure.set_layout_engine("none")
    feet = [whole - top - sum(heights[: row + 1]) - row * gap for row in range(len(heights))]
    size = (width, whole, width, whole)
    places = [(left, foot, width - left - right, height) for foot, height in zip(feet, heights, strict=True)]
    return figure, [figure.add_axes(tuple(np.array(place) / size)) for place in places]
