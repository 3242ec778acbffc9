"""Report of `optimise`: the choice, its check, what binds, the front, or what the obstacle is."""

import math
from collections.abc import Callable, Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.errors import counted
from missionplan.report.explained import (
    explanation_in_words,
    members_in_words,
    members_section,
    outcome_hangs_on_doubt,
    what_would_tell,
)
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, Listing, Page, PageSection, Table, to_figure, typed
from missionplan.report.quantities import Unit, range_on, unit_for, value_on, with_error
from missionplan.report.simulation.quantities import requirement_in_words
from missionplan.report.wording import in_words, keys_in_words, listed, number, percent, rounded_down, rounded_up, share
from missionplan.results.entries import mappings
from missionplan.results.optimisation import Obstacle, Optimised, Tried


def front_figure(result: Optimised) -> Figure | None:
    """Draw P(success) against the cost of all that was tried and reached the mission's end."""
    tried = _reached(result)
    if not tried:
        return None
    figure = MatplotlibFigure(figsize=(6.0, 3.4))
    draw_front(figure.subplots(), result)
    figure.legend(loc="outside upper center", ncols=3)
    return to_figure(
        figure,
        "optimise",
        f"Probability of success against mean {result.aim} of the choices tried",
        f"All choices tried, with {counted(min(choice.trials for choice in tried), 'trial')} or more.",
    )


def draw_front(axes: Axes, result: Optimised) -> None:
    """Draw P(success) against the cost of all that was tried and reached the mission's end."""
    tried = _reached(result)
    if not tried:
        return
    typical = float(np.median([result.cost_of(choice) for choice in tried]))
    unit = unit_for("total", result.key, result.provenance.data, typical=typical)
    chosen = [choice for choice in tried if choice.values == result.chosen and result.feasible]
    for label, marker, size, colour, members in (
        ("misses a requirement", "o", 4, GREY, [choice for choice in tried if not choice.feasible]),
        ("meets all requirements", "o", 4, BLUE, [choice for choice in tried if choice.feasible]),
        ("chosen", "*", 14, ORANGE, chosen),
    ):
        if members:
            x = [unit(result.cost_of(choice)) for choice in members]
            y = [100.0 * choice.success.value for choice in members]
            axes.plot(x, y, marker, color=colour, markersize=size, alpha=0.6 if marker == "o" else 1.0, label=label)
    low = min(90.0, 100.0 * min(choice.success.value for choice in tried))
    axes.set(xlabel=f"Mean {result.aim}{unit.axis}", ylabel="P(success) (%)")
    axes.set_ylim(low - 0.05 * (100.0 - low), 100.0 + 0.05 * (100.0 - low))


def _reached(result: Optimised) -> list[Tried]:
    """Choices tried of which some trial reached the mission's end."""
    return [choice for choice in result.tried if np.isfinite(result.cost_of(choice))]


_MOST_ROWS = 25
_SAILED = "Each trial sails in one member of the ensemble; a row has the trials that sail in it."


def page(result: Optimised) -> Page:
    """Build the page."""
    made = result.provenance
    again = {"choose": made.options.get("choose"), "aim": result.aim, "trials": made.trials, "seed": made.seed}
    return Page(
        title=f"What to choose? {result.provenance.mission}",
        answer=answer(result),
        draw=lambda: front_figure(result),
        numbers=_numbers(result),
        write=lambda: [
            _choice(result),
            *_checks(result),
            *members_section(result.members, "mission", "success (95 % interval)", _SAILED),
            *_relaxed(result),
            *_obstacles(result),
            *_front(result),
            _effort(result),
        ],
        verdict="bad" if _fails(result) else "undecided" if outcome_hangs_on_doubt(result.fresh) else "good",
        rerun=typed("optimise", "mission.yaml", **again),
        table=lambda: (
            ("", "chosen" if result.feasible else "nearest"),
            [(_name(name), _shown(result, name, value)) for name, value in result.chosen.items()],
        ),
        plots={"front": draw_front},
    )


def _fails(result: Optimised) -> bool:
    """Whether nothing is to be chosen: no choice meets all requirements, or what does fails more often than not."""
    return not result.feasible or (result.fresh is not None and result.fresh.total.events["success"].high < 0.5)


