"""What was found, as the operator is told it, and how sure it is: what else could be behind it."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from missionplan.effects import CATALOGUE
from missionplan.effects.info import Finding
from missionplan.errors import counted
from missionplan.report.diagnosis.evidence import claimed_parameters, sized
from missionplan.report.diagnosis.kind_report import names, part, percent
from missionplan.report.diagnosis.kinds import REPORTS
from missionplan.report.quantities import quantity
from missionplan.report.wording import capitalised, listed, parameter_in_words
from missionplan.results.learned import Diagnosis
from missionplan.results.learned.evidence import SURE, Coverage, ParameterEstimate, WrongFix
from missionplan.results.learned.levels import AHEAD, ParameterLevels

_PERCENT, _HOUR = 100.0, 3600.0
UNLIKELY = 0.05
"""Probability of what has no name from which it is told."""
LIKELIER = 0.5
"""Probability of what has no name from which nothing is ordered: a cause that is named may be its likeness; and that
there is nothing, below which a model without a cause is not called adequate."""
_NO_NAME = "no effect of the catalogue explains"
_DOUBTFUL = ("ambiguous", "partly-explained")
_TELLING = 2.0
"""Standard deviations from nothing to the size of an effect of the mission's own, below which it may be gone."""
_RIVALS = 2
"""Other explanations that the headline names."""


def finding_in_words(diagnosis: Diagnosis) -> str:
    """Write what was found and what to do: ``The compass reads 2.9° ± 0.3° low: swing it, …``; empty without causes.

    What the catalogue says nothing of, or too large to be its cause, is left to the verdict. A cause that may not be
    there is no order: what the crew is to do is then to find out.
    """
    parameters, disputed = claimed_parameters(diagnosis), disputed_causes(diagnosis)
    causes = frozenset(diagnosis.causes) - disputed
    # beside one that is disputed, what errors follow by statistics alone is disputed too
    certain = frozenset(cause for cause in causes if CATALOGUE[cause].tier == "physical") if disputed else causes
    phrases = {
        cause: _clause(cause, parameters, is_order=cause in certain, is_known=cause in diagnosis.changed)
        for cause in diagnosis.causes
    }
    if not phrases or not all(phrases.values()):
        return ""
    doubted = []
    for cause in (cause for cause in phrases if cause not in certain):
        chance = diagnosis.readings.inclusion.get(cause, 1.0)  # that it is there
        doubted.append(f"{phrases[cause]} ({part(chance)})" if chance < SURE else phrases[cause])
    if doubted and diagnosis.verdict in _DOUBTFUL:
        doubted[0] = f"it looks as if {doubted[0]}"
    clauses = [*(words for cause, words in phrases.items() if cause in certain), *doubted]
    words = capitalised(f"{'; and '.join(clauses)}{_gained(diagnosis)}.")
    if disputed:
        return f"{words} {_find_out(diagnosis, disputed, is_all=not certain)}"
    if diagnosis.verdict in _DOUBTFUL and diagnosis.none_of_these > UNLIKELY:
        words += f" Beside that, something that {_NO_NAME} may be there ({part(diagnosis.none_of_these)})."
    return words


def disputed_causes(diagnosis: Diagnosis) -> frozenset[str]:
    """Physical causes of the likeliest set from which nothing is ordered.

    With a probability above 5 % they are not there, what has no name is likelier than not, they are not the same all
    along, the data are of a kind that proves nothing, or they are no larger than what a made dead reckoning is in doubt
    by.
    """
    made = frozenset(diagnosis.readings.confounded_with_reckoning)
    if diagnosis.verdict not in _DOUBTFUL:
        return made
    physical = frozenset(cause for cause in diagnosis.causes if CATALOGUE[cause].tier == "physical")
    if REPORTS[diagnosis.kind].proves_nothing or diagnosis.none_of_these >= LIKELIER:
        return made | physical
    doubtful = {cause for cause, probability in diagnosis.readings.inclusion.items() if probability < SURE}
    return made | (physical & {*doubtful, *diagnosis.not_constant})


