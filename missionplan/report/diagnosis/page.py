"""Report of a diagnosis: what the mission gets wrong, how sure that is, and what to do next."""

import math

from missionplan.effects import CATALOGUE
from missionplan.report.diagnosis.evidence import (
    claimed_parameters,
    discrepancy_section,
    distinction_section,
    draw_held_out,
    draw_ranking,
    exact_in_words,
    exact_section,
    held_out_section,
    known_section,
    ranking_rows,
    ranking_section,
    resemblance,
    sized,
)
from missionplan.report.diagnosis.findings import (
    LIKELIER,
    UNLIKELY,
    WORTH_TELLING,
    disputed_causes,
    finding_in_words,
    how_sure,
    intervals_that_miss,
    open_in_words,
    suspects_in_words,
    trends_in_words,
)
from missionplan.report.diagnosis.kind_report import causes_section, explanations_in_words, found_causes, names, percent
from missionplan.report.diagnosis.kinds import REPORTS
from missionplan.report.diagnosis.plan import (
    next_trial_pointer,
    next_trial_section,
    next_trial_told,
    plan_section,
    plan_words,
)
from missionplan.report.diagnosis.scoring import dataset_sections, told
from missionplan.report.page import Block, Page, PageSection, Table, typed
from missionplan.report.quantities import in_reader_units, reader_unit
from missionplan.report.wording import capitalised, listed
from missionplan.results.learned import Diagnosis
from missionplan.results.learned.evidence import SURE, NextMeasurement, ParameterEstimate

_INDISTINGUISHABLE = 1.0
"""Expected nats below which a measurement separates nothing."""
_KEEP = (
    "Plan on with mission.yaml in this folder: the same mission with its noise, and what effects it has, as known now. "
    "The last table gives its noise levels as fitted."
)
_COLOURS = {"adequate": "good", "explained": "good", "unexplained": "bad"}
_CONFIRMED = 3
"""Parameters of the mission's own effects that the headline names."""
_MOVED = 2.0
"""Standard deviations by which a parameter is another than it was, and not confirmed."""
_BEYOND_DOUBT = math.log(1e4)
"""Expected ln Bayes factor above which its size says no more."""


def page(diagnosis: Diagnosis) -> Page:
    """Build the page of a diagnosis."""
    kind = REPORTS[diagnosis.kind]
    made = diagnosis.provenance
    share = made.options.get("holdout")
    again = {"next_trial": diagnosis.next_trial is not None or None, "holdout": None if share is None else f"{share:g}"}
    return Page(
        title=f"Diagnosis of {diagnosis.provenance.mission} with {diagnosis.data}",
        answer=answer(diagnosis),
        draw=lambda: kind.data_figure(diagnosis),
        numbers=_numbers(diagnosis),
        write=lambda: _sections(diagnosis),
        verdict="" if is_open(diagnosis) or exact_in_words(diagnosis) else _COLOURS.get(diagnosis.verdict, ""),
        rerun=typed("diagnose", made.file, made.options["dataset"], seed=made.seed, **again),
        table=lambda: ranking_rows(diagnosis.ranking[:6]),
        sentence=f"{answer(diagnosis)}{next_trial_told(diagnosis.next_trial)}",
        plots={"ranking": draw_ranking, "held_out": draw_held_out},
    )


