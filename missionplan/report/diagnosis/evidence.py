"""What supports the verdict: the ranking of the sets, held-out data, and what the data cannot distinguish."""

import math
from collections.abc import Sequence

from missionplan.report.diagnosis.causes import names, part, percent
from missionplan.report.diagnosis.data_kinds.kinds import REPORTS
from missionplan.report.diagnosis.figures import held_out_figure, ranking_figure
from missionplan.report.numbers import number
from missionplan.report.page import Block, PageSection, Table
from missionplan.report.quantities import Unit, reader_unit
from missionplan.report.wording import parameter_in_words
from missionplan.results.learned.diagnosis import Diagnosis
from missionplan.results.learned.evidence import ParameterEstimate, RankedSet


def ranking_section(diagnosis: Diagnosis) -> PageSection:
    """Show the sets of causes, best first, with the parameters of the first."""
    if not diagnosis.ranking:
        return PageSection("No cause of the catalogue could be fitted", ["See the failures below."])
    columns, rows = ranking_rows(diagnosis.ranking)
    best = diagnosis.ranking[0]
    heading = "What else was tried: no set of causes stands out"
    if diagnosis.causes:
        heading = f"What else was tried: {names(best.causes)} {'comes' if len(best.causes) == 1 else 'come'} first"
    meaning = (
        "ln BF is the evidence for a set of causes over the mission's own model: 3 means that the data are 20 times "
        "more probable with it. It is computed with the model linearised at its best fit, and checked for the first "
        "few sets by importance sampling, which does not linearise. The score takes off 3 for each cause beyond the "
        "first. The posterior is the probability among the sets tried, when each cause was equally likely before; "
        "supersets of the best set have none. The probabilities are conditional on the catalogue: that something is "
        f"left which none of these explains has a probability of {percent(diagnosis.none_of_these)}."
    )
    table = Table(columns, rows, "Sets of causes, best first.")
    return PageSection(heading, [ranking_figure(diagnosis), table, meaning, _parameters(best)])


def ranking_rows(ranking: Sequence[RankedSet]) -> tuple[list[str], list[list[str]]]:
    """Return columns and rows of a table of sets."""
    columns = ["Causes", "ln BF", "Checked", "Score", "Posterior", "Held-out gain", "Share explained"]
    rows = [
        [
            names(entry.causes),
            f"{entry.log_bayes_factor:.1f}",
            "" if entry.importance is None else f"{entry.importance:.1f}",
            f"{entry.score:.1f}",
            "" if entry.posterior is None else percent(entry.posterior),
            "" if entry.held_out is None else str(entry.held_out),
            part(entry.share_explained),
        ]
        for entry in ranking
    ]
    return columns, rows


def _parameters(best: RankedSet) -> Table:
    rows = [
        [
            parameter_in_words(p.effect, p.name),
            _shown(p, p.value),
            f"{_shown(p, p.low)} to {_shown(p, p.high)}",
            _unit_of(p).name,
        ]
        for p in best.parameters
    ]
    caption = "Parameters of the set in the first row, with 90 % intervals."
    return Table(["Parameter", "Value", "90 % interval", "Unit"], rows, caption)


def known_section(diagnosis: Diagnosis) -> list[PageSection]:
    """Show what the mission knew of its own effects, and what is known of them now."""
    if not diagnosis.known:
        return []
    after = {(p.effect, p.name): p for p in (*diagnosis.confirmed, *claimed_parameters(diagnosis))}
    rows = []
    for before in diagnosis.known:
        now = after.get((before.effect, before.name))
        known, learned = _with_sd(before), _with_sd(now) if now else ""
        rows.append([parameter_in_words(before.effect, before.name), known, learned, _unit_of(before).name])
    caption = "The mission's own effects are part of its model; the extended mission carries what is known now."
    table = Table(["Parameter", "In the mission", "After these data", "Unit"], rows, caption)
    return [PageSection("What the mission knew, and what is known now", [table])]


def claimed_parameters(diagnosis: Diagnosis) -> tuple[ParameterEstimate, ...]:
    """Return the parameters of the causes that are claimed."""
    return diagnosis.best.parameters if diagnosis.causes and diagnosis.best is not None else ()


def _with_sd(parameter: ParameterEstimate) -> str:
    return " ± ".join(_value_and_sd(parameter))


def sized(parameter: ParameterEstimate) -> str:
    """Write a parameter with its standard deviation and unit, as in ``2.9° ± 0.3°``."""
    value, sd = _value_and_sd(parameter)
    if parameter.unit == "rad":
        return f"{value}° ± {sd}°"
    return f"{value} ± {sd}{_unit_of(parameter).suffix}"


def _value_and_sd(parameter: ParameterEstimate) -> tuple[str, str]:
    """Write both with the digits that the standard deviation supports, angles in degrees."""
    value, sd = map(_unit_of(parameter), (parameter.value, parameter.sd))
    return number(value, sd), number(sd, sd)


def _shown(parameter: ParameterEstimate, value: float) -> str:
    return f"{_unit_of(parameter)(value):.3g}"


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
    heading = f"{better} of {len(diagnosis.scores)} parts are predicted better when they are held out"
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
    held = ", ".join(names(causes) for causes in diagnosis.credible_set)
    blocks: list[Block] = [f"95 % of the probability lies with: {held}."]
    for first, second in diagnosis.indistinguishable:
        blocks.append(f"{names(first).capitalize()} and {names(second)} predict the same of data like these.")
    if diagnosis.untestable:
        rows = [[name.replace("-", " "), why] for name, why in diagnosis.untestable.items()]
        blocks.append(Table(["Effect that these data cannot show", "Why"], rows, text_columns=2))
    return PageSection(_distinction_heading(diagnosis), blocks)


def _distinction_heading(diagnosis: Diagnosis) -> str:
    if len(diagnosis.credible_set) > 1 or diagnosis.indistinguishable:
        return "What these data cannot distinguish, and what would"
    return "Nothing else comes near" if diagnosis.causes else "No cause comes near"
