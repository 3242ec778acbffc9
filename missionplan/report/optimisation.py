"""Report of `optimise`: the choice, its check, what binds, the front, or what the obstacle is."""

import math
from collections.abc import Callable, Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

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


def front_figure(found: Optimised) -> Figure | None:
    """Draw P(success) against the cost of all that was tried and reached the mission's end."""
    tried = _reached(found)
    if not tried:
        return None
    figure = MatplotlibFigure(figsize=(6.0, 3.4))
    draw_front(figure.subplots(), found)
    figure.legend(loc="outside upper center", ncols=3)
    return to_figure(
        figure,
        "optimise",
        f"Probability of success against mean {found.aim} of the choices tried",
        f"All choices tried, with {min(each.trials for each in tried)} trials or more.",
    )


def draw_front(axes: Axes, found: Optimised) -> None:
    """Draw P(success) against the cost of all that was tried and reached the mission's end."""
    tried = _reached(found)
    if not tried:
        return
    typical = float(np.median([found.cost_of(each) for each in tried]))
    unit = unit_for("total", found.key, found.provenance.data, typical=typical)
    chosen = [each for each in tried if each.values == found.chosen and found.feasible]
    for label, marker, size, colour, members in (
        ("misses a requirement", "o", 4, GREY, [each for each in tried if not each.feasible]),
        ("meets all requirements", "o", 4, BLUE, [each for each in tried if each.feasible]),
        ("chosen", "*", 14, ORANGE, chosen),
    ):
        if members:
            x = [unit(found.cost_of(each)) for each in members]
            y = [100.0 * each.success.value for each in members]
            axes.plot(x, y, marker, color=colour, markersize=size, alpha=0.6 if marker == "o" else 1.0, label=label)
    low = min(90.0, 100.0 * min(each.success.value for each in tried))
    axes.set(xlabel=f"Mean {found.aim}{unit.axis}", ylabel="P(success) (%)")
    axes.set_ylim(low - 0.05 * (100.0 - low), 100.0 + 0.05 * (100.0 - low))


def _reached(found: Optimised) -> list[Tried]:
    """Choices tried of which some trial reached the mission's end."""
    return [each for each in found.tried if np.isfinite(found.cost_of(each))]


_MOST_ROWS = 25
_SAILED = "Each trial sails in one member of the ensemble; a row has the trials that sail in it."


def page(found: Optimised) -> Page:
    """Build the page."""
    made = found.provenance
    again = {"choose": made.options.get("choose"), "aim": found.aim, "trials": made.trials, "seed": made.seed}
    return Page(
        title=f"What to choose? {found.provenance.mission}",
        answer=answer(found),
        draw=lambda: front_figure(found),
        numbers=_numbers(found),
        write=lambda: [
            _choice(found),
            *_checks(found),
            *members_section(found.members, "mission", "success (95 % interval)", _SAILED),
            *_relaxed(found),
            *_obstacles(found),
            *_front(found),
            _effort(found),
        ],
        verdict="bad" if _fails(found) else "undecided" if outcome_hangs_on_doubt(found.fresh) else "good",
        rerun=typed("optimise", "mission.yaml", **again),
        table=lambda: (
            ("", "chosen" if found.feasible else "nearest"),
            [(_name(name), _shown(found, name, value)) for name, value in found.chosen.items()],
        ),
        plots={"front": draw_front},
    )


def _fails(found: Optimised) -> bool:
    """Whether nothing is to be chosen: no choice meets all requirements, or what does fails more often than not."""
    return not found.feasible or (found.fresh is not None and found.fresh.total.events["success"].high < 0.5)


