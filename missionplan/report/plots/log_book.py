"""Plots of what was learned: a parameter from mission to mission."""

from collections.abc import Mapping

from matplotlib.axes import Axes

from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.report.diagnosis.figures import draw_ranking
from missionplan.report.log_book.history import draw_parameter
from missionplan.report.plots.catalogue import Drawing
from missionplan.results.log_book.campaign import Campaign
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


def ranking(axes: Axes, campaign: Campaign, dataset: int = 0) -> None:
    """Draw the evidence for each set of causes in one of the data sets, counted from 0."""
    if not 0 <= dataset < len(campaign.diagnoses):
        problem = f"given {shown(dataset)}, expected 0 to {len(campaign.diagnoses) - 1}"
        raise InputError([Problem(problem, key="dataset")])
    draw_ranking(axes, campaign.diagnoses[dataset])
    axes.set_title(campaign.names[dataset])


DRAWINGS: Mapping[str, Mapping[str, Drawing]] = {"History": {"parameter": parameter}, "Campaign": {"ranking": ranking}}
"""By the name of the result's class; the main one first."""