def _find_out(diagnosis: Diagnosis, disputed: frozenset[str], *, is_all: bool) -> str:
    """Write what else it may be, how likely that is, and what would tell."""
    chances = {entry.causes: entry.posterior for entry in diagnosis.ranking if entry.posterior is not None}
    others = [
        causes
        for causes in diagnosis.rivals
        if not disputed <= {*causes} and all(CATALOGUE[cause].tier != "neutral" for cause in causes)
    ]
    rivals = [f"{names(causes)} ({part(chances[causes])})" for causes in others if causes in chances][:_RIVALS]
    rivals = rivals or [names(causes) for causes in others[:_RIVALS]]
    if diagnosis.none_of_these > UNLIKELY:
        rivals.append(f"something that {_NO_NAME} ({part(diagnosis.none_of_these)})")
    until = next((entry.measurement for entry in diagnosis.next_measurements), REPORTS[diagnosis.kind].more_data)
    if disputed & {*diagnosis.readings.confounded_with_reckoning}:
        rivals.append("the dead reckoning itself, which was made without a logged speed")
        until = "log the vehicle's speed, or its own position, under water"
    if rivals:
        else_it_is = f"But it may be {listed(rivals, 'or')}"
    elif disputed & {*diagnosis.not_constant}:
        else_it_is = "But the record does not agree on its size"
    else:
        else_it_is = f"But {REPORTS[diagnosis.kind].proves_nothing or 'that is not sure enough to act on'}"
    return f"{else_it_is}: correct nothing {'yet' if is_all else 'else yet'}, first {until}."


def _clause(cause: str, parameters: tuple[ParameterEstimate, ...], *, is_order: bool, is_known: bool) -> str:
    info = CATALOGUE[cause]
    mine = {parameter.name: parameter for parameter in parameters if parameter.effect == cause}
    finding = next((t.finding for t in info.terms if t.finding and {*t.strengths} <= {*mine}), info.finding)
    if finding is None:
        return ""
    if is_known and _is_gone(finding, mine):
        gone = f"{names((cause,))}, which the mission has, is gone, as after a correction"
        return f"{gone}: correct nothing more, and plan on with mission.yaml of this folder" if is_order else gone
    limit = info.likeness
    if limit is not None and limit.parameter in mine and abs(mine[limit.parameter].value) > limit.size:
        return ""
    words = sized_clause(finding, mine)
    if info.tier == "neutral":
        return f"{words}: no effect that I know does that"
    return f"{words}: {finding.remedy}" if words and finding.remedy and is_order else words


def _is_gone(finding: Finding, mine: Mapping[str, ParameterEstimate]) -> bool:
    """Whether what is told of an effect may be nothing."""
    strengths = [mine.get(name) for name in finding.toward or (finding.parameter,)]
    return all(strength is not None and abs(strength.value) < _TELLING * strength.sd for strength in strengths)


def sized_clause(finding: Finding, mine: Mapping[str, ParameterEstimate]) -> str:
    """Write the clause of a finding with its size, by the parameters of its effect; empty where they lack it."""
    if not finding.parameter:
        return finding.positive
    estimate = mine.get(finding.parameter)
    if estimate is None:
        return ""
    searched = [estimate for estimate in mine.values() if CATALOGUE[estimate.effect].parameters[estimate.name].searched]
    at = " until ".join(map(_place, searched))
    if finding.toward is not None:
        east, north = (mine.get(name) for name in finding.toward)
        if east is None or north is None:
            return ""
        length = math.hypot(east.value, north.value)
        sd = math.hypot(east.value * east.sd, north.value * north.sd) / max(length, 1e-12)
        size = _size(replace(east, value=length, sd=sd), finding)
        direction = f"{math.degrees(math.atan2(east.value, north.value)) % 360.0:.0f}°"
        return finding.positive.format(size=size, direction=direction, at=at)
    clause = finding.negative if estimate.value < 0.0 and finding.negative else finding.positive
    return clause.format(size=_size(estimate, finding), at=at)


