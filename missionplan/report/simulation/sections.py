"""What to measure better: which uncertain inputs make the key figures of a simulated mission vary."""

import math
from collections.abc import Iterator, Sequence
from itertools import chain, groupby

from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.montecarlo.statistics import wilson
from missionplan.report.page import BLUE, GREY, INK, ORANGE, Figure, PageSection, Table, to_figure
from missionplan.report.plan_view import WIDTH, close_ups, rings
from missionplan.report.quantities import reader_unit, span, with_error
from missionplan.report.simulation.figures import histograms, moves_over_ground, waterfall
from missionplan.report.simulation.quantities import (
    LEAST_SPREAD,
    failure_in_words,
    of_those_that_end,
    relative_spread,
    requirement_on,
    unit_of,
    worst_step,
)
from missionplan.report.wording import capitalised, in_words, listed, number, percent, phase_in_words, share
from missionplan.results.simulation import Outcome, PhaseOutcome, Sensitivity

_MOST_INPUTS = 5
_MOST_FIGURES = 4
_LEAST_SHOWN = 0.01
_STEADY = 0.01
"""Standard deviation over mean to which a quantity must vary to be worth a heading."""

InputsOf = tuple[str, Sequence[Sensitivity]]
"""A key figure and the inputs that matter for it, the most important first."""


def sensitivity_sections(outcome: Outcome) -> Iterator[PageSection]:
    """Draw and tabulate the inputs with a detectable influence, where there are any."""
    influential = [group for group in _influential(_told_once(outcome)) if _spread(outcome, group[0]) > LEAST_SPREAD]
    if not influential:
        return
    drawn = _most_relevant(outcome, influential)
    yield PageSection(
        _heading(outcome, drawn),
        [
            "What to measure better: the share of a key figure's variance that would go if an input were known. "
            "summary.json has those of every quantity.",
            sensitivity_figure(drawn),
        ],
    )


def _told_once(outcome: Outcome) -> list[Sensitivity]:
    """Leave out what a mission of one phase has as its total too."""
    totals = {each.output.partition(".")[2] for each in outcome.sensitivities if each.output.startswith("total.")}
    alone = outcome.phases[0].name if len(outcome.phases) == 1 else None
    return [
        each
        for each in outcome.sensitivities
        if each.output.partition(".")[0] != alone or each.output.partition(".")[2] not in totals
    ]


def _influential(sensitivities: Sequence[Sensitivity]) -> list[InputsOf]:
    """Keep, for each key figure, the inputs whose index exceeds two standard errors."""
    groups: list[InputsOf] = []
    for output, found in groupby(sensitivities, key=lambda influence: influence.output):
        clear = [influence for influence in found if influence.first_order > 2.0 * influence.standard_error]
        if clear:
            groups.append((output, clear[:_MOST_INPUTS]))
    return groups


def _most_relevant(outcome: Outcome, groups: Sequence[InputsOf]) -> list[InputsOf]:
    """Choose the key figures to draw: first what the mission is judged by, then what it costs as a whole."""
    required = tuple(item.quantity for item in outcome.requirements)

    def rank(group: InputsOf) -> tuple[bool, bool]:
        return not group[0].startswith(required), not group[0].startswith("total")

    return [(output, _worth_drawing(found)) for output, found in sorted(groups, key=rank)[:_MOST_FIGURES]]


def _worth_drawing(found: Sequence[Sensitivity]) -> Sequence[Sensitivity]:
    return [influence for influence in found if influence.first_order > _LEAST_SHOWN] or found[:1]


def _heading(outcome: Outcome, groups: Sequence[InputsOf]) -> str:
    """Name the input that accounts for most of a figure, of those that vary enough to be worth a thought."""
    varying = [group for group in groups if _spread(outcome, group[0]) > _STEADY] or groups
    output, (first, *_) = max(varying, key=lambda group: group[1][0].first_order)
    share = f"{100.0 * first.first_order:.0f}\u00a0%"
    source = capitalised(in_words(first.source))
    return f"{source} matters most: it accounts for {share} of the variance of the {in_words(output)}"