def _sections(diagnosis: Diagnosis) -> list[PageSection]:
    last, residuals = diagnosis.last_part, REPORTS[diagnosis.kind].residual_figures(diagnosis)
    blocks: list[Block] = []
    if diagnosis.source:
        blocks.append(f"Source: {diagnosis.source}")
    words = REPORTS[diagnosis.kind].calibration
    rows = [[words.get(name, name), f"{value:.4g}"] for name, value in diagnosis.calibration.items()]
    blocks.append(Table(["Calibration of the base model", "Value (SI)"], rows, "Fitted beside the causes; no cause."))
    if diagnosis.failures:
        failures = [list(item) for item in diagnosis.failures.items()]
        blocks.append(Table(["Set that could not be fitted", "Why"], failures, text_columns=2))
    return [
        PageSection("What to do next", _next_words(diagnosis), is_summary=True),
        *plan_section(diagnosis),
        PageSection("How sure this is", how_sure(diagnosis), is_summary=True),
        *exact_section(diagnosis),
        *next_trial_section(diagnosis.next_trial),
        ranking_section(diagnosis),
        *causes_section(diagnosis),
        *known_section(diagnosis),
        *([PageSection("What was left before, and what is left now", residuals)] if residuals else []),
        *held_out_section(diagnosis),
        *([] if last is None else dataset_sections(last, "The last part, held out")),
        discrepancy_section(diagnosis),
        distinction_section(diagnosis),
        PageSection("How the data were treated", blocks),
    ]


def answer(diagnosis: Diagnosis) -> str:
    """Tell what was found and what to do about it, then the verdict, with the size of the misfit."""
    finding = f"{suspects_in_words(diagnosis)} {finding_in_words(diagnosis)}".strip()
    size = in_reader_units(diagnosis.misfit)
    verdict = " ".join(filter(None, (_verdict_words(diagnosis), intervals_that_miss(diagnosis.coverage), size)))
    simulated = bool(diagnosis.provenance.options.get("plan") and diagnosis.learned_from)
    aged = "".join(f" {words}" for words in trends_in_words(diagnosis.levels, simulated=simulated))
    last, kept = diagnosis.last_part, ""
    if last is not None:
        many = "legs" if last.kind == "transit" else "dives"
        kept = f" Kept away from all this, the last {last.groups} {many}: the extended mission {told(last)}"
        kept += "" if last.is_within_chance else " Chance does not allow such coverages."
    return f"{finding} {verdict}{exact_in_words(diagnosis)}{aged}{kept}".strip()


def _verdict_words(diagnosis: Diagnosis) -> str:
    without = _without_cause(diagnosis)
    if without:
        return without
    words = _claim(diagnosis)
    if diagnosis.readings.plan_with is False:
        words += " Named, but plan without it: kept-away data are predicted no better with it, all the way."
    words += _changed(diagnosis)
    if diagnosis.not_constant:
        verb = "is" if len(diagnosis.not_constant) == 1 else "are"
        words += f" {capitalised(names(diagnosis.not_constant))} {verb} {REPORTS[diagnosis.kind].not_constant}."
    if any(CATALOGUE[cause].tier != "physical" for cause in diagnosis.causes):
        words += " Part of this describes the errors statistically; its physical cause is not identified."
    return words.strip()


def is_open(diagnosis: Diagnosis) -> bool:
    """Whether no cause is claimed, though it is likelier that there is one."""
    return diagnosis.verdict == "adequate" and diagnosis.nothing < LIKELIER


def _without_cause(diagnosis: Diagnosis) -> str:
    """Write the verdict where no physical cause is claimed; empty where one is."""
    left = resemblance(diagnosis.discrepancy)
    if not diagnosis.learned_from:
        is_left = diagnosis.discrepancy.axis is not None
        left_over = f" As it stands it leaves something in them: that {left}." if is_left else ""
        return f"Nothing new: the mission has learned from all of these data, which count once.{left_over}"
    best = diagnosis.best
    if is_open(diagnosis):
        likeliest = f" ({names(best.causes)}, it may be)" if best is not None else ""
        return open_in_words("these data", f"that it lacks something{likeliest}", diagnosis.nothing)
    if diagnosis.verdict == "adequate":
        asks = "nothing in them asks for a cause"
        if best is not None and best.score > WORTH_TELLING:
            asks = f"what speaks for a cause ({names(best.causes)}) is too weak to claim it"
        return f"The mission's model is adequate for these data: {asks}.{_confirmed(diagnosis)}"
    if diagnosis.verdict != "unexplained":
        return ""
    if diagnosis.suspect_labels:
        return "No cause of the catalogue explains the dives as they are labelled."
    if diagnosis.causes:
        named = found_causes(diagnosis.causes, claimed_parameters(diagnosis))
        return f"The data fit {named}, which describes the errors: their physical cause is not identified."
    # that something is left, how sure that is, and what it is like
    is_sure = diagnosis.none_of_these >= 1.0 - UNLIKELY
    chance = "" if is_sure else f" (with a probability of {percent(diagnosis.none_of_these)})"
    like = [f": it looks like {what}" for _, what, _ in diagnosis.readings.responses[:1]]
    if diagnosis.discrepancy.axis is not None:
        like = [f": it {left}"]
    return f"Something is left{chance} that no cause of the catalogue explains{''.join(like)}."