def _place(parameter: ParameterEstimate) -> str:
    """Write the moment of a change, a period, a threshold, or how often."""
    if not parameter.unit:
        return counted(round(parameter.value), "time")
    if parameter.unit != "s":
        return sized(parameter)
    hours = f"{parameter.value / _HOUR:.1f} h"
    is_moment = CATALOGUE[parameter.effect].parameters[parameter.name].searched == "time"
    return f"{hours} after the start" if is_moment else hours


def _size(estimate: ParameterEstimate, finding: Finding) -> str:
    """Write a size as the finding tells it: for so much of what it responds to, beyond so much, as a share."""
    value = finding.beyond + finding.each * estimate.value if finding.beyond else finding.each * abs(estimate.value)
    factor, unit = (_PERCENT, "%") if finding.in_percent else (1.0, finding.unit or estimate.unit)
    sd = finding.each * estimate.sd
    return sized(replace(estimate, value=factor * value, sd=factor * sd, unit=unit))


def _gained(diagnosis: Diagnosis) -> str:
    """Write how much better what was held out is predicted."""
    best = diagnosis.best
    if best is None or best.held_out is None:
        return ""
    return REPORTS[diagnosis.kind].gained(diagnosis, best.held_out.rmse_base, best.held_out.rmse_extended)


WORTH_TELLING = 1.0
"""Score of a cause that is not claimed from which it is told [nat]."""


def how_sure(diagnosis: Diagnosis) -> list[str]:
    """Write the paragraphs; the sections below them have the statistics."""
    words, best = [_among_the_tried(diagnosis)], diagnosis.best
    if diagnosis.causes and best is not None and best.held_out is not None:
        gain = best.held_out
        words.append(
            "Each part of the data was left out in turn and predicted from the others. Predicted better with what was "
            f"found than without: {gain.groups_improved} of {counted(gain.groups, 'part')}."
        )
    coverage = diagnosis.coverage
    if coverage is not None and coverage.is_off:
        share, scaled = (part(inside / coverage.count) for inside in (coverage.inside, coverage.inside_scaled))
        words.append(
            f"90 % intervals hold {share} of what was held out. With random errors {coverage.scale:.2f} times as "
            f"large, as in the extended mission, they hold {scaled}: the factor is assessed on other legs than it is "
            "fitted to."
        )
    return words


def open_in_words(data: str, lacking: str, nothing: float) -> str:
    """Write that no cause is claimed though there is one more likely than not; `lacking`: that there is."""
    return (
        f"{capitalised(data)} leave open whether the mission's model is adequate: {lacking} has a probability of "
        f"{percent(1.0 - nothing)}, too little to claim a cause: correct nothing yet."
    )


def _among_the_tried(diagnosis: Diagnosis) -> str:
    best = diagnosis.best
    if best is None:
        why = "could be fitted to these data" if diagnosis.learned_from else "was fitted: these data count once"
        return f"Nothing of the catalogue {why}."
    other = f"that none of these is behind it has a probability of {percent(diagnosis.none_of_these)}"
    if not diagnosis.causes:
        if diagnosis.verdict == "unexplained":
            return f"Of the explanations tried none fits what the data show; {other}."
        if (best.score > WORTH_TELLING or diagnosis.nothing < LIKELIER) and best.posterior is not None:
            return (
                f"Of the explanations tried none is claimed: the likeliest, {names(best.causes)}, has a probability of "
                f"{percent(best.posterior)}, and that there is some cause {percent(1.0 - diagnosis.nothing)}, of the "
                f"95 % that it needs. In doubt, {other}."
            )
        return f"Of the explanations tried none is needed: the data look as the mission expects. In doubt, {other}."
    if best.posterior is None:
        return f"Among the explanations tried, {names(best.causes)} fits best; {other}."
    return (
        f"Among the explanations tried, {names(best.causes)} has a probability of {percent(best.posterior)}; {other}."
    )


