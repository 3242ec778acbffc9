"""Requirements, failures and quantities of a simulated mission in words, and which inputs to measure better."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby

from missionplan.montecarlo.statistics import Statistic
from missionplan.report.page import PageSection, Table
from missionplan.report.quantities import PERCENT, Unit, si_per_unit, unit_for, with_error
from missionplan.report.wording import capitalised, in_words, listed, number, percent, phase_in_words
from missionplan.results.failures import Failure
from missionplan.results.simulation import Attrition, Outcome, PhaseOutcome, RequirementOutcome, Sensitivity

_FAILURES: Mapping[str, str] = {
    Failure.NOT_ARRIVED: "missed arrivals",
    Failure.NOT_DOWN: "anchors that do not reach the seafloor",
    Failure.OUTSIDE: "anchors outside the radius",
    Failure.STRUCK: "strikes on the seafloor",
    Failure.DRAGGED: "anchors that drag",
    Failure.GROUNDED: "vehicles that touch the seafloor in the hold",
    Failure.FLOODED_EARLY: "anchors that flood before their release, which sink the vehicle nose first",
    Failure.LINE_PARTED: "lines that part",
    Failure.NOT_SURFACED: "vehicles that do not surface",
    Failure.NOT_HOVERING: "vehicles that do not come to hover",
    Failure.OUT_OF_ENERGY: "empty batteries",
    Failure.LEFT_RECORD: "missions that leave the record of the current",
    Failure.OUTRUN: "currents faster than the vehicle",
    Failure.AGROUND: "vehicles that run aground",
    Failure.ON_LAND: "vehicles that end on land",
    Failure.KEEP_OUT: "vehicles in zones to keep out of",
    Failure.EQUIPMENT: "equipment that fails",
    Failure.UNCHARTED: "missions that leave the grid of depths",
    Failure.TOO_SHALLOW: "lines too long for the depth of the water",
    Failure.TOO_LIGHT: "anchors too light to sink the vehicle",
}


LEAST_SPREAD = 1e-3
"""Standard deviation over mean below which a quantity is one value to anybody who reads it."""


def relative_spread(statistic: Statistic) -> float:
    """Standard deviation of a quantity over its mean."""
    return statistic.sd / max(abs(statistic.mean), 1e-300)


def unit_of(outcome: Outcome, phase: PhaseOutcome, key: str) -> Unit:
    """Find the unit in which to show a quantity of a phase."""
    return unit_for(phase.name, key, outcome.provenance.data, typical=phase.quantities[key].p50)


def worst_step(outcome: Outcome) -> Attrition | None:
    """Find the step at which most trials fail; None where none fails."""
    worst = max(outcome.attrition, key=lambda step: step.lost.value, default=None)
    return None if worst is None or worst.lost.value == 0.0 else worst


def failure_in_words(step: str) -> str:
    """Write a step at which missions fail as a plural: ``missed arrivals (ingress)``."""
    phase, _, what = step.rpartition(": ")
    words = _FAILURES.get(what.partition(", ")[0], f"“{what}”")  # without the state in which equipment leaves it
    return f"{words} ({phase_in_words(phase)})" if phase else words


def requirement_in_words(outcome: Outcome, requirement: RequirementOutcome) -> str:
    """Write a requirement with its limit in the mission's unit: ``offset of the anchor (moor) at most 75 ft``."""
    name = in_words(requirement.quantity)
    if requirement.bound is None or requirement.limit is None:
        return name
    phase, _, quantity = requirement.quantity.partition(".")
    key = next((key for key in _keys(outcome, phase) if key.rpartition(quantity)[1]), quantity)
    unit = unit_for(phase, key, outcome.provenance.data, typical=requirement.limit)
    limit = unit(requirement.limit / si_per_unit(key))
    return f"{name} {requirement.bound_in_words} {number(limit)}{unit.suffix}"


def _keys(outcome: Outcome, phase: str) -> Sequence[str]:
    return next((tuple(item.quantities) for item in (*outcome.phases, outcome.total) if item.name == phase), ())


