"""What a diagnosis means for the plan, before and after, and the next trial that is worth making."""

import math

from missionplan.datasets.legs import MIN_LEGS
from missionplan.effects import CATALOGUE
from missionplan.report.diagnosis.kind_report import names, part, percent
from missionplan.report.page import Block, PageSection, Table
from missionplan.report.quantities import Unit, length_in_words, quantity, reader_unit
from missionplan.report.wording import capitalised, number
from missionplan.results.learned import Diagnosis, Plan
from missionplan.results.learned.next_trial import NextTrial, ValuedDesign

_COLUMNS = {
    "d_max_m": "d_max",
    "cost": "Mean cost",
    "arrived": "Arrive",
    "anchor_wet_weight_n": "Anchor's wet weight",
    "within_radius": "Within the radius",
    "struck_seafloor": "Strike the seafloor",
    "success": "Missions that succeed",
}
_UNITS = {"d_max_m": "m", "anchor_wet_weight_n": "N"}
_NOTES = {
    "anchor_wet_weight_n": (
        "Anchors sized for the worst current (Eq. 15), and to carry the vehicle's net buoyancy besides."
    ),
    "d_max_m": (
        "The question is whether what was found asks for another d_max: the best of ten, from a tenth of the way to "
        "all of it, which sweep-dmax refines. Mean cost: time beyond that of the straight way, as a share of it."
    ),
}
_SAME_SHARE, _SAME_COST = 0.02, 0.002
"""Differences of a probability, and of a mean cost, that call for no other plan."""
_SERVES = 0.9
"""Probability of staying within the radius below which an anchor is no plan."""


def plan_section(diagnosis: Diagnosis) -> list[PageSection]:
    """Show the plans side by side, or the reason why there are none; nothing where nothing asks for another plan."""
    gain = diagnosis.decision
    if gain.after and not diagnosis.causes:
        return []
    if not gain.after:
        return [PageSection("No plans to compare", [gain.reason])] if gain.reason else []
    if gain.as_written_under_extended is not None:
        anew = "Planned anew" if diagnosis.verdict == "explained" else "Planned anew, if that is what it was"
        plans = {"The mission as it is": gain.as_written_under_extended, anew: gain.after}
    else:
        plans = {
            "Plan with the mission's model, as it expects": gain.before,
            "Plan with the extended model": gain.after,
            "The former plan, if the extended model is true": gain.base_choice_under_extended or {},
        }
    keys = [key for key in _COLUMNS if key in gain.after]
    rows = [[name, *(_cell(key, plan.get(key)) for key in keys)] for name, plan in plans.items() if plan]
    table = Table(["", *(f"{_COLUMNS[key]}{_unit(key).axis}" for key in keys)], rows, _NOTES[keys[0]])
    return [PageSection("What it means for the plan", [table], is_summary=True)]


def _cell(key: str, value: float | None) -> str:
    """Write a number of a plan; shares, as everywhere in the report, in per cent."""
    if value is None:
        return ""
    shown = _unit(key)(value)
    return number(shown) if key in _UNITS else number(shown, 0.1 if key == "cost" else 1.0)


def _unit(key: str) -> Unit:
    """Unit of a number of a plan: per cent, or the reader's."""
    return reader_unit(_UNITS[key], 0.0) if key in _UNITS else Unit("%", 0.01)


def plan_words(diagnosis: Diagnosis) -> list[str]:
    """Describe the plan that the extended model asks for, and how the mission's own would fare."""
    gain = diagnosis.decision
    before, after, kept = gain.before, gain.after, gain.base_choice_under_extended
    if not (before and after and kept):
        return []
    tell = _anchor if "anchor_wet_weight_n" in after else _legs
    mission_plan = gain.as_written_under_extended
    words = tell(None, after, mission_plan) if mission_plan is not None else tell(before, after, kept)
    struck = after.get("struck_seafloor") or 0.0
    if struck > _SAME_SHARE:
        words += f" With that anchor the vehicle strikes the seafloor in {part(struck)}: lengthen the line."
    return [capitalised(words) if diagnosis.verdict == "explained" else f"If that is what it was: {words}"]


