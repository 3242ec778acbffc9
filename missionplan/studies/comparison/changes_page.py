"""Numbers of two runs in words: their names, units and changes."""

from collections.abc import Iterator, Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.mission.checks.sections import QUANTITIES
from missionplan.report.page import BLUE, INK, ORANGE, Cells, Figure, Page, PageSection, Table, to_figure, typed
from missionplan.report.quantities import PERCENT, Unit, as_written, reader_system, reader_unit, unit_for, with_error
from missionplan.report.wording import has_spread, in_words, number, of_phase, split_key
from missionplan.results.entries import mapping
from missionplan.studies.comparison.choices_page import limit_in_words, requirements_of, task_in_words
from missionplan.studies.comparison.differing_values import phase_names
from missionplan.studies.comparison.result import ChangedValue, ComparedNumber, Comparison, ListItem

_GROUPS = {"sweep": "", "anchor": "", "odds": "dives"}
"""How sections of `summary.json` are named, where not by their keys."""

_OF_SWEEP = {
    ("curve", "cost"): "mean cost",
    ("best", "cost"): "least mean cost",
    ("best", "d_max_m"): "d_max of least cost",
    ("recommended", "cost"): "mean cost at the recommended d_max",
    ("recommended", "d_max_m"): "recommended d_max",
    ("recommended", "saving_s"): "time saved against one leg at the recommended d_max",
    ("recommended", "required_arrival"): "required probability of arrival",
    ("one_leg", "cost"): "mean cost in one leg",
    ("one_leg", "d_max_m"): "length of one leg",
    ("", "saving_s"): "time saved against one leg",
}
"""Numbers of a sweep, by where they are in `summary.json`."""


def importance(difference: ComparedNumber) -> float:
    """Size of the change against its noise, or, without noise, against the number."""
    size = max(abs(difference.first or 0.0), abs(difference.second or 0.0), 1e-300)
    return abs(difference.change or 0.0) / (noise_of(difference) or size)


def noise_of(difference: ComparedNumber) -> float:
    """Standard error of the change; zero where it is only rounding."""
    error = difference.standard_error or 0.0
    size = max(abs(difference.first or 0.0), abs(difference.second or 0.0))
    return error if has_spread(size, error) else 0.0


def name_of(comparison: Comparison, difference: ComparedNumber) -> str:
    """Name a number."""
    if difference.requirement:
        what = "requirement: reached" if difference.place[-1] == "reached" else "requirement"
        return f"{_requirement(comparison, difference, difference.requirement)} ({what})"
    if difference.of_sweep:
        # name a number of a sweep over maximum leg lengths
        sigma, *inside = difference.of_sweep
        which = str(inside[0]) if inside else ""
        words = _OF_SWEEP.get((which, difference.key), "") or in_words(difference.key)
        if which == "curve":
            words += f" at d_max = {as_written(str(inside[1]), 'm')}"
        spreads = {other.of_sweep[0] for other in comparison.differences if other.of_sweep}
        return f"{words} (σ_v = {as_written(str(sigma), 'm/s')})" if len(spreads) > 1 else words
    group = _GROUPS.get(difference.group, difference.group)
    if difference.place[0] == "phases":
        return of_phase(split_key(difference.key)[0], group)
    return in_words(f"{group}.{difference.key}".lstrip(".")) if group != difference.key else in_words(difference.key)


def _requirement(comparison: Comparison, difference: ComparedNumber, item: ListItem) -> str:
    """Write a requirement with its limit as the mission does, or in SI where that is not certain."""
    mission = _mission(comparison, difference)
    alike = [entry for entry in requirements_of(mission) if entry.get("quantity") == item.name]
    limit = ""
    if item.number is not None and item.bound:
        limit = limit_in_words(alike[0]) if len(alike) == 1 else ""
        unit = _si_unit(item.name)
        in_si = with_error(item.number, 0.0, reader_unit(unit, item.number)) if unit else f"{item.number:.6g}"
        limit = limit or f"{item.bound.replace('_', ' ')} {in_si}"
    phase, _, quantity = item.name.rpartition(".")
    return f"{of_phase(quantity, phase) if phase in phase_names(mission) else in_words(item.name)} {limit}".strip()


def _si_unit(quantity: str) -> str:
    """SI unit of a quantity by its name in a mission: ``moor.offset``; empty where there is none."""
    units = {name: unit for kind in QUANTITIES.values() for name, unit in kind.items()}
    return next((unit for name, unit in units.items() if unit and quantity.endswith(f".{name}")), "")


def _mission(comparison: Comparison, difference: ComparedNumber) -> Mapping[str, object]:
    """Data of the second run's mission; of the first's where only that has the number."""
    return mapping(comparison.provenance.data["second" if difference.second is not None else "first"])