def requirement_on(outcome: Outcome, phase: PhaseOutcome, key: str) -> RequirementOutcome | None:
    """Find the first requirement that limits a quantity of a phase."""
    for requirement in outcome.requirements:
        name, _, quantity = requirement.quantity.partition(".")
        if name == phase.name and requirement.bound is not None and key.startswith(f"{quantity}_"):
            return requirement
    return None


def requirements_in_words(outcome: Outcome) -> str:
    """Write how many requirements are met, not met and undecided, where there are any."""
    items = outcome.requirements
    if not items:
        return ""
    missed, undecided = len(_missed(items)), _undecided(items)
    met = len(items) - missed - len(undecided)
    if not undecided:
        return f"{_decided_in_words(met, len(items))}."
    if len(items) == 1:
        return f"Whether its requirement is met is undecided; {_remedy(undecided)}."
    if len(undecided) == len(items):
        return f"{'Both' if len(items) == 2 else f'All {len(items)}'} requirements are undecided; {_remedy(undecided)}."
    parts = [
        f"{count} {'is' if count == 1 else 'are'} {word}"
        for count, word in ((met, "met"), (missed, "not met"), (len(undecided), "undecided"))
        if count
    ]
    return f"Of its {len(items)} requirements {listed(parts)}; {_remedy(undecided)}."


def _decided_in_words(met: int, count: int) -> str:
    if met == count:
        all_of_them = "Both" if count == 2 else f"All {count}"
        return "Its requirement is met" if count == 1 else f"{all_of_them} requirements are met"
    if met == 0:
        none_of_them = "Neither of its" if count == 2 else f"None of its {count}"
        return "Its requirement is not met" if count == 1 else f"{none_of_them} requirements is met"
    return f"{met} of its {count} requirements {'is' if met == 1 else 'are'} met"


def _remedy(undecided: Sequence[RequirementOutcome]) -> str:
    """Write how many trials would decide the requirements that are undecided."""
    needed = [item.trials_to_decide for item in undecided]
    counts = [trials for trials in needed if trials is not None]
    if len(counts) < len(needed):
        return "what is reached is what is required, so that no number of trials decides"
    step = 10 ** max(len(str(max(counts))) - 2, 0)  # two digits
    trials = number(float(math.ceil(max(counts) / step) * step))
    return f"about {trials} trials would decide, if the share stays as it is"


def verdict(outcome: Outcome) -> str:
    """Choose how the headline is marked: bad once a requirement is certainly missed, undecided before good.

    Bad, too, is a mission that fails more often than not, or whose anchor cannot be built.
    """
    if not outcome.can_be_built or outcome.total.events["success"].high < 0.5:
        return "bad"
    if not outcome.requirements:
        return ""
    if _missed(outcome.requirements):
        return "bad"
    return "undecided" if _undecided(outcome.requirements) else "good"


def requirements_section(outcome: Outcome) -> Iterator[PageSection]:
    """Tabulate the requirements, where there are any."""
    rows = [
        (
            requirement_in_words(outcome, item),
            percent(item.probability),
            f"{100.0 * item.required:g}\u00a0%",
            judged(item),
        )
        for item in outcome.requirements
    ]
    if rows:
        table = Table(("requirement", "reached", "required", "verdict"), rows)
        yield PageSection(_heading(outcome), [table], is_summary=True)


def judged(requirement: RequirementOutcome) -> str:
    """Write whether a requirement is met, or how many trials would decide."""
    if requirement.undecided:
        return f"undecided: {_remedy([requirement])}"
    return "met" if requirement.met else "not met"


def _heading(outcome: Outcome) -> str:
    groups = {"Not met": _missed(outcome.requirements), "Undecided": _undecided(outcome.requirements)}
    parts = [
        f"{word}: {'; '.join(requirement_in_words(outcome, item) for item in items)}"
        for word, items in groups.items()
        if items
    ]
    return ". ".join(parts) if parts else _tightest(outcome)


def _tightest(outcome: Outcome) -> str:
    """Name the requirement, of several that are met, that is nearest to being missed, and what is reached of it."""
    if len(outcome.requirements) < 2:
        return "Every requirement is met"
    tight = min(outcome.requirements, key=lambda item: item.slack)
    words = f"Every requirement is met; the tightest is {requirement_in_words(outcome, tight)}"
    if tight.limit is None or tight.reached is None:
        return f"{words}, reached in {percent(tight.probability)}"
    reached = requirement_in_words(outcome, replace(tight, limit=tight.reached)).rpartition(tight.bound_in_words)[2]
    return f"{words}: {100.0 * tight.required:g} of 100 missions reach {tight.bound_in_words} {reached.strip()}"