def _anchor(before: Plan | None, after: Plan, kept: Plan) -> str:
    """Tell of an anchor, with what the mission's model expected of the former one, where that is its own choice."""
    weight, other = (quantity(_number(plan, "anchor_wet_weight_n"), "N", ".3g") for plan in (kept, after))
    share, best = (_number(plan, "within_radius") for plan in (kept, after))
    expected = None if before is None else _number(before, "within_radius")
    former = (
        f"the mission's anchor, {weight} wet,"
        if before is None
        else f"the anchor of the mission's model, {weight} wet,"
    )
    if abs(share - (best if expected is None else expected)) < _SAME_SHARE:
        return f"{former} still serves: {part(share)} within the radius."
    fares = f"{former} stays within the radius in {part(share)} of the dives"
    fares += "" if expected is None else f", not in {part(expected)}"
    more = "size-anchor with --probability finds the weight for more"
    if weight == other:
        return f"{fares}; {more}."
    if best < _SERVES:
        return f"{fares}, and one sized with the extended model, {other} wet, in {part(best)}; {more}."
    return f"plan with an anchor of {other} wet, {part(best)} within the radius; {fares}."


def _legs(before: Plan | None, after: Plan, kept: Plan) -> str:
    length, other = (_length(_number(plan, "d_max_m")) for plan in (kept, after))
    cost, best = (_number(plan, "cost") for plan in (kept, after))
    expected = "" if before is None else f" (expected: {_delay(_number(before, 'cost'))})"
    former = "the mission's d_max" if before is None else "the d_max of the mission's model"
    arrive, arrives = (_number(plan, "arrived") for plan in (kept, after))
    if arrives < _SERVES:
        fares = f"with {other} {part(arrives)} of the transits arrive, with {former}, {length}, {part(arrive)}"
        return f"no d_max serves: {fares}."
    if length == other or cost < best + _SAME_COST:
        return f"{former}, {length}, still serves: it takes {_beside_straight(cost)}{expected}."
    return (
        f"plan with a d_max of {other}, for {_beside_straight(best)}; {former}, {length}, would take "
        f"{_delay(cost)}{expected}."
    )


def _number(plan: Plan, key: str) -> float:
    """A number of a plan; infinite where it has none, as the cost of legs of which some never arrive."""
    value = plan.get(key)
    return math.inf if value is None else value


def _length(metres: float) -> str:
    return quantity(metres, "m", ".0f") if metres < 1000.0 else quantity(metres / 1000.0, "km", ".3g")


def _delay(cost: float) -> str:
    """Write a mean cost as a share of the straight way's time."""
    if math.isinf(cost):
        return "no end"
    share = 100.0 * cost
    return (f"{share:.0f} %" if abs(share) >= 10.0 else f"{share:.2g} %").replace("-", "−")


def _beside_straight(cost: float) -> str:
    """Write it in full: beyond the straight way's time, or less where the current helps."""
    return f"{_delay(abs(cost))} {'less than' if cost < 0.0 else 'beyond'} the straight way's time"


_CHOSEN = {"d_max_m": "d_max", "anchor_wet_weight_n": "the anchor's wet weight"}
_CHOSEN_NOW = {"d_max_m": "one d_max for all transits", "anchor_wet_weight_n": "the anchor's wet weight"}
_LISTED = 12
"""Designs in the table, at most."""
_NOTHING = "Nothing: no more than three standard errors."
_NO_SHORE = "Times and energies are the trial's own, without the way there and back and without handling."


