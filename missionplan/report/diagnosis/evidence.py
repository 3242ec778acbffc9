"""Figures that all kinds of data share: ranking, discrepancy, held-out gain."""

import math
import textwrap
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.errors import counted
from missionplan.report.diagnosis.kind_report import names, part, percent
from missionplan.report.diagnosis.kinds import REPORTS
from missionplan.report.page import BLUE, GREY, ORANGE, Block, Figure, PageSection, Table, to_figure
from missionplan.report.quantities import Unit, in_reader_units, length_in_words, reader_unit
from missionplan.report.wording import has_spread, number, parameter_in_words
from missionplan.results.learned import Diagnosis
from missionplan.results.learned.evidence import (
    SURE,
    Discrepancy,
    DiscrepancyShape,
    ParameterEstimate,
    RankedSet,
    TakenAsExact,
)

_LISTED = 8
_LABEL = 36
"""Characters of a line of a set's name."""


def ranking_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the scores of the best sets."""
    entries = diagnosis.ranking[:_LISTED]
    further = sum(_label(entry).count("\n") for entry in entries)
    figure = MatplotlibFigure(figsize=(6.2, 0.36 * len(entries) + 0.16 * further + 0.9))
    draw_ranking(figure.subplots(), diagnosis)
    first = f"; {names(diagnosis.ranking[0].causes)} first" if diagnosis.causes else ""
    alt = f"Probabilities of the best {len(entries)} sets of causes{first}"
    return to_figure(figure, "ranking", alt=alt, caption="Probability of each set of causes.")


def _label(entry: RankedSet) -> str:
    """Name a set beside its bar: one of four causes is longer than a line."""
    return "\n".join(textwrap.wrap(names(entry.causes), _LABEL))


def draw_ranking(axes: Axes, diagnosis: Diagnosis) -> None:
    """Draw a bar for each of the best sets; those claimed are blue."""
    entries = list(reversed(diagnosis.ranking[:_LISTED]))
    shares = [100.0 * (entry.posterior or 0.0) for entry in entries]
    colours = [BLUE if entry.causes == diagnosis.causes else GREY for entry in entries]
    axes.barh(range(len(entries)), shares, color=colours, height=0.6)
    axes.set_yticks(range(len(entries)), [_label(entry) for entry in entries], fontsize=9)
    axes.set(xlim=(0.0, 100.0), xlabel="Probability (%)")


def discrepancy_figure(rest: Discrepancy, shape: DiscrepancyShape) -> Figure:
    """Draw what is left along its axis, with a 90 % band."""
    at, mean, sd = shape.at, shape.mean, shape.sd
    figure = MatplotlibFigure(figsize=(6.4, 2.8))
    axes = figure.subplots()
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.fill_between(at, mean - 1.645 * sd, mean + 1.645 * sd, color=BLUE, alpha=0.2, linewidth=0.0)
    axes.plot(at, mean, "-", color=BLUE, linewidth=1.4)
    axes.set(xlabel=shape.place, ylabel=shape.value, xlim=(at[0], at[-1]))
    return to_figure(
        figure,
        "remainder",
        alt=f"{shape.value} against {shape.place[0].lower()}{shape.place[1:]}: what the claimed causes leave",
        caption=(
            f"What is left beside the causes named, if it is {rest.resembles}, the same throughout the data; "
            "band: 90 %. It shows where to look for a cause, and is no part of the extended mission."
        ),
    )


def held_out_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the held-out gain of each part."""
    figure = MatplotlibFigure(figsize=(6.0, 0.32 * len(diagnosis.scores) + 0.9))
    draw_held_out(figure.subplots(), diagnosis)
    better = sum(gain > 0.0 for gain in _gains(diagnosis))
    alt = f"Held-out gain of {len(diagnosis.scores)} parts; {better} of them better with the extended model"
    caption = "Gain of the set that scores best, on each part of the data held out in turn."
    return to_figure(figure, "held-out", alt=alt, caption=caption)