def _unit(comparison: Comparison, difference: ComparedNumber) -> Unit:
    if difference.kind == "probability" or difference.key == "cost":
        return PERCENT
    typical = abs((difference.first if difference.first is not None else difference.second) or 0.0)
    if difference.requirement and (unit := _si_unit(difference.requirement.name)):
        return reader_unit(unit, typical, reader_system() or "metric") if unit != "J" else Unit("W h", 3600.0)
    return unit_for(difference.group, difference.key, _mission(comparison, difference), typical=typical)


def shown_change(comparison: Comparison, difference: ComparedNumber) -> str:
    """Write second minus first, with its standard error."""
    change = difference.change
    if change is None:
        return "–"
    words = with_error(change, noise_of(difference), _unit(comparison, difference))
    return words if words.startswith("−") or change == 0.0 else f"+{words}"


def row_of(comparison: Comparison, difference: ComparedNumber) -> tuple[str, str, str, str, str]:
    """Write a number's name, verdict, both values and change."""
    unit, error = _unit(comparison, difference), noise_of(difference)
    first, second = (
        "–" if value is None else number(unit(value), unit(error)) + unit.suffix
        for value in (difference.first, difference.second)
    )
    return name_of(comparison, difference), difference.verdict, first, second, shown_change(comparison, difference)


_MOST_ROWS = 60
"""Rows of a table."""
_MOST_DOTS = 16
"""Numbers in the figure."""


def page(comparison: Comparison) -> Page:
    """Build the page of a comparison."""
    return Page(
        title=f"Two runs of {comparison.compared}: {comparison.provenance.mission}",
        answer=answer(comparison),
        draw=lambda: changes_figure(comparison),
        numbers=[
            ("Changed in the mission", _count(comparison.mission_changes, "value")),
            ("Changed in the run", _count(comparison.option_changes, "option")),
            ("Changed in the results", _count(comparison.changed, "number")),
        ],
        write=lambda: list(_sections(comparison)),
        rerun=typed("compare", *(run.folder for run in comparison.runs)),
        table=lambda: _cells(comparison),
        plots={"changes": draw_changes},
    )


def _cells(comparison: Comparison) -> Cells:
    """Tabulate for a terminal: what decides, what changed by more than noise, then what differs in the missions."""
    numbers = [*comparison.deciding, *_others_changed(comparison)][:_MOST_ROWS]
    rows = [row_of(comparison, difference) for difference in numbers]
    changes = [*(comparison.mission_changes if comparison.alike else ()), *comparison.option_changes]
    values = [(change.path, change.first or "–", change.second or "–", "") for change in changes]
    return ("what", "first", "second", "change"), [*((row[0], *row[2:]) for row in rows), *values]


def answer(comparison: Comparison) -> str:
    """Write what decides first: success and requirements; then how many numbers changed, and which most clearly."""
    judged = [item for item in comparison.differences if item.verdict in ("changed", "within noise", "same")]
    numbers = "The results are the same."
    if changed := comparison.changed:
        largest = max(changed, key=importance)
        numbers = (
            f"{len(changed)} of {len(judged)} numbers changed by more than Monte-Carlo noise, most clearly the "
            f"{name_of(comparison, largest)} ({shown_change(comparison, largest)})."
        )
    elif unlike := {item.verdict for item in comparison.differences} - {"same", "only first", "only second"}:
        is_judged = "within noise" in unlike
        numbers = f"No number {'changed' if is_judged else 'is known to have changed'} by more than Monte-Carlo noise."
    success = [_success(comparison, difference) for difference in comparison.success]
    requirements = _requirement_changes(comparison.requirement_changes)
    return " ".join(filter(None, [_unlike(comparison), *success, *requirements, numbers]))


def _unlike(comparison: Comparison) -> str:
    """Write in one line that the missions have unlike tasks, or little in common; nothing where they are alike."""
    first, second = (", ".join(names) or "no phases" for names in comparison.phases)
    if first == second and comparison.task_differs:
        return f"The missions have unlike tasks: they differ {task_in_words(comparison.task_differs)}."
    if comparison.alike:
        return ""
    what = f"{_count(comparison.mission_changes, 'value')} of their files differ"
    if first != second:
        what = f"the first has {first}, the second {second}"
    return f"The two missions are not alike: {what}; only what both have is compared."


def _success(comparison: Comparison, success: ComparedNumber) -> str:
    """Write how the probability of success changed."""
    _, verdict, first, second, change = row_of(comparison, success)
    if verdict == "same":
        is_all = {item.verdict for item in comparison.differences} == {"same"}
        return "" if is_all else f"The probability of success is {first} in both."
    if verdict == "within noise":
        return f"The probability of success, {first} and then {second}, differs by no more than noise ({change})."
    return f"The probability of success was {first} and is now {second} ({change})."