def _claim(diagnosis: Diagnosis) -> str:
    """Write what is claimed, and how far."""
    named = found_causes(diagnosis.causes, claimed_parameters(diagnosis))
    is_told = bool(finding_in_words(diagnosis))  # and what else it may be
    if diagnosis.verdict == "partly-explained":
        is_left = diagnosis.discrepancy.axis is not None
        left = f"what is left {resemblance(diagnosis.discrepancy)}." if is_left else ""
        if is_told and disputed_causes(diagnosis):
            return capitalised(left)
        return f"The largest share of the misfit resembles {named}, but not all of it{f': {left}' if left else '.'}"
    if diagnosis.verdict == "ambiguous":
        if is_told:
            return ""
        others = [names(causes) for causes in diagnosis.rivals[:3]]
        rest = f"; {' or '.join(others)} would do nearly as well" if others else ", which is not sure"
        return f"The data fit {named}{rest}."
    change = "a change of " if {*diagnosis.causes} <= {*diagnosis.changed} else ""
    shares = {entry.causes: entry.posterior for entry in diagnosis.ranking if entry.posterior is not None}
    members = next((family for family in diagnosis.readings.families if diagnosis.causes in family), ())
    either = [f"{names(causes)} {percent(shares[causes])}" for causes in members if causes in shares]
    turns = f" Whether this current turns, the record cannot show: {', '.join(either)}." if len(either) > 1 else ""
    return f"The misfit is explained by {change}{named}.{turns}"


def _confirmed(diagnosis: Diagnosis) -> str:
    """Say what the data bear out of what the mission knew, and what of it is in doubt."""
    before = {(p.effect, p.name): p for p in diagnosis.known}
    sure = [
        p  # of the moment from which an effect acts a later record tells nothing
        for p in diagnosis.confirmed
        if p.effect in diagnosis.borne_out and CATALOGUE[p.effect].parameters[p.name].searched != "time"
    ]
    words, more = "", len(sure) - _CONFIRMED
    pairs = [(p, before[p.effect, p.name]) for p in sure[:_CONFIRMED]]
    for lead, is_moved in ("Confirmed", False), ("Moved, within what the mission allows for", True):
        sizes = [
            f"{_parameter_words(now)} is {sized(now)}, was {sized(was)}"
            for now, was in pairs
            if is_moved == (abs(now.value - was.value) > _MOVED * math.hypot(now.sd, was.sd))
        ]
        words += f" {lead}: {'; '.join(sizes)}." if sizes else ""
    words += f" {more} more below." if more > 0 else ""
    effects = dict.fromkeys(
        effect for explanation in diagnosis.explanations if explanation.prior for effect in explanation.causes
    )
    chances = {effect: diagnosis.probability_of(effect) for effect in effects}
    doubted = [f"{names((effect,))} ({percent(p)})" for effect, p in chances.items() if 1.0 - SURE <= p < SURE]
    return f"{words} In doubt is {listed(doubted, 'or')}." if doubted else words


