"""Plots of what was learned: a parameter from mission to mission."""

from collections.abc import Mapping

from matplotlib.axes import Axes

from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.report.log_book.history import draw_parameter
from missionplan.report.plots.catalogue import Drawing
from missionplan.results.log_book.history import History


def parameter(axes: Axes, history: History, effect: str = "") -> None:
    """Draw a parameter, by its effect and name as in ``compass-bias.angle``; by default that with most diagnoses."""
    known = {f"{entries[0].effect}.{entries[0].name}": entries for entries in history.parameters.values()}
    if not known:
        raise InputError([Problem("the diagnoses tell of no parameter", key="plot")])
    chosen = effect or max(known, key=lambda name: len(known[name]))
    if chosen not in known:
        problem = f"given {shown(effect)}, expected one of {', '.join(known)}"
        raise InputError([Problem(problem, key="effect", hint=did_you_mean(str(effect), known))])
    draw_parameter(axes, history, known[chosen])


DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {"History": {"parameter": parameter}, "Campaign": {}}
"""By the name of the result's class; the main one first."""