def _spread(outcome: Outcome, output: str) -> float:
    """Standard deviation of a quantity over its mean; infinite where that is not known."""
    parts = {phase.name: phase for phase in (*outcome.phases, outcome.total)}
    name, _, key = output.partition(".")
    statistic = parts[name].quantities.get(key) if name in parts else None
    return relative_spread(statistic) if statistic is not None else math.inf


def _has_order(influence: Sensitivity) -> bool:
    """Whether the input is larger in one trial than in another; a member or an explanation only has a number."""
    return not influence.source.endswith((".member", ".one-of", "posterior"))


def sensitivity_figure(groups: Sequence[InputsOf]) -> Figure:
    """Draw the share of each key figure's variance that each input explains."""
    sizes = [len(found) + 0.9 for _, found in groups]
    figure = MatplotlibFigure(figsize=(WIDTH, 0.5 + 0.5 * sum(sizes)))
    panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False, height_ratios=sizes).ravel()
    for axes, (output, found) in zip(panels, groups, strict=True):
        _draw_shares(axes, output, found)
    panels[-1].set_xlabel("share of the variance explained alone (%)")
    unordered = "" if all(map(_has_order, chain.from_iterable(found for _, found in groups))) else "; grey: neither"
    words = "; ".join(f"{in_words(output)}: mostly {in_words(found[0].source)}" for output, found in groups)
    return to_figure(
        figure,
        "sensitivity",
        f"Bars: the share of the key figures' variance that each uncertain input explains. {words}.",
        "First-order Sobol indices with 95 % intervals; blue: a larger input makes the figure larger, orange: smaller "
        f"(sign of the rank correlation){unordered}.",
    )


def _draw_shares(axes: Axes, output: str, found: Sequence[Sensitivity]) -> None:
    for row, influence in enumerate(found):
        share, error = 100.0 * max(influence.first_order, 0.0), 100.0 * influence.standard_error
        axes.barh(row, share, color=_colour(influence), height=0.4)
        axes.errorbar(share, row, xerr=1.96 * error, color=INK, capsize=2.5, linewidth=1.0)
        axes.annotate(
            _label(influence),
            (0.0, row - 0.24),
            (2, 1),
            textcoords="offset points",
            va="bottom",
            ha="left",
            fontsize=9,
        )
    axes.set(yticks=[], ylim=(len(found) - 0.6, -0.85), xlim=(0.0, 105.0), title=in_words(output))
    axes.grid(visible=False, axis="y")


def _colour(influence: Sensitivity) -> str:
    if not _has_order(influence):
        return GREY
    return BLUE if influence.rank_correlation >= 0.0 else ORANGE


def _label(influence: Sensitivity) -> str:
    share = number(100.0 * influence.first_order, 100.0 * influence.standard_error)
    return f"{in_words(influence.source)}  {share} %"


_ALWAYS_DRAWN = ("total.duration_s", "total.energy_wh")
"""Quantities whose distribution is drawn even without a requirement on them."""


def failed_blocks(outcome: Outcome) -> Iterator[PageSection]:
    """Name the blocks of trials that failed numerically, if any."""
    count = len(outcome.failed_blocks)
    if count:
        words = "1 block of trials" if count == 1 else f"{count} blocks of trials"
        text = "They are left out of everything on this page. Each can be run again alone:"
        yield PageSection(f"{words} failed numerically", [text, *outcome.failed_blocks], is_summary=True)


def tracks(outcome: Outcome) -> Iterator[PageSection]:
    """Draw where each phase ends about its goal; nothing where nothing moves over ground."""
    if not moves_over_ground(outcome):
        return
    drawn = list(rings(outcome))
    unit = reader_unit("m", max(ring.radius for ring in drawn))
    kinds = list(dict.fromkeys(ring.name for ring in drawn))
    rows = []
    for phase in dict.fromkeys(ring.phase for ring in drawn):
        radii = {ring.name: unit.cell(ring.radius, ".3g") for ring in drawn if ring.phase == phase}
        rows.append((phase_in_words(phase), *(radii.get(kind, "") for kind in kinds)))
    caption = f"Radii{unit.axis}, about the goal; for an ellipse, of the circle of equal area."
    close = close_ups(outcome)
    yield PageSection("Where the trials end", [*([close] if close else []), Table(("phase", *kinds), rows, caption)])


