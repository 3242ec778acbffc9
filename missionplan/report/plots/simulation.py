"""Plots of a simulated mission."""

from collections.abc import Mapping

from matplotlib.axes import Axes

from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.report.plots.catalogue import Drawing
from missionplan.report.simulation.figures import draw_timeline, draw_waterfall
from missionplan.report.simulation.histograms import draw_histogram
from missionplan.report.simulation.maps import draw_tracks
from missionplan.report.simulation.quantities import failure_in_words
from missionplan.results.rare_failure import RareFailure
from missionplan.results.simulation import Outcome


def histogram(axes: Axes, outcome: Outcome, quantity: str = "total.duration_s") -> None:
    """Draw the distribution of a quantity, such as ``moor.offset_m``, over the trials."""
    phases = {phase.name: phase for phase in (*outcome.phases, outcome.total)}
    known = {f"{name}.{key}": (phase, key) for name, phase in phases.items() for key in phase.histograms}
    if quantity not in known:
        problem = Problem(f"given {shown(quantity)}, expected one of {', '.join(known)}", key="quantity")
        raise InputError([Problem(problem.message, key="quantity", hint=did_you_mean(str(quantity), known))])
    phase, key = known[quantity]
    draw_histogram(axes, outcome, phase, key)


def failures(axes: Axes, found: RareFailure) -> None:
    """Draw the share of each way to fail."""
    modes = found.modes[::-1]
    axes.barh(range(len(modes)), [100.0 * mode.share for mode in modes])
    axes.set_yticks(range(len(modes)), [failure_in_words(mode.step) if mode.step else "any" for mode in modes])
    axes.set(xlabel="of the failures (%)", xlim=(0.0, 100.0))


DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {
    "Outcome": {"waterfall": draw_waterfall, "tracks": draw_tracks, "timeline": draw_timeline, "histogram": histogram},
    "RareFailure": {"failures": failures},
}
"""By the name of the result's class; the main one first."""