def answer(found: Optimised) -> str:
    """Write the choice, what it costs and how it was checked, or which requirement is the obstacle and by how much."""
    values = listed([f"{_name(name)} {_shown(found, name, value)}" for name, value in found.chosen.items()])
    if not found.feasible:
        return f"No choice tried meets all requirements. {_obstacle_words(found)} What comes nearest: {values}."
    least, cost = "energy" if found.aim == "energy" else "time", "–"
    if found.checked is not None:
        statistic = found.checked.total.quantities[found.key]
        cost = with_error(statistic.mean, statistic.standard_error, _unit(found))
    sentences = [f"The least {least}, {cost}, is had with {values}."]
    first = next((each.first for each in found.assumed if each.turns), "")
    if not first and found.fresh is not None and outcome_hangs_on_doubt(found.fresh):
        first = what_would_tell(found.fresh.explanations)
    if _fails(found):
        sentences.insert(0, "Nothing to choose: the mission fails more often than not. Of what meets its requirements:")
    elif first:
        sentences.insert(0, f"Nothing to choose yet: first {first}. As the mission stands:")
    if found.checked is not None and found.fresh is not None:
        trials, fresh = number(found.fresh.provenance.trials), percent(found.fresh.total.events["success"])
        sentences.append(f"All requirements are met, on {trials} fresh trials too, of which {fresh} succeed.")
    sailed = members_in_words(found.members, "succeeds")
    if found.fresh is not None:
        sentences.append(explanation_in_words(found.fresh))
    return " ".join(filter(None, [*sentences, sailed, _binding_words(found)]))


def _obstacle_words(found: Optimised) -> str:
    if not found.obstacles:
        return "Some meet them in the trials of the search, but none in both checks; more trials may tell."
    alone, parts = all(each.alone for each in found.obstacles), []
    others = " where all others are" if alone and len(mappings(found.provenance.data.get("requirements"))) > 1 else ""
    for each in found.obstacles:
        met = f"the {in_words(each.quantity)}, which is met with {percent(each.reached)}{others}"
        would = f" ({_looser(found, each)} instead of {_bound(found, each, each.limit)} would do)"
        would = would if math.isfinite(each.would_do) else ""
        parts.append(f"{met}, {100.0 * each.required:g}\u00a0% required{would}")
    if alone:
        return f"The obstacle is {'; or '.join(parts)}."
    return f"Dropping one requirement alone would not do. The choice that comes nearest misses {'; and '.join(parts)}."


def _looser(found: Optimised, each: Obstacle) -> str:
    """Write the bound that would do, rounded away from the one that does not: one rounded towards it may not do."""
    return _bound(found, each, each.would_do, rounded_up if each.would_do > each.limit else rounded_down)


def _bound(found: Optimised, each: Obstacle, value: float, rounded: Callable[[float], float] = float) -> str:
    phase, _, key = each.column.rpartition(".")
    unit = unit_for(phase, key, found.provenance.data, typical=value)
    shown = rounded(unit(value))
    return f"{number(shown)}{unit.suffix}" if math.isfinite(shown) else "–"


def _binding_words(found: Optimised) -> str:
    buying = sorted((each for each in found.relaxations if each.saved > 0.0), key=lambda each: -each.saved)
    if not buying and found.ruled_out is not None:
        quantity, gain = found.ruled_out.quantity, found.ruled_out.saves
        shown = _unit(found)
        about = f"{number(shown(gain), shown(0.1 * gain))}{shown.suffix}"
        words = f"without that on the {in_words(quantity)}, at least about {about} less would do"
        return f"Relaxing any requirement by 1 % saves nothing at these steps; {words}."
    if not buying:
        return "No requirement binds: relaxing any by 1 % saves nothing."
    first = buying[0]
    saved = with_error(first.saved, first.error, _unit(found))
    return f"The {in_words(first.quantity)} binds: with {first.change}, {saved} less would do."


def _name(name: str) -> str:
    return keys_in_words(name.split("+"))


def _shown(found: Optimised, name: str, value: str) -> str:
    """Write a value as people read it, a start by its time of day; `value` is as a script reads it."""
    for axis in found.axes:
        if axis.name == name:
            return next((value_on(axis, i) for i in range(len(axis.values)) if axis.exact(i) == value), value)
    return value


def _unit(found: Optimised) -> Unit:
    typical = found.checked.total.quantities[found.key].mean if found.checked else float("nan")
    return unit_for("total", found.key, found.provenance.data, typical=typical)


def _numbers(found: Optimised) -> list[tuple[str, str]]:
    numbers = [
        ("Combinations to choose from", number(found.combinations)),
        ("Trials of the search", number(found.search_trials)),
    ]
    if found.fresh is not None:
        numbers.insert(0, ("P(success), fresh trials", percent(found.fresh.total.events["success"])))
    return numbers