def _requirement_changes(changes: Sequence[ChangedValue]) -> Iterator[str]:
    """Write what became of the requirements."""
    for change in changes:
        name = in_words(change.path)
        if not change.first:
            yield f"The new requirement on the {name} is {change.second}."
        elif change.second:
            yield f"The requirement on the {name} was {change.first} and is now {change.second}."
        else:
            yield f"The requirement on the {name}, which was {change.first}, has been dropped."


def _count(items: Sequence[object], noun: str) -> str:
    return f"{len(items) or 'no'} {noun}{'' if len(items) == 1 else 's'}"


def changes_figure(comparison: Comparison) -> Figure | None:
    """Draw the changes in standard errors, the clearest first; None where none is noisy."""
    shown = _noisy(comparison)
    if not shown:
        return None
    figure = MatplotlibFigure(figsize=(5.0, 0.7 + 0.42 * len(shown)))
    draw_changes(figure.add_subplot(), comparison)
    clearest, score = name_of(comparison, shown[0]), (shown[0].change or 0.0) / noise_of(shown[0])
    return to_figure(
        figure,
        "changes",
        f"Changes of {len(shown)} numbers in standard errors; the clearest is that of the {clearest} at {score:.1f}.",
        "Orange: more than noise, all numbers taken together (Holm's correction at 5 %). Band: where 95 % of the "
        "differences of one number lie by noise alone.",
    )


def _noisy(comparison: Comparison) -> list[ComparedNumber]:
    noisy = [item for item in comparison.differences if item.change and noise_of(item)]
    return sorted(noisy, key=importance, reverse=True)[:_MOST_DOTS]


def draw_changes(axes: Axes, comparison: Comparison) -> None:
    """Draw a dot for each of the clearest changes, and the band of noise."""
    shown = _noisy(comparison)
    axes.axvspan(-1.96, 1.96, color=BLUE, alpha=0.15, linewidth=0.0)
    axes.axvline(0.0, color=INK, linewidth=0.8)
    scores = [(item.change or 0.0) / noise_of(item) for item in shown]
    for row, (score, item) in enumerate(zip(scores, shown, strict=True)):
        axes.plot(score, row, "o", color=ORANGE if item.verdict == "changed" else BLUE, markersize=6)
        name, across = name_of(comparison, item), axes.get_yaxis_transform()
        axes.text(0.01, row - 0.22, name, transform=across, va="bottom", fontsize=9)
    reach = 1.1 * max(3.0, *(abs(score) for score in scores))
    axes.set(yticks=[], ylim=(len(shown) - 0.5, -0.8), xlim=(-reach, reach))
    axes.set_xlabel("second − first, in standard errors of the difference")
    axes.grid(visible=False, axis="y")


def _others_changed(comparison: Comparison) -> list[ComparedNumber]:
    """Numbers that changed, besides those that decide, the clearest first."""
    others = [item for item in comparison.changed if item not in comparison.deciding]
    return sorted(others, key=importance, reverse=True)


def _sections(comparison: Comparison) -> Iterator[PageSection]:
    """Yield the sections, what decides first."""
    deciding, changed = comparison.deciding, _others_changed(comparison)
    if deciding:
        yield PageSection("What decides", [_table(comparison, deciding)])
    if changed:
        yield PageSection(f"{_count(changed, 'number')} changed, the clearest first", [_table(comparison, changed)])
    rows = [
        (run.folder, run.created[:16].replace("T", " "), run.version, number(run.trials), f"{run.seed}")
        for run in comparison.runs
    ]
    heading = "The missions of the two runs differ" if comparison.mission_changes else "Both runs are of one mission"
    yield PageSection(heading, [Table(("folder", "made (UTC)", "missionplan", "trials", "seed"), rows, text_columns=3)])
    yield from _inputs_sections(comparison)
    rest = [item for item in comparison.differences if item.verdict != "changed" and item not in deciding]
    rest = [item for item in rest if comparison.alike or item.change is not None]
    if rest:
        yield PageSection("What did not change, or cannot be judged", [_table(comparison, rest)])


def _inputs_sections(comparison: Comparison) -> Iterator[PageSection]:
    """Tabulate the values of the missions and the options of the runs that differ."""
    mission, options = comparison.mission_changes if comparison.alike else (), comparison.option_changes
    for noun, whole, changes in (("value", "mission", mission), ("option", "run", options)):
        if changes:
            heading = f"{_count(changes, noun)} of the {whole} {'differs' if len(changes) == 1 else 'differ'}"
            values = [(change.path, change.first or "–", change.second or "–") for change in changes]
            yield PageSection(heading, [Table(("key", "first", "second"), values, text_columns=3)])


def _table(comparison: Comparison, items: Sequence[ComparedNumber]) -> Table:
    many = f"The first {_MOST_ROWS} of {len(items)}; all are in differences.csv." if len(items) > _MOST_ROWS else ""
    columns = ("number", "verdict", "first", "second", "change ± standard error")
    return Table(columns, [row_of(comparison, item) for item in items[:_MOST_ROWS]], many, text_columns=2)
