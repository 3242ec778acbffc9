"""Figure of an optimisation: P(success) against the cost of all that was tried."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.report.quantities import Unit, unit_for
from missionplan.results.choosing.optimisation import Optimised, Tried


def front_figure(found: Optimised) -> Figure | None:
    """Draw P(success) against the cost of all that was tried and reached the mission's end."""
    tried = _reached(found)
    if not tried:
        return None
    figure = MatplotlibFigure(figsize=(6.0, 3.4))
    draw_front(figure.subplots(), found)
    figure.legend(loc="outside upper center", ncols=3)
    return to_figure(
        figure,
        "optimise",
        f"Probability of success against mean {found.aim} of the choices tried",
        f"All choices tried, with {min(each.trials for each in tried)} trials or more.",
    )


def draw_front(axes: Axes, found: Optimised) -> None:
    """Draw P(success) against the cost of all that was tried and reached the mission's end."""
    tried = _reached(found)
    if not tried:
        return
    unit = _unit_of_cost(found, tried)
    chosen = [each for each in tried if each.values == found.chosen and found.feasible]
    for label, marker, size, colour, members in (
        ("misses a requirement", "o", 4, GREY, [each for each in tried if not each.feasible]),
        ("meets all requirements", "o", 4, BLUE, [each for each in tried if each.feasible]),
        ("chosen", "*", 14, ORANGE, chosen),
    ):
        if members:
            x = [unit(_least(found, each)) for each in members]
            y = [100.0 * each.success.value for each in members]
            axes.plot(x, y, marker, color=colour, markersize=size, alpha=0.6 if marker == "o" else 1.0, label=label)
    low = min(90.0, 100.0 * min(each.success.value for each in tried))
    axes.set(xlabel=f"Mean {found.aim}{unit.axis}", ylabel="P(success) (%)")
    axes.set_ylim(low - 0.05 * (100.0 - low), 100.0 + 0.05 * (100.0 - low))


def _reached(found: Optimised) -> list[Tried]:
    """Choices tried of which some trial reached the mission's end."""
    return [each for each in found.tried if np.isfinite(_least(found, each))]


def _unit_of_cost(found: Optimised, tried: Sequence[Tried]) -> Unit:
    typical = float(np.median([_least(found, each) for each in tried]))
    return unit_for("total", found.key, found.provenance.data, typical=typical)


def _least(found: Optimised, each: Tried) -> float:
    """Return the mean of what is to be least."""
    return each.energy if found.aim == "energy" else each.duration
