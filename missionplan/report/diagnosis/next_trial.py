"""The next trial in words: what it would save, what it takes, what each outcome would mean, and the other designs."""

import math

from missionplan.datasets.leg_checks import MIN_LEGS
from missionplan.effects import CATALOGUE
from missionplan.report.diagnosis.causes import names, part, percent
from missionplan.report.numbers import number
from missionplan.report.page import Block, PageSection, Table
from missionplan.report.quantities import length_in_words, quantity
from missionplan.report.wording import capitalised
from missionplan.results.learned.next_trial import NextTrial, OutcomeRule, ValuedDesign

_CHOSEN = {"d_max_m": "d_max", "anchor_wet_weight_n": "the anchor's wet weight"}
_CHOSEN_NOW = {"d_max_m": "one d_max for all transits", "anchor_wet_weight_n": "the anchor's wet weight"}
_LISTED = 12
"""Designs in the table, at most."""
_NOTHING = "Nothing: no more than three standard errors."
_NO_SHORE = "Times and energies are the trial's own, without the way there and back and without handling."


def next_trial_section(found: NextTrial | None) -> list[PageSection]:
    """Tell which trial is worth making next, or why none is."""
    if found is None:
        return []
    if found.reason is not None:
        return [PageSection("The next trial", [f"No trial was valued: {found.reason}."])]
    heading = "No trial is worth it" if found.best is None else "The next trial"
    blocks: list[Block] = [next_trial_words(found), _assumptions(found)]
    if found.best is not None:
        blocks += [*_few_legs(found), _outcomes(found), *_rule_words(found)]
    return [PageSection(heading, [*blocks, _designs(found)])]


def next_trial_told(found: NextTrial | None) -> str:
    """Tell it after the answer, on a terminal; empty where no trial was asked for."""
    if found is None:
        return ""
    if found.reason is not None:
        return f" No trial was valued: {found.reason}."
    words = next_trial_words(found).replace("in this folder", "in the report's folder")
    words = words.replace("The table says", "Its table says")
    return f" {words}" if found.best is None else f" Next trial: {words[:1].lower()}{words[1:]}"


def next_trial_pointer(found: NextTrial | None) -> list[str]:
    """Say among what to do next that a trial is worth making, or that none is, and that more follows."""
    if found is None or found.reason is not None:
        return []
    if found.best is None:
        return ["No trial is worth it for the plan; what would tell more of the causes is for its own sake."]
    return [f"{capitalised(found.best.name)}: the trial worth making next, and what its outcomes would mean, below."]


def next_trial_words(found: NextTrial) -> str:
    """Say in a sentence or two what to do."""
    if found.best is None:
        reason = (
            "none of these would change the choice enough to be told from chance"
            if found.perfect
            else "the choice would not change, not even with causes and sizes known exactly"
        )
        return (
            f"No trial is worth it: {reason}. {_choice_now(found)} The table says what trials would tell of the "
            "causes, where that is wanted for itself."
        )
    best = found.best
    file = ", as in next-trial.yaml in this folder" if found.trial is not None else ""
    perfect = f"{_loss(found.perfect, found)} that knowing everything would save"
    share = f"of {perfect}" if best.saving < found.perfect else f"as far as chance lets it be told all of the {perfect}"
    return (
        f"{capitalised(best.name)}{file}: {_takes(best)}, and saves {_loss(best.saving, found)} a mission on average "
        f"(± {_loss(best.saving_error, found)}), {share}. "
        f"{_choice_now(found)} The trial pays for itself {_payback(found)}."
    )


def _choice_now(found: NextTrial) -> str:
    brings = f"success {percent(found.success)}, {_loss(found.loss, found)} a mission with its failures"
    return (
        f"With what is known now, {_CHOSEN_NOW[found.decides]} is best at {_value(found, found.choice)} "
        f"({_edge(found)}{brings})."
    )


def _edge(found: NextTrial) -> str:
    """Say that a choice is the last of those tried: one beyond it might be better still."""
    least, most = found.tried
    words = ("the shortest tried; ", "the longest tried; ")
    if found.decides == "anchor_wet_weight_n":
        words = ("the lightest tried; ", "the heaviest tried; ")
    return words[0] if found.choice <= least else words[1] if found.choice >= most else ""