def intervals_that_miss(coverage: Coverage | None) -> str:
    """Say in a sentence that 90 % intervals do not hold 90 %, where chance does not explain it; else nothing."""
    if coverage is None or not coverage.is_off:
        return ""
    wide = "narrow" if coverage.scale > 1.0 else "wide"
    return (
        f"Its 90 % intervals are too {wide}: they hold {part(coverage.inside / coverage.count)} of what was held out."
    )


def trends_in_words(levels: Iterable[ParameterLevels], *, simulated: bool) -> Iterator[str]:
    """Tell each trend as one: ``A trend: with each mission the vehicle goes 2.0 ± 0.2 % slower …: clean the hull``.

    `simulated`: whether missions ahead were, to see when it matters.
    """
    for level in levels:
        if not level.has_trend:
            continue
        info, trend = CATALOGUE[level.effect], _estimate(level, level.trend, level.trend_sd)
        is_growing = level.trend * level.next_value > 0.0  # else "reads low" is said of a compass that reads less high
        clause = sized_clause(info.finding, {level.name: trend}) if info.finding is not None and is_growing else ""
        changes = _sized(level, level.trend, level.trend_sd)
        sentence = clause or f"{parameter_in_words(level.effect, level.name)} changes by {changes}"
        urgent = f" In {counted(level.matters_in or 0, 'mission')} it costs success."
        if level.matters_in is None:
            urgent = f" Within {AHEAD[-1]} missions it costs no success." if simulated else ""
        upkeep = info.upkeep[level.trend < 0.0]
        coming = _sized(level, level.next_value, level.next_sd)
        yield f"A trend: with each mission {sentence}: {upkeep}. The next mission is planned with {coming}.{urgent}"


def ageing_in_words(
    levels: Sequence[ParameterLevels], records: Mapping[str, str], *, simulated: bool = False
) -> Iterator[str]:
    """Tell each trend, and before which record a parameter jumped, by the name of the record where one is given."""
    yield from trends_in_words(levels, simulated=simulated)
    for level in levels:
        for jump in level.jumps:
            name, before = (
                capitalised(parameter_in_words(level.effect, level.name)),
                records.get(jump.record, jump.record),
            )
            yield f"{name} jumped before {before}, to {_sized(level, jump.value, jump.sd)}."


def _estimate(level: ParameterLevels, value: float, sd: float) -> ParameterEstimate:
    return ParameterEstimate(level.effect, level.name, value, sd, value - sd, value + sd, level.unit)


def _sized(level: ParameterLevels, value: float, sd: float) -> str:
    """Write a value of a parameter, a share in per cent."""
    finding = CATALOGUE[level.effect].finding
    estimate = _estimate(level, value, sd)
    if finding is not None and finding.in_percent and finding.parameter == level.name:
        estimate = replace(estimate, value=100.0 * value, sd=100.0 * sd, unit="%")
    return sized(estimate)


MOST_TOLD = 4
"""Wrong fixes that are told one by one."""


def suspects_in_words(diagnosis: Diagnosis) -> str:
    """Say which dives look wrongly labelled and which fixes wrong; empty where none does."""
    return f"{diagnosis.suspect_labels}{wrong_fixes_in_words(diagnosis.readings.wrong_fixes)}"


def wrong_fixes_in_words(fixes: Sequence[WrongFix]) -> str:
    """Say which fixes are wrong, and where they lie; empty where none is."""
    if not fixes:
        return ""
    places = [
        f"{quantity(math.hypot(fix.east_m, fix.north_m), 'm', '.0f')} toward "
        f"{math.degrees(math.atan2(fix.east_m, fix.north_m)) % 360.0:.0f}° after leg {fix.leg}"
        for fix in sorted(fixes, key=lambda fix: -fix.probability)[:MOST_TOLD]
    ]
    places += [f"{len(fixes) - MOST_TOLD} more"] if len(fixes) > MOST_TOLD else []
    count = "A GPS fix looks wrong, by" if len(fixes) == 1 else f"{len(fixes)} GPS fixes look wrong, by"
    return f"{count} {listed(places)}: correct them, or leave out the legs on both sides, and diagnose again."