def draw_held_out(axes: Axes, diagnosis: Diagnosis) -> None:
    """Draw a bar for each part of the data."""
    gains = _gains(diagnosis)
    axes.barh(range(len(gains)), gains, color=[BLUE if gain > 0.0 else ORANGE for gain in gains], height=0.6)
    axes.set_yticks(range(len(gains)), [score.group for score in diagnosis.scores], fontsize=9)
    axes.invert_yaxis()
    axes.axvline(0.0, color=GREY, linewidth=0.8)
    axes.set_xlabel("Gain in ln probability of the part, predicted from the others")


def _gains(diagnosis: Diagnosis) -> list[float]:
    return [score.log_score_extended - score.log_score_base for score in diagnosis.scores]


_TESTS_SHOWN = 5


def discrepancy_section(diagnosis: Diagnosis) -> PageSection:
    """Show what is left, and the tests for it."""
    rest = diagnosis.discrepancy
    if not rest.by_axis:
        none = "A handful of numbers has no structure that could be tested."
        return PageSection("Too few data to look for what is left", [none])
    blocks: list[Block] = [discrepancy_figure(rest, rest.shape)] if rest.shape is not None else []
    blocks.append(
        f"A smooth discrepancy along any axis: ln BF = {rest.log_bayes_factor:.1f} (above 3 it counts). It is tested "
        "for, and is no part of the extended mission. With the mission's model alone: "
        f"{diagnosis.base_discrepancy.log_bayes_factor:.1f}."
    )
    rows = [[axis, f"{value:.1f}"] for axis, value in rest.by_axis]
    blocks.append(Table(["What it could look like", "ln BF of a smooth discrepancy"], rows))
    if rest.tests:
        least, chance = sorted(rest.tests, key=lambda test: test.p_value)[:_TESTS_SHOWN], 1.0 / len(rest.tests)
        caption = f"The smallest p-values of {len(rest.tests)} tests; by chance alone the least would be about "
        rows = [[test.name, f"{test.p_value:.2g}"] for test in least]
        blocks.append(Table(["Test of the errors left", "p-value"], rows, f"{caption}{chance:.2g}."))
    heading = "Nothing structured is left" if rest.axis is None else f"What is left {resemblance(rest)}"
    return PageSection(heading, blocks)


def resemblance(rest: Discrepancy) -> str:
    """Write what a discrepancy looks like, or along what it is structured: the end of a sentence."""
    if rest.resembles is None:
        return f"is structured along {rest.axis}"
    return f"looks like {rest.resembles}"


def ranking_section(diagnosis: Diagnosis) -> PageSection:
    """Show the sets of causes, best first, with the parameters of the first."""
    if not diagnosis.ranking:
        if not diagnosis.learned_from:
            return PageSection("No cause was looked for", ["Nothing in these data is new to the mission."])
        return PageSection("No cause of the catalogue could be fitted", ["See the failures below."])
    columns, rows = ranking_rows(diagnosis.ranking[:_LISTED])
    best = diagnosis.ranking[0]
    heading = "What else was tried: no set of causes stands out"
    if diagnosis.causes:
        heading = f"What else was tried: {names(best.causes)} {'comes' if len(best.causes) == 1 else 'come'} first"
    meaning = (
        "ln BF is the evidence for a set of causes over the mission's own model: 3 means that the data are 20 times "
        "more probable with it. It is computed with the model linearised at its best fit, and where that is known "
        "better by importance sampling, which does not linearise. The score takes off 3 for each cause beyond the "
        "first. The posterior is the probability among all sets, when each cause was equally likely before. The "
        "probabilities are conditional on the catalogue: that something is "
        f"left which none of these explains has a probability of {percent(diagnosis.none_of_these)}."
    )
    more = len(diagnosis.ranking) - len(rows)
    table = Table(columns, rows, f"Sets of causes, best first{f'; {more} more in ranking.csv' if more > 0 else ''}.")
    shown = []
    for p in best.parameters:
        unit = _unit_of(p)
        value, low, high = (number(unit(size), unit(p.sd)) for size in (p.value, p.low, p.high))
        shown.append([parameter_in_words(p.effect, p.name), value, f"{low} to {high}", unit.name])
    heads = ["Parameter", "Value", "90 % interval", "Unit"]
    parameters = Table(heads, shown, "Parameters of the set in the first row, with 90 % intervals.")
    return PageSection(heading, [ranking_figure(diagnosis), table, meaning, parameters])