def distributions(outcome: Outcome) -> PageSection:
    """Draw the distributions that matter, or name the value of a quantity that does not vary."""
    shown = [
        (phase, key)
        for phase in (outcome.total, *outcome.phases)
        for key in phase.quantities
        if _is_drawn(outcome, phase, key)
    ]
    varying = [(phase, key) for phase, key in shown if relative_spread(phase.quantities[key]) > LEAST_SPREAD]
    fixed = [_fixed(outcome, phase, key) for phase, key in shown if (phase, key) not in varying]
    which = of_those_that_end(outcome, "duration_s", "") or "the missions"
    heading = f"Half of {which} need no more than {_medians(outcome)}"
    return PageSection(heading, [*([histograms(outcome, varying)] if varying else []), *fixed])


def _is_drawn(outcome: Outcome, phase: PhaseOutcome, key: str) -> bool:
    matters = requirement_on(outcome, phase, key) is not None or f"{phase.name}.{key}" in _ALWAYS_DRAWN
    return matters and math.isfinite(phase.quantities[key].p50)


def _fixed(outcome: Outcome, phase: PhaseOutcome, key: str) -> str:
    value = with_error(phase.quantities[key].mean, 0.0, unit_of(outcome, phase, key))
    return f"The {in_words(f'{phase.name}.{key}')} is {value} in every trial that reached it."


def _medians(outcome: Outcome) -> str:
    parts = []
    for key in ("duration_s", "energy_wh"):
        statistic = outcome.total.quantities.get(key)
        if statistic is not None and math.isfinite(statistic.p50):
            unit = unit_of(outcome, outcome.total, key)
            parts.append(f"{span(statistic, unit)[1]}{unit.suffix}")
    return " and ".join(parts)


def attrition(outcome: Outcome) -> PageSection:
    """Draw and tabulate what is lost at each step at which any trial is; the others are named."""
    worst = worst_step(outcome)
    losing = [step for step in outcome.attrition if step.lost.value > 0.0]
    spared = [failure_in_words(step.step) for step in outcome.attrition if step.lost.value == 0.0]
    none = f"No trial of {number(outcome.provenance.trials)} fails by {listed(spared, 'or')}" if spared else ""
    most = f": each {percent(outcome.attrition[0].lost).partition('(')[2].rstrip(')')}" if spared and not losing else ""
    if worst is None:
        return PageSection("No trial failed", [f"{none}{most}."] if spared else [])
    rows = [(step.step, percent(step.lost), percent(step.surviving)) for step in losing]
    table = Table(("step", "lost here", "still good"), rows, "Shares of all trials.")
    heading = f"{capitalised(failure_in_words(worst.step))} cost {percent(worst.lost)} of the trials"
    return PageSection(heading, [waterfall(outcome), table, *([f"{none}."] if spared else [])], is_summary=True)


def quantities(outcome: Outcome) -> PageSection:
    """Tabulate every quantity of every phase."""
    trials = outcome.provenance.trials
    rows = []
    for phase in (*outcome.phases, outcome.total):
        for key, statistic in phase.quantities.items():
            reached = "" if statistic.count == trials else share(wilson(statistic.count, trials))
            unit = unit_of(outcome, phase, key)
            rows.append((in_words(f"{phase.name}.{key}"), *span(statistic, unit), unit.name, reached))
    columns = ("quantity", "5 %", "50 %", "95 %", "", "trials that reached it")
    caption = "Of the trials that reached it; means, their errors and standard deviations are in quantities.csv."
    return PageSection("Every quantity, phase by phase", [Table(columns, rows, caption)], is_reference=True)