def next_trial_section(study: NextTrial | None, folder: str = "this folder") -> list[PageSection]:
    """Tell which trial is worth making next, or why none is; its mission lies in a folder."""
    if study is None:
        return []
    if study.reason is not None:
        return [PageSection("The next trial", [f"No trial was valued: {study.reason}."])]
    heading = "No trial is worth it" if study.recommended is None else "The next trial"
    blocks: list[Block] = [next_trial_words(study).replace("this folder", folder), _assumptions(study)]
    phases = study.trial.get("phases") if study.trial is not None else None
    if isinstance(phases, list) and study.decides == "d_max_m" and len(phases) < MIN_LEGS:
        few = f"Fewer than {MIN_LEGS} legs are no data set of their own"
        blocks.append(f"{few}: add them to the log so far, as another run.")
    if study.best is not None:
        blocks += [_outcomes(study), *_rule_words(study)]
    return [PageSection(heading, [*blocks, _designs(study)])]


def next_trial_told(study: NextTrial | None, folder: str = "") -> str:
    """Tell it after the answer, on a terminal; empty where no trial was asked for. Its mission lies in a subfolder."""
    if study is None:
        return ""
    if study.reason is not None:
        return f" No trial was valued: {study.reason}."
    words = next_trial_words(study).replace("in this folder", f"in the report's folder {folder}".strip())
    words = words.replace("The table says", "Its table says")
    return f" {words}" if study.recommended is None else f" Next trial: {words[:1].lower()}{words[1:]}"


def next_trial_pointer(study: NextTrial | None) -> list[str]:
    """Say among what to do next that a trial is worth making, or that none is, and that more follows."""
    if study is None or study.reason is not None:
        return []
    if study.recommended is None:
        return ["No trial is worth it for the plan; what would tell more of the causes is for its own sake."]
    more = "" if study.best is None else ", and what its outcomes would mean"
    return [f"{capitalised(study.recommended.name)}: the trial worth making next{more}, below."]


def next_trial_words(study: NextTrial) -> str:
    """Say in a sentence or two what to do."""
    if study.best is None:
        reason = (
            "none of these would change the choice enough to be told from chance"
            if study.perfect
            else "the choice would not change, not even with causes and sizes known exactly"
        )
        if study.settling is not None:
            return f"{_about_vehicle(study)} For the plan no trial is worth it: {reason}. {_choice_now(study)}"
        return (
            f"No trial is worth it: {reason}. {_choice_now(study)} The table says what trials would tell of the "
            "causes, where that is wanted for itself."
        )
    best = study.best
    perfect = f"{_loss(study.perfect, study)} that knowing everything would save"
    share = f"of {perfect}" if best.saving < study.perfect else f"as far as chance lets it be told all of the {perfect}"
    spent = best.energy_wh if study.unit == "W h" else best.minutes
    after = "with the first mission"
    if spent is not None and spent > best.saving:
        after = f"after {math.ceil(spent / best.saving)} missions"
    return (
        f"{capitalised(best.name)}{_file(study)}: {_takes(best)}, and saves {_loss(best.saving, study)} a mission on "
        f"average (± {_loss(best.saving_error, study)}), {share}. "
        f"{_choice_now(study)} The trial pays for itself {after}. {_about_vehicle(study)}"
    ).rstrip()


def _file(study: NextTrial) -> str:
    return ", as in next-trial.yaml in this folder" if study.trial is not None else ""


def _about_vehicle(study: NextTrial) -> str:
    """Say which trial settles what to do about the vehicle itself; empty where none does."""
    settling, best = study.settling, study.best
    if settling is None:
        return ""
    done, now = "what to do about the vehicle (swing, calibrate, clean, nothing)", percent(study.right)
    if best is None:
        settles = f"{capitalised(settling.name)}{_file(study)}: {_takes(settling)}, and settles {done}"
        return f"{settles}: it is then right with {percent(settling.right)}, by what is known now with {now}."
    then = f"after it with {percent(best.right)}"
    if settling is not best:
        then += f", after {settling.name}, which {_takes(settling)}, with {percent(settling.right)}"
    return f"{capitalised(done)} is right with {now} by what is known now, {then}."