def answer(result: Optimised) -> str:
    """Write the choice, what it costs and how it was checked, or which requirement is the obstacle and by how much."""
    values = listed([f"{_name(name)} {_shown(result, name, value)}" for name, value in result.chosen.items()])
    if not result.feasible:
        return f"No choice tried meets all requirements. {_obstacle_words(result)} What comes nearest: {values}."
    least, cost = "energy" if result.aim == "energy" else "time", "–"
    if result.checked is not None:
        statistic = result.checked.total.quantities[result.key]
        cost = with_error(statistic.mean, statistic.standard_error, _unit(result))
    sentences = [f"The least {least}, {cost}, is had with {values}."]
    first = next((assumption.first for assumption in result.assumed if assumption.turns), "")
    if not first and result.fresh is not None and outcome_hangs_on_doubt(result.fresh):
        first = what_would_tell(result.fresh.explanations)
    if _fails(result):
        sentences.insert(0, "Nothing to choose: the mission fails more often than not. Of what meets its requirements:")
    elif first:
        sentences[0] = f"Nothing to choose yet: first {first}. As the mission stands, t{sentences[0][1:]}"
    if result.checked is not None and result.fresh is not None:
        count, fresh = result.fresh.provenance.trials, percent(result.fresh.total.events["success"])
        sentences.append(f"All requirements are met, on {counted(count, 'fresh trial')} too, of which {fresh} succeed.")
    sailed = members_in_words(result.members, "succeeds")
    if result.fresh is not None:
        sentences.append(explanation_in_words(result.fresh))
    return " ".join(filter(None, [*sentences, sailed, _binding_words(result)]))


def _obstacle_words(result: Optimised) -> str:
    if not result.obstacles:
        return "Some meet them in the trials of the search, but none in both checks; more trials may tell."
    alone, parts = all(snag.alone for snag in result.obstacles), []
    others = " where all others are" if alone and len(mappings(result.provenance.data.get("requirements"))) > 1 else ""
    for snag in result.obstacles:
        met = f"the {in_words(snag.quantity)}, which is met with {percent(snag.reached)}{others}"
        would = f" ({_looser(result, snag)} instead of {_bound(result, snag, snag.limit)} would do)"
        would = would if math.isfinite(snag.would_do) else ""
        parts.append(f"{met}, {100.0 * snag.required:g}\u00a0% required{would}")
    if alone:
        return f"The obstacle is {'; or '.join(parts)}."
    return f"Dropping one requirement alone would not do. The choice that comes nearest misses {'; and '.join(parts)}."


def _looser(result: Optimised, snag: Obstacle) -> str:
    """Write the bound that would do, rounded away from the one that does not: one rounded towards it may not do."""
    return _bound(result, snag, snag.would_do, rounded_up if snag.would_do > snag.limit else rounded_down)


def _bound(result: Optimised, snag: Obstacle, value: float, rounded: Callable[[float], float] = float) -> str:
    phase, _, key = snag.column.rpartition(".")
    unit = unit_for(phase, key, result.provenance.data, typical=value)
    shown = rounded(unit(value))
    return f"{number(shown)}{unit.suffix}" if math.isfinite(shown) else "–"


def _binding_words(result: Optimised) -> str:
    buying = sorted(
        (relaxation for relaxation in result.relaxations if relaxation.saved > 0.0),
        key=lambda relaxation: -relaxation.saved,
    )
    if not buying and result.ruled_out is not None:
        quantity, gain = result.ruled_out.quantity, result.ruled_out.saves
        shown = _unit(result)
        about = f"{number(shown(gain), shown(0.1 * gain))}{shown.suffix}"
        words = f"without that on the {in_words(quantity)}, at least about {about} less would do"
        return f"Relaxing any requirement by 1 % saves nothing at these steps; {words}."
    if not buying:
        return "No requirement binds: relaxing any by 1 % saves nothing."
    first = buying[0]
    saved = with_error(first.saved, first.error, _unit(result))
    return f"The {in_words(first.quantity)} binds: with {first.change}, {saved} less would do."


def _name(name: str) -> str:
    return keys_in_words(name.split("+"))


def _shown(result: Optimised, name: str, value: str) -> str:
    """Write a value as people read it, a start by its time of day; `value` is as a script reads it."""
    for axis in result.axes:
        if axis.name == name:
            return next((value_on(axis, i) for i in range(len(axis.values)) if axis.exact(i) == value), value)
    return value


def _unit(result: Optimised) -> Unit:
    typical = result.checked.total.quantities[result.key].mean if result.checked else float("nan")
    return unit_for("total", result.key, result.provenance.data, typical=typical)


def _numbers(result: Optimised) -> list[tuple[str, str]]:
    numbers = [
        ("Combinations to choose from", number(result.combinations)),
        ("Trials of the search", number(result.search_trials)),
    ]
    if result.fresh is not None:
        numbers.insert(0, ("P(success), fresh trials", percent(result.fresh.total.events["success"])))
    return numbers