def ranking_rows(ranking: Sequence[RankedSet]) -> tuple[list[str], list[list[str]]]:
    """Return columns and rows of a table of sets."""
    columns = ["Causes", "ln BF", "Score", "Posterior", "Held-out gain", "Share explained"]
    rows = [
        [
            names(entry.causes),
            f"{entry.log_bayes_factor:.1f}",
            f"{entry.score:.1f}",
            "" if entry.posterior is None else percent(entry.posterior),
            "" if entry.held_out is None else str(entry.held_out),
            part(entry.share_explained),
        ]
        for entry in ranking
    ]
    return columns, rows


def known_section(diagnosis: Diagnosis) -> list[PageSection]:
    """Show what the mission knew of its own effects, and what is known of them now."""
    if not diagnosis.known:
        return []
    after = {(p.effect, p.name): p for p in (*diagnosis.confirmed, *claimed_parameters(diagnosis))}
    rows = []
    for before in diagnosis.known:
        now = after.get((before.effect, before.name))
        chance = diagnosis.probability_of(before.effect)
        doubt = "" if chance >= SURE else f", if it holds ({percent(chance)})"
        prior, learned = _with_sd(before), f"{_with_sd(now)}{doubt}" if now else ""
        rows.append([parameter_in_words(before.effect, before.name), prior, learned, _unit_of(before).name])
    caption = "The mission's own effects are part of its model; the extended mission carries what is known now."
    table = Table(["Parameter", "In the mission", "After these data", "Unit"], rows, caption)
    return [PageSection("What the mission knew, and what is known now", [table])]


_TELLING = 1.0
"""Standard deviations by which a parameter moves, from which a heading tells of it."""


def exact_section(diagnosis: Diagnosis) -> list[PageSection]:
    """Show what the answer takes as exact, and what it would be if that were off by its usual size."""
    if not diagnosis.exact:
        return []
    first, turning = diagnosis.exact[0], sum(one.turns for one in diagnosis.exact)
    rows = [
        (
            one.what,
            in_reader_units(one.otherwise),
            "" if one.moves is None else f"{parameter_in_words(one.moves.effect, one.moves.name)} by {_moved(one)}",
            "" if one.moves is None else f"{one.in_sd:.1f}",
            names(one.likeliest) if one.turns else "as now",
        )
        for one in diagnosis.exact
    ]
    heading = "None of what this takes as exact could turn it"
    if turning:
        heading = f"{turning} of what this takes as exact could turn it"
    elif first.moves is not None and first.in_sd > _TELLING:
        moved = parameter_in_words(first.moves.effect, first.moves.name)
        heading = f"This takes as exact that {first.what}: {first.otherwise} moves the {moved} by {_moved(first)}"
    columns = ("taken as exact", "instead", "moves most", "of its sd", "likeliest then")
    caption = "Each alone. Parameters of physical causes; the likeliest of these causes, the nearest to them, and none."
    return [PageSection(heading, [Table(columns, rows, caption, text_columns=3)], is_summary=True)]


def _moved(one: TakenAsExact) -> str:
    if one.moves is None:
        return ""
    unit = _unit_of(one.moves)
    size = unit(abs(one.moves.value))
    return f"{number(size, 0.05 * size)}{unit.suffix}"


def exact_in_words(diagnosis: Diagnosis) -> str:
    """Say what that is taken as exact could turn the answer; empty where nothing could."""
    first = next((one for one in diagnosis.exact if one.turns), None)
    if first is None:
        return ""
    otherwise = in_reader_units(first.otherwise)
    return f" But this takes as exact that {first.what}: with {otherwise} {names(first.likeliest)} is likelier."


def claimed_parameters(diagnosis: Diagnosis) -> tuple[ParameterEstimate, ...]:
    """Return the parameters of the causes that are claimed."""
    return diagnosis.best.parameters if diagnosis.causes and diagnosis.best is not None else ()


def _with_sd(parameter: ParameterEstimate) -> str:
    return " ± ".join(_value_and_sd(parameter))