def _changed(diagnosis: Diagnosis) -> str:
    """Say what is not as the mission knew it."""
    after = {(p.effect, p.name): p for p in claimed_parameters(diagnosis)}
    changes = [
        f"{_parameter_words(p)} has changed from {sized(p)} to {sized(after[p.effect, p.name])}"
        for p in diagnosis.known
        if p.effect in diagnosis.changed and (p.effect, p.name) in after
    ]
    return f" {capitalised('; '.join(changes))}." if changes else ""


def _parameter_words(parameter: ParameterEstimate) -> str:
    """Name a parameter: its effect alone where that has no other."""
    effect = names((parameter.effect,))
    alone = len(CATALOGUE[parameter.effect].parameters) == 1
    return effect if alone else f"{parameter.name.replace('_', ' ')} of {effect}"


def _numbers(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """The probability of what is named, and what it gains; nothing where nothing is named."""
    best = diagnosis.best
    if not diagnosis.causes or best is None:
        return []
    numbers = [(f"Probability of {names(best.causes)}", percent(best.posterior))] if best.posterior is not None else []
    if best.held_out is not None:
        gain = best.held_out
        unit = reader_unit(REPORTS[diagnosis.kind].unit, gain.rmse_base)
        errors = f"{unit(gain.rmse_base):#.2g} → {unit(gain.rmse_extended):#.2g}{unit.suffix}"
        numbers.append(("Error on data held out, before and after", errors))
    return numbers


def _plan_on(diagnosis: Diagnosis) -> list[str]:
    """Say with which mission to plan, and what of it is in doubt."""
    words = plan_words(diagnosis) if diagnosis.causes and diagnosis.readings.plan_with is not False else []
    if diagnosis.readings.plan_with is False:
        file = diagnosis.provenance.file or "the mission as it was"
        reason = "The extended mission, mission.yaml in this folder, is what the next diagnosis needs."
        words.append(f"Plan with {file}. {reason}")
    elif diagnosis.causes:
        doubt = ", in each trial one of the explanations" if diagnosis.explanations else ""
        beginning = f"mission.yaml in this folder plans with what was found{doubt}"
        words.append(f"{beginning}: simulate, size-anchor, sweep-dmax run it.")
    return [*words, *explanations_in_words(diagnosis)]


def _next_words(diagnosis: Diagnosis) -> list[str]:
    if not diagnosis.learned_from:
        return ["Plan on with the mission as it is: mission.yaml in this folder is the same. Diagnose new data."]
    words = [*_plan_on(diagnosis), *next_trial_pointer(diagnosis.next_trial)]
    if diagnosis.next_trial is None or diagnosis.next_trial.best is None:
        words += [_measurement_words(entry) for entry in diagnosis.next_measurements]
    if diagnosis.outlying_groups:
        listed = ", ".join(f"{group} (p = {p_value:.1g})" for group, p_value in diagnosis.outlying_groups)
        words.append(f"Check these parts of the record, which the rest does not predict: {listed}. A wrong label?")
    if diagnosis.verdict == "adequate":
        words.append(_KEEP)
    if diagnosis.verdict == "unexplained" and not diagnosis.suspect_labels:
        changed = "" if diagnosis.discrepancy.axis is None else f" along {diagnosis.discrepancy.axis}"
        words.append(f"Look for what changed{changed}; on this evidence no cause of the catalogue can be named.")
    return words


def _measurement_words(entry: NextMeasurement) -> str:
    """Say what to measure, and how clearly that is expected to tell two explanations apart."""
    (first, second), nats = (names(causes) for causes in entry.separates), entry.expected_log_bayes_factor
    if nats < _INDISTINGUISHABLE:
        return f"No measurement considered would tell {first} from {second}."
    favour = "expected to tell them apart beyond doubt"
    if nats <= _BEYOND_DOUBT:
        factor = f"{math.exp(nats):.2g}" if nats < math.log(100.0) else f"{float(f'{math.exp(nats):.1e}'):.0f}"
        favour = f"expected to make the true one {factor} times as probable against the other"
    return f"To tell {first} from {second}: {entry.measurement} ({favour})."
