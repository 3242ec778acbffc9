"""Drawn axes in the units of the crew: labels, round ticks, legends; what is drawn stays in the units it was given."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
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

from missionplan.mission.unit_table import FACTORS
from missionplan.report.crew.conversion import DIMENSIONS, HEAD, drawn_units, in_units, unit_for_size

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.text import Text

_ROUND = (1.0, 2.0, 5.0)


class _InUnit(Locator):
    """Places ticks where an axis of another unit has them.

    Parameters
    ----------
    inner : Locator
        Of the axis in the other unit.
    size : float
        Of the other unit, in that of the axis.
    bounds : (float, float)
        Beyond which there is no tick, in the unit of the axis.
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


def size_of_unit(axis: "Axis") -> float:
    """Size of the unit in which an axis is read, in that in which it was drawn."""
    locator = axis.get_major_locator()
    return locator.size if isinstance(locator, _InUnit) else 1.0


def has_numbers(axis: "Axis") -> bool:
    """Whether an axis has numbers on a scale that can be read off; names and dates are none."""
    is_number = isinstance(axis.get_major_formatter(), ScalarFormatter | LogFormatter)
    is_number |= isinstance(axis.get_major_locator(), _InUnit)
    return is_number and axis.get_scale() in ("linear", "log")


def draw_in_units(drawn: Iterable["Axes"]) -> None:
    """Convert the labels, ticks and texts of axes to the units chosen by `drawing_in`."""
    system = drawn_units()
    if not system:
        return
    found = list(drawn)
    labelled = [(axes, _labelled(axes)) for axes in found]
    for axes, dimensions in labelled:
        largest = [max(map(abs, axis.get_view_interval())) for axis, _ in dimensions]
        if axes.get_aspect() == 1.0:  # both axes of a map have one unit
            largest = [max(largest, default=0.0)] * len(largest)
        for (axis, label), size in zip(dimensions, largest, strict=True):
            _convert(axis, label, size, system)
    for axes in found:
        for text in _texts(axes):
            text.set_text(in_units(text.get_text(), system))


def _labelled(axes: "Axes") -> list[tuple["Axis", str]]:
    """Axes with numbers whose own label, or that of one that shares them, has a unit that is converted."""
    across = [other.xaxis for other in axes.get_shared_x_axes().get_siblings(axes)]
    up = [other.yaxis for other in axes.get_shared_y_axes().get_siblings(axes)]
    found = [(axes.xaxis, _label(axes.xaxis, across)), (axes.yaxis, _label(axes.yaxis, up))]
    return [(axis, label) for axis, label in found if has_numbers(axis) and HEAD.fullmatch(label)]


def _label(axis: "Axis", shared: Sequence["Axis"]) -> str:
    return axis.label.get_text() or next(filter(None, (other.label.get_text() for other in shared)), "")


def _convert(axis: "Axis", label: str, largest: float, system: str) -> None:
    found = HEAD.fullmatch(label)
    if found is None:
        return
    unit = found[2]
    target = unit_for_size(unit, largest, system)
    if target == unit:
        return
    factors = FACTORS[DIMENSIONS[unit]]
    size = factors[target] / factors[unit]
    fixed = axis.get_majorticklocs() if isinstance(axis.get_major_locator(), FixedLocator) else (-math.inf, math.inf)
    inner = LogLocator(subs=_ROUND) if axis.get_scale() == "log" else AutoLocator()
    axis.set_major_locator(_InUnit(inner, size, (float(min(fixed)), float(max(fixed)))))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{round(value / size, 9) + 0.0:.6g}".replace("-", "−")))
    axis.set_minor_locator(NullLocator())
    if axis.label.get_text():
        axis.set_label_text(f"{found[1]}{target}{found[3]}")


def _texts(axes: "Axes") -> Iterator["Text"]:
    """Texts that are no numbers of ticks."""
    yield from axes.texts
    yield axes.title
    legend = axes.get_legend()
    yield from legend.get_texts() if legend else ()


def round_length(length: float) -> tuple[float, str]:
    """Choose the largest of 1, 2 and 5 × 10ⁿ units up to a length; returns it [m] and in words."""
    unit = unit_for_size("m", length, drawn_units() or "metric")
    size = FACTORS["m"][unit]
    power = 10.0 ** math.floor(math.log10(length / size))
    number = max(step * power for step in _ROUND if step * power <= length / size)
    return number * size, f"{number:g} {unit}"