def sized(parameter: ParameterEstimate) -> str:
    """Write a parameter with its standard deviation, if any, and unit, as in ``2.9° ± 0.3°``."""
    is_angle, suffix = parameter.unit == "rad", _unit_of(parameter).suffix
    return "° ± ".join(_value_and_sd(parameter)) + "°" if is_angle else f"{_with_sd(parameter)}{suffix}"


def _value_and_sd(parameter: ParameterEstimate) -> list[str]:
    """Write both with the digits that the standard deviation supports, angles in degrees; one without spread alone."""
    value, sd = map(_unit_of(parameter), (parameter.value, parameter.sd))
    return [number(value, sd), *([number(sd, sd)] if has_spread(value, sd) else [])]


def _unit_of(parameter: ParameterEstimate) -> Unit:
    """Unit in which a parameter is shown: angles in degrees."""
    if parameter.unit == "rad":
        return Unit("°", math.radians(1.0))
    return reader_unit(parameter.unit, max(abs(parameter.value), abs(parameter.low), abs(parameter.high)))


def held_out_section(diagnosis: Diagnosis) -> list[PageSection]:
    """Show how the first set predicts each part of the data from the others."""
    if not diagnosis.scores:
        return []
    better = sum(score.log_score_extended > score.log_score_base for score in diagnosis.scores)
    heading = f"Predicted better when held out: {better} of {counted(len(diagnosis.scores), 'part')}"
    unit = reader_unit(REPORTS[diagnosis.kind].unit, max(score.rmse_base for score in diagnosis.scores))
    rows = [
        [
            score.group,
            f"{score.log_score_extended - score.log_score_base:+.1f}",
            unit.cell(score.rmse_base, ".3g"),
            unit.cell(score.rmse_extended, ".3g"),
        ]
        for score in diagnosis.scores
    ]
    heads = ["Held out", "Gain (nats)", f"Error before{unit.axis}", f"Error after{unit.axis}"]
    table = Table(heads, rows)
    blocks: list[Block] = [held_out_figure(diagnosis), table]
    best = diagnosis.best
    if best is not None and best.held_out is not None:
        gain = best.held_out
        blocks.append(
            f"90 % prediction intervals hold {part(gain.coverage_90_base)} of the values with the mission's "
            f"model and {part(gain.coverage_90_extended)} with the extended one."
        )
    return [PageSection(heading, blocks)]


def distinction_section(diagnosis: Diagnosis) -> PageSection:
    """Show which sets the data leave probable, and which effects they could not show at all."""
    sets = ", ".join(names(causes) for causes in diagnosis.credible_set[:_LISTED])
    more = len(diagnosis.credible_set) - _LISTED
    beyond = f" and {more} more in diagnosis.json" if more > 0 else ""
    blocks: list[Block] = [f"95 % of the probability lies with: {sets}{beyond}."]
    for first, second in diagnosis.indistinguishable:
        blocks.append(f"{names(first).capitalize()} and {names(second)} predict the same of data like these.")
    if diagnosis.readings.aliases:
        rows = [
            [names((alias.claimed,)), names((alias.other,)), length_in_words(alias.matters_from), alias.trial]
            for alias in diagnosis.readings.aliases
        ]
        heads = ["Claimed", "Does the same on these legs", "Matters to a way from", "Told apart by"]
        blocks.append(Table(heads, rows, "Effects that would do something else on the mission's way.", text_columns=4))
    if diagnosis.untestable:
        rows = [[name.replace("-", " "), why] for name, why in diagnosis.untestable.items()]
        blocks.append(Table(["Effect that these data cannot show", "Why"], rows, text_columns=2))
    heading = _what_is_near(diagnosis)
    if not diagnosis.ranking:
        heading, blocks[0] = "What these data could not show", "No cause was compared with another."
    return PageSection(heading, blocks)


def _what_is_near(diagnosis: Diagnosis) -> str:
    claimed = {*diagnosis.causes}
    likely = [entry.causes for entry in diagnosis.ranking if (entry.posterior or 0.0) > 1.0 - SURE]
    if diagnosis.indistinguishable or any(not (claimed and claimed <= {*causes}) for causes in likely):
        return "What these data cannot distinguish, and what would"
    return "Nothing else comes near" if claimed else "No cause comes near"