def _choice_now(study: NextTrial) -> str:
    shortest, longest = ("lightest", "heaviest") if study.decides == "anchor_wet_weight_n" else ("shortest", "longest")
    least, most = study.tried  # one beyond the last of those tried might be better still
    edge = f"the {shortest} tried; " if study.choice <= least else ""
    edge = edge or (f"the {longest} tried; " if study.choice >= most else "")
    brings = f"success {percent(study.success)}, {_loss(study.loss, study)} a mission with its failures"
    return (
        f"With what is known now, {_CHOSEN_NOW[study.decides]} is best at {_value(study, study.choice)} "
        f"({edge}{brings})."
    )


def _takes(design: ValuedDesign) -> str:
    energy = f" and {number(design.energy_wh, 0.02 * design.energy_wh)} W h" if design.energy_wh else ""
    return f"takes {number(design.minutes, 0.02 * design.minutes)} min{energy}"


def _loss(value: float, study: NextTrial) -> str:
    return f"{value:.2g} {study.unit}" if value < 100.0 else f"{value:.0f} {study.unit}"


def _value(study: NextTrial, value: float) -> str:
    return length_in_words(value) if study.decides == "d_max_m" else quantity(value, "N", ".3g")


def _assumptions(study: NextTrial) -> str:
    shares = "; ".join(f"{names(causes)} {part(p)}" for causes, p in study.explanations)
    return (
        f"Assumed: one of these explanations holds ({shares}), with parameters as known now; a mission that fails "
        f"counts as {_loss(study.failure_loss, study)} lost, ten missions that work; only {_CHOSEN[study.decides]} is "
        "chosen anew after the trial; random errors are as large in the trial as in the data so far."
    )


def _outcomes(study: NextTrial) -> Table:
    rows = [
        [
            names(outcome.causes),
            part(outcome.probability),
            _value(study, outcome.choice),
            "nothing" if outcome.choice == study.choice else _loss(max(outcome.saving, 0.0), study),
        ]
        for outcome in study.outcomes
    ]
    columns = ["If it then looks most like", "How likely", f"{_CHOSEN[study.decides]} becomes", "Saves"]
    return Table(columns, rows, "What the outcomes of that trial would mean; those rarer than 2 % are left out.")


def _rule_words(study: NextTrial) -> list[str]:
    rule = study.rule
    if rule is None:
        return [
            "No single parameter decides: give the trial's data to diagnose, and choose with the mission it writes."
        ]
    side, effect, name = "above" if rule.above else "below", names((rule.effect,)), rule.name.replace("_", " ")
    alone = len(CATALOGUE[rule.effect].parameters) == 1
    parameter = f"{effect} ({name})" if alone else f"{name} of {effect}"
    limit = quantity(rule.threshold, rule.unit, ".2g")
    if rule.unit == "rad":
        limit = f"{math.degrees(rule.threshold):.2g}°"
    return [
        f"If the {parameter} comes out {side} {limit}, take it for {names(rule.causes)} and choose "
        f"{_value(study, rule.choice)}; else keep {_value(study, study.choice)}. That rule agrees with the full "
        f"calculation in {part(rule.agreement)} of the simulated outcomes."
    ]


def _designs(study: NextTrial) -> Table:
    first = [design for design in dict.fromkeys((study.best, study.settling)) if design is not None]
    listed = [*first, *(design for design in study.designs if design not in first)][:_LISTED]
    rows = [
        [
            capitalised(design.name),
            f"{design.minutes:.0f}",
            "" if design.energy_wh is None else f"{design.energy_wh:.3g}",
            f"{design.information:.2g}",
            "nothing"
            if design.saving <= 3.0 * design.saving_error
            else f"{design.saving:.2g} ± {design.saving_error:.1g}",
            percent(design.right),
        ]
        for design in listed
    ]
    columns = ["Trial", "Time (min)", "Energy (W h)", "Information (nats)", f"Saves ({study.unit} a mission)"]
    columns.append("Right about the vehicle")
    rest = len(study.designs) - _LISTED
    more = f" {rest} more in next-trials.csv." if rest > 0 else ""
    order = "The recommended one, then those that save or tell most." if first else "Those that tell most first."
    return Table(columns, rows, f"{order} {_NOTHING} {_NO_SHORE}{more}")