def _choice(result: Optimised) -> PageSection:
    rows = []
    for axis in result.axes:
        # at a bound, that and not a requirement may decide
        at_bound = axis.numbers is not None and result.chosen[axis.name] in (axis.exact(0), axis.exact(-1))
        where = "at its bound" if at_bound and len(axis.values) > 1 else ""
        chosen, tried = _shown(result, axis.name, result.chosen[axis.name]), range_on(axis, 0, len(axis.values) - 1)
        rows.append((_name(axis.name), chosen, tried, where))
    heading = "The choice" if result.feasible else "The choice that comes nearest"
    return PageSection(heading, [Table(("", "chosen", "tried", ""), rows, text_columns=4)])


def _checks(result: Optimised) -> Iterator[PageSection]:
    if result.checked is None or result.fresh is None:
        return
    rows = [
        (
            *(requirement_in_words(result.checked, item), _required(item.required)),
            *(percent(item.probability), percent(fresh.probability)),
        )
        for item, fresh in zip(result.checked.requirements, result.fresh.requirements, strict=True)
    ]
    each = counted(result.provenance.trials, "trial")
    caption = f"Each with {each}; mission-optimised.yaml has the seed of the first."
    columns = ("requirement", "required", "reached", "reached on fresh random numbers")
    yield PageSection("It meets all requirements on fresh random numbers too", [Table(columns, rows, caption)])


def _required(probability: float) -> str:
    return f"{100.0 * probability:g}\u00a0%"


def _relaxed(result: Optimised) -> Iterator[PageSection]:
    """Tabulate what relaxing a requirement would save; the headline says where none would."""
    binding = [relaxation for relaxation in result.relaxations if relaxation.saved > 0.0]
    if not binding:
        return
    rows = [
        (
            in_words(relaxation.quantity),
            relaxation.change,
            with_error(relaxation.saved, relaxation.error, _unit(result)) if relaxation.saved else "nothing",
            ", ".join(_shown(result, *item) for item in relaxation.values.items()) if relaxation.saved else "",
        )
        for relaxation in result.relaxations
    ]
    columns = ("requirement", "relaxed", "saves", "with the choice")
    caption = "Found from what was tried, and a few choices more, on the same random numbers, not by a new wide search."
    heading = f"{len(binding)} requirement{'' if len(binding) == 1 else 's'} bind{'s' if len(binding) == 1 else ''}"
    yield PageSection(heading, [Table(columns, rows, caption, text_columns=2)])


def _obstacles(result: Optimised) -> Iterator[PageSection]:
    if result.obstacles:
        rows = [
            (
                *(in_words(snag.quantity), _required(snag.required), percent(snag.reached)),
                *(_bound(result, snag, snag.limit), _looser(result, snag)),
            )
            for snag in result.obstacles
        ]
        columns = ("requirement", "required", "reached", "bound", "bound that would do")
        caption = (
            "Of the choice that comes nearest to each requirement among those that meet all others."
            if all(snag.alone for snag in result.obstacles)
            else "Of the choice that comes nearest to meeting all requirements."
        )
        yield PageSection("What stands in the way", [Table(columns, rows, caption)])


def _front(result: Optimised) -> Iterator[PageSection]:
    front = sorted((choice for choice in result.tried if choice.on_front), key=lambda choice: choice.energy)
    if not front:
        return
    rows, data = [], result.provenance.data
    for choice in front[:_MOST_ROWS]:
        values = [_shown(result, axis.name, choice.values[axis.name]) for axis in result.axes]
        costs = (("energy_wh", choice.energy), ("duration_s", choice.duration))
        units = [unit_for("total", key, data, typical=value) for key, value in costs]
        amounts = [f"{number(unit(value))}{unit.suffix}" for unit, (_, value) in zip(units, costs, strict=True)]
        rows.append([*values, share(choice.success), *amounts, "met" if choice.feasible else "not met"])
    columns = [*(_name(axis.name) for axis in result.axes), "P(success)", "energy", "duration", "requirements"]
    more = f"The first {_MOST_ROWS} of {len(front)}; all are in front.csv." if len(front) > _MOST_ROWS else ""
    yield PageSection(f"On the front of what was tried: {len(front)}", [Table(columns, rows, more)])


def _effort(result: Optimised) -> PageSection:
    text = (
        f"{counted(result.search_trials, 'trial')} searched the {counted(result.combinations, 'combination')}, "
        f"{number(result.check_trials)} more checked the choice, and {number(result.relaxation_trials)} were run with "
        "relaxed requirements. "
        "All choices have the same random numbers. Smooth surfaces (kriging) through the cost and the requirements of "
        "what was tried say what to try next, with few trials and then with more; the best of a large lattice is not "
        "guaranteed to be found."
    )
    return PageSection("How it was found", [text, Listing("missionplan simulate mission-optimised.yaml")])