def _choice(found: Optimised) -> PageSection:
    rows = []
    for axis in found.axes:
        # at a bound, that and not a requirement may decide
        at_bound = axis.numbers is not None and found.chosen[axis.name] in (axis.exact(0), axis.exact(-1))
        where = "at its bound" if at_bound and len(axis.values) > 1 else ""
        chosen, tried = _shown(found, axis.name, found.chosen[axis.name]), range_on(axis, 0, len(axis.values) - 1)
        rows.append((_name(axis.name), chosen, tried, where))
    heading = "The choice" if found.feasible else "The choice that comes nearest"
    return PageSection(heading, [Table(("", "chosen", "tried", ""), rows, text_columns=4)])


def _checks(found: Optimised) -> Iterator[PageSection]:
    if found.checked is None or found.fresh is None:
        return
    rows = [
        (
            *(requirement_in_words(found.checked, item), _required(item.required)),
            *(percent(item.probability), percent(fresh.probability)),
        )
        for item, fresh in zip(found.checked.requirements, found.fresh.requirements, strict=True)
    ]
    caption = f"Each with {number(found.provenance.trials)} trials; mission-optimised.yaml has the seed of the first."
    columns = ("requirement", "required", "reached", "reached on fresh random numbers")
    yield PageSection("It meets all requirements on fresh random numbers too", [Table(columns, rows, caption)])


def _required(probability: float) -> str:
    return f"{100.0 * probability:g}\u00a0%"


def _relaxed(found: Optimised) -> Iterator[PageSection]:
    """Tabulate what relaxing a requirement would save; the headline says where none would."""
    binding = [each for each in found.relaxations if each.saved > 0.0]
    if not binding:
        return
    rows = [
        (
            in_words(each.quantity),
            each.change,
            with_error(each.saved, each.error, _unit(found)) if each.saved else "nothing",
            ", ".join(_shown(found, *item) for item in each.values.items()) if each.saved else "",
        )
        for each in found.relaxations
    ]
    columns = ("requirement", "relaxed", "saves", "with the choice")
    caption = "Found from what was tried, and a few choices more, on the same random numbers, not by a new wide search."
    heading = f"{len(binding)} requirement{'' if len(binding) == 1 else 's'} bind{'s' if len(binding) == 1 else ''}"
    yield PageSection(heading, [Table(columns, rows, caption, text_columns=2)])


def _obstacles(found: Optimised) -> Iterator[PageSection]:
    if found.obstacles:
        rows = [
            (
                *(in_words(each.quantity), _required(each.required), percent(each.reached)),
                *(_bound(found, each, each.limit), _looser(found, each)),
            )
            for each in found.obstacles
        ]
        columns = ("requirement", "required", "reached", "bound", "bound that would do")
        caption = (
            "Of the choice that comes nearest to each requirement among those that meet all others."
            if all(each.alone for each in found.obstacles)
            else "Of the choice that comes nearest to meeting all requirements."
        )
        yield PageSection("What stands in the way", [Table(columns, rows, caption)])


def _front(found: Optimised) -> Iterator[PageSection]:
    front = sorted((each for each in found.tried if each.on_front), key=lambda each: each.energy)
    if not front:
        return
    rows, data = [], found.provenance.data
    for each in front[:_MOST_ROWS]:
        values = [_shown(found, axis.name, each.values[axis.name]) for axis in found.axes]
        costs = (("energy_wh", each.energy), ("duration_s", each.duration))
        units = [unit_for("total", key, data, typical=value) for key, value in costs]
        told = [f"{number(unit(value))}{unit.suffix}" for unit, (_, value) in zip(units, costs, strict=True)]
        rows.append([*values, share(each.success), *told, "met" if each.feasible else "not met"])
    columns = [*(_name(axis.name) for axis in found.axes), "P(success)", "energy", "duration", "requirements"]
    more = f"The first {_MOST_ROWS} of {len(front)}; all are in front.csv." if len(front) > _MOST_ROWS else ""
    yield PageSection(f"On the front of what was tried: {len(front)}", [Table(columns, rows, more)])


def _effort(found: Optimised) -> PageSection:
    text = (
        f"{number(found.search_trials)} trials searched the {number(found.combinations)} combinations, "
        f"{number(found.check_trials)} more checked the choice, and {number(found.relaxation_trials)} were run with "
        "relaxed requirements. "
        "All choices have the same random numbers. Smooth surfaces (kriging) through the cost and the requirements of "
        "what was tried say what to try next, with few trials and then with more; the best of a large lattice is not "
        "guaranteed to be found."
    )
    return PageSection("How it was found", [text, Listing("missionplan simulate mission-optimised.yaml")])