def _payback(found: NextTrial) -> str:
    best = found.best
    spent = None if best is None else best.energy_wh if found.unit == "W h" else best.minutes
    if best is None or spent is None or spent <= best.saving:
        return "with the first mission"
    return f"after {math.ceil(spent / best.saving)} missions"


def _takes(design: ValuedDesign) -> str:
    energy = f" and {number(design.energy_wh, 0.02 * design.energy_wh)} W h" if design.energy_wh else ""
    return f"takes {number(design.minutes, 0.02 * design.minutes)} min{energy}"


def _loss(value: float, found: NextTrial) -> str:
    return f"{value:.2g} {found.unit}" if value < 100.0 else f"{value:.0f} {found.unit}"


def _value(found: NextTrial, value: float) -> str:
    return length_in_words(value) if found.decides == "d_max_m" else quantity(value, "N", ".3g")


def _assumptions(found: NextTrial) -> str:
    shares = "; ".join(f"{names(causes)} {part(p)}" for causes, p in found.explanations)
    return (
        f"Assumed: one of these explanations holds ({shares}), with parameters as known now; a mission that fails "
        f"counts as {_loss(found.failure_loss, found)} lost, ten missions that work; only {_CHOSEN[found.decides]} is "
        "chosen anew after the trial; random errors are as large in the trial as in the data so far."
    )


def _few_legs(found: NextTrial) -> list[str]:
    """Say what to do with a trial of so few legs that they are no data set of their own."""
    phases = found.trial.get("phases") if found.trial is not None else None
    legs = len(phases) if isinstance(phases, list) and found.decides == "d_max_m" else MIN_LEGS
    if legs >= MIN_LEGS:
        return []
    return [f"Fewer than {MIN_LEGS} legs are no data set of their own: add them to the log so far, as another run."]


def _outcomes(found: NextTrial) -> Table:
    rows = [
        [
            names(each.causes),
            part(each.probability),
            _value(found, each.choice),
            "nothing" if each.choice == found.choice else _loss(max(each.saving, 0.0), found),
        ]
        for each in found.outcomes
    ]
    columns = ["If it then looks most like", "How likely", f"{_CHOSEN[found.decides]} becomes", "Saves"]
    return Table(columns, rows, "What the outcomes of that trial would mean; those rarer than 2 % are left out.")


def _rule_words(found: NextTrial) -> list[str]:
    rule = found.rule
    if rule is None:
        return [
            "No single parameter decides: give the trial's data to diagnose, and choose with the mission it writes."
        ]
    side = "above" if rule.above else "below"
    return [
        f"If the {_parameter(rule)} comes out {side} {_threshold(rule)}, take it for {names(rule.causes)} and choose "
        f"{_value(found, rule.choice)}; else keep {_value(found, found.choice)}. That rule agrees with the full "
        f"calculation in {part(rule.agreement)} of the simulated outcomes."
    ]


def _parameter(rule: OutcomeRule) -> str:
    alone = len(CATALOGUE[rule.effect].parameters) == 1
    effect = names((rule.effect,))
    return f"{rule.name.replace('_', ' ')} of {effect}" if not alone else f"{effect} ({rule.name.replace('_', ' ')})"


def _threshold(rule: OutcomeRule) -> str:
    if rule.unit == "rad":
        return f"{math.degrees(rule.threshold):.2g}°"
    return quantity(rule.threshold, rule.unit, ".2g")


def _designs(found: NextTrial) -> Table:
    first = () if found.best is None else (found.best,)
    listed = (*first, *(each for each in found.designs if each is not found.best))[:_LISTED]
    rows = [
        [
            capitalised(each.name),
            f"{each.minutes:.0f}",
            "" if each.energy_wh is None else f"{each.energy_wh:.3g}",
            f"{each.information:.2g}",
            _saving(each, found),
        ]
        for each in listed
    ]
    columns = ["Trial", "Time (min)", "Energy (W h)", "Information (nats)", f"Saves ({found.unit} a mission)"]
    rest = len(found.designs) - _LISTED
    more = f" {rest} more in next-trials.csv." if rest > 0 else ""
    order = "The recommended one, then those that save or tell most." if first else "Those that tell most first."
    return Table(columns, rows, f"{order} {_NOTHING} {_NO_SHORE}{more}")


def _saving(design: ValuedDesign, found: NextTrial) -> str:
    if design.saving <= 3.0 * design.saving_error:
        return "nothing"
    return f"{design.saving:.2g} ± {design.saving_error:.1g}"