def _missed(items: Sequence[RequirementOutcome]) -> list[RequirementOutcome]:
    return [item for item in items if not item.met and not item.undecided]


def _undecided(items: Sequence[RequirementOutcome]) -> list[RequirementOutcome]:
    return [item for item in items if item.undecided]


_MOST_INPUTS, _MOST_FIGURES = 5, 4
_LEAST_SHOWN = 0.01
_STEADY = 0.01
"""Standard deviation over mean to which a quantity must vary to be worth a heading."""


InputsOf = tuple[str, Sequence[Sensitivity]]
"""A key figure and the inputs that matter for it, the most important first."""


def sensitivity_sections(outcome: Outcome) -> Iterator[PageSection]:
    """Tabulate the inputs with a detectable influence, where there are any."""
    influential = list(_influential(outcome))
    if not influential:
        return
    required = tuple(item.quantity for item in outcome.requirements)

    def rank(group: InputsOf) -> tuple[bool, bool]:
        return not group[0].startswith(required), not group[0].startswith("total")

    drawn = [
        (output, [influence for influence in influences if influence.first_order > _LEAST_SHOWN] or influences[:1])
        for output, influences in sorted(influential, key=rank)[:_MOST_FIGURES]
    ]
    rows = [
        (
            in_words(output),
            in_words(influence.source),
            with_error(influence.first_order, influence.standard_error, PERCENT),
            _direction(influence),
        )
        for output, influences in drawn
        for influence in influences
    ]
    columns = ("of the", "input", "share of the variance", "a larger input makes it")
    # name the input that accounts for most of a figure, of those that vary enough to be worth a thought
    varying = [group for group in drawn if _spread(outcome, group[0]) > _STEADY] or drawn
    output, (first, *_) = max(varying, key=lambda group: group[1][0].first_order)
    part = 100.0 * min(first.first_order, 1.0)
    share = f"{number(part, 0.1 * part)}\u00a0%"
    source = capitalised(in_words(first.source))
    yield PageSection(
        f"{source} matters most: it accounts for {share} of the variance of the {in_words(output)}",
        [
            "What to measure better: the share of a key figure's variance that would go if an input were known. "
            "summary.json has those of every quantity.",
            Table(columns, rows, "First-order Sobol indices and their standard errors.", text_columns=2),
        ],
    )


def _influential(outcome: Outcome) -> Iterator[InputsOf]:
    """Yield, for each key figure that varies, the inputs whose index exceeds two standard errors.

    What a mission of one phase has as its total too is told once.
    """
    totals = {
        influence.output.partition(".")[2]
        for influence in outcome.sensitivities
        if influence.output.startswith("total.")
    }
    alone = outcome.phases[0].name if len(outcome.phases) == 1 else None
    for output, influences in groupby(outcome.sensitivities, key=lambda influence: influence.output):
        phase, _, key = output.partition(".")
        clear = [influence for influence in influences if influence.first_order > 2.0 * influence.standard_error]
        if clear and (phase != alone or key not in totals) and _spread(outcome, output) > LEAST_SPREAD:
            yield output, clear[:_MOST_INPUTS]


def _spread(outcome: Outcome, output: str) -> float:
    """Standard deviation of a quantity over its mean; infinite where that is not known."""
    parts = {phase.name: phase for phase in (*outcome.phases, outcome.total)}
    name, _, key = output.partition(".")
    statistic = parts[name].quantities.get(key) if name in parts else None
    return relative_spread(statistic) if statistic is not None else math.inf


def _direction(influence: Sensitivity) -> str:
    """Whether a larger input makes the figure larger, by the sign of the rank correlation, if that tells most of it."""
    if influence.source.endswith((".member", ".one-of", "posterior")):  # these have numbers, and no order
        return ""
    if influence.rank_correlation**2 < 0.5 * influence.first_order:  # such as an error, of which either sign does harm
        return "larger or smaller"
    return "larger" if influence.rank_correlation >= 0.0 else "smaller"
