"""Report of `compare`: two runs side by side."""

import shlex
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.compared.run_numbers import importance, name_of, noise_of, row_of, shown_change
from missionplan.report.compared.tasks import task_in_words
from missionplan.report.numbers import number
from missionplan.report.page import BLUE, INK, ORANGE, Drawing, Figure, Page, PageSection, Table, Terminal, to_figure
from missionplan.report.wording import in_words
from missionplan.results.comparison import ChangedValue, ComparedNumber, Comparison

_MOST_ROWS = 60
"""Rows of a table."""
_MOST_DOTS = 16
"""Numbers in the figure."""


def page(comparison: Comparison) -> Page:
    """Build the page of a comparison."""
    folders = [shlex.quote(run.folder) for run in comparison.runs]
    return Page(
        title=f"Two runs of {comparison.compared}: {comparison.provenance.mission}",
        answer=answer(comparison),
        figure=changes_figure(comparison),
        numbers=_numbers(comparison),
        sections=[section for part in _PARTS for section in part(comparison)],
        rerun=f"missionplan compare {' '.join(folders)}",
    )


def terminal(comparison: Comparison) -> Terminal:
    """Build the terminal's view: what decides, what changed by more than noise, then what differs in the missions."""
    numbers = [*comparison.deciding, *_others_changed(comparison)][:_MOST_ROWS]
    rows = [row_of(comparison, difference) for difference in numbers]
    changes = [*(comparison.mission_changes if comparison.alike else ()), *comparison.option_changes]
    values = [(change.path, change.first or "–", change.second or "–", "") for change in changes]
    columns = ("what", "first", "second", "change")
    return Terminal(answer(comparison), columns, [*((row[0], *row[2:]) for row in rows), *values])


def answer(comparison: Comparison) -> str:
    """Write what decides first: success and requirements; then how many numbers changed, and which most clearly."""
    sentences = [
        _unlike(comparison),
        *map(partial(_success, comparison), comparison.success),
        *_requirement_changes(comparison.requirement_changes),
        _numbers_in_words(comparison),
    ]
    return " ".join(filter(None, sentences))


def _unlike(comparison: Comparison) -> str:
    """Write in one line that the missions have unlike tasks, or little in common; nothing where they are alike."""
    first, second = (", ".join(names) or "no phases" for names in comparison.phases)
    if first != second:
        what = f"the first has {first}, the second {second}"
        return f"The two missions are not alike: {what}; only what both have is compared."
    if comparison.task_differs:
        return f"The missions have unlike tasks: they differ {task_in_words(comparison.task_differs)}."
    if comparison.alike:
        return ""
    what = f"{len(comparison.mission_changes)} values of their files differ"
    return f"The two missions are not alike: {what}; only what both have is compared."


def _success(comparison: Comparison, success: ComparedNumber) -> str:
    """Write how the probability of success changed."""
    _, verdict, first, second, change = row_of(comparison, success)
    if verdict == "same" and {item.verdict for item in comparison.differences} == {"same"}:
        return ""
    if verdict == "same":
        return f"The probability of success is {first} in both."
    if verdict == "within noise":
        return f"The probability of success, {first} and then {second}, differs by no more than noise ({change})."
    return f"The probability of success was {first} and is now {second} ({change})."


def _numbers_in_words(comparison: Comparison) -> str:
    judged = [item for item in comparison.differences if item.verdict in ("changed", "within noise", "same")]
    changed = comparison.changed
    if changed:
        largest = max(changed, key=importance)
        words = f"{len(changed)} of {len(judged)} numbers changed by more than Monte-Carlo noise, most clearly "
        return f"{words}the {name_of(comparison, largest)} ({shown_change(comparison, largest)})."
    if any(item.verdict == "within noise" for item in judged):
        return "No number changed by more than Monte-Carlo noise."
    return "The results are the same."


def _requirement_changes(changes: Sequence[ChangedValue]) -> Iterator[str]:
    """Write what became of the requirements; those that were met and were dropped in one sentence."""
    dropped = [change for change in changes if not change.second and change.first == "met"]
    together = len(dropped) > 1
    yield from (_requirement_change(change) for change in changes if not (together and change in dropped))
    if together:
        *names, last = (f"the {in_words(change.path)}" for change in dropped)
        yield f"The requirements on {', '.join(names)} and {last}, which were met, have been dropped."


def _requirement_change(change: ChangedValue) -> str:
    name = in_words(change.path)
    if not change.first:
        return f"The new requirement on the {name} is {change.second}."
    if not change.second:
        return f"The requirement on the {name}, which was {change.first}, has been dropped."
    return f"The requirement on the {name} was {change.first} and is now {change.second}."


def _numbers(comparison: Comparison) -> list[tuple[str, str]]:
    return [
        ("Changed in the mission", _count(comparison.mission_changes, "value")),
        ("Changed in the run", _count(comparison.option_changes, "option")),
        ("Changed in the results", _count(comparison.changed, "number")),
    ]


def _count(items: Sequence[object], noun: str) -> str:
    return f"{len(items) or 'no'} {noun}{'' if len(items) == 1 else 's'}"


def changes_figure(comparison: Comparison) -> Figure | None:
    """Draw the changes in standard errors, the clearest first; None where no number is noisy."""
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
    noisy = [item for item in comparison.differences if item.change is not None and noise_of(item)]
    return sorted(noisy, key=importance, reverse=True)[:_MOST_DOTS]


def draw_changes(axes: Axes, comparison: Comparison) -> None:
    """Draw a dot for each of the clearest changes, and the band of noise."""
    shown = _noisy(comparison)
    axes.axvspan(-1.96, 1.96, color=BLUE, alpha=0.15, linewidth=0.0)
    axes.axvline(0.0, color=INK, linewidth=0.8)
    scores = [(item.change or 0.0) / noise_of(item) for item in shown]
    _draw_scores(axes, scores, [(name_of(comparison, item), item.verdict == "changed") for item in shown])
    reach = 1.1 * max(3.0, *(abs(score) for score in scores))
    axes.set(yticks=[], ylim=(len(shown) - 0.5, -0.8), xlim=(-reach, reach))
    axes.set_xlabel("second − first, in standard errors of the difference")
    axes.grid(visible=False, axis="y")


def _draw_scores(axes: Axes, scores: Sequence[float], labels: Sequence[tuple[str, bool]]) -> None:
    """Draw a dot per score, labelled; orange where the second of its label says that it is more than noise."""
    for row, (score, (name, changed)) in enumerate(zip(scores, labels, strict=True)):
        axes.plot(score, row, "o", color=ORANGE if changed else BLUE, markersize=6)
        axes.text(0.01, row - 0.22, name, transform=axes.get_yaxis_transform(), va="bottom", fontsize=9)


def _runs(comparison: Comparison) -> Iterator[PageSection]:
    rows = [
        (run.folder, run.created[:16].replace("T", " "), run.version, number(run.trials), f"{run.seed}")
        for run in comparison.runs
    ]
    columns = ("folder", "made (UTC)", "missionplan", "trials", "seed")
    heading = "The missions of the two runs differ" if comparison.mission_changes else "Both runs are of one mission"
    yield PageSection(heading, [Table(columns, rows, text_columns=3)])


def _changes(comparison: Comparison) -> Iterator[PageSection]:
    mission = comparison.mission_changes if comparison.alike else ()
    groups = (("value", "mission", mission), ("option", "run", comparison.option_changes))
    for noun, whole, changes in groups:
        if changes:
            heading = f"{_count(changes, noun)} of the {whole} {'differs' if len(changes) == 1 else 'differ'}"
            yield PageSection(
                heading, [Table(("key", "first", "second"), [_change(item) for item in changes], text_columns=3)]
            )


def _change(change: ChangedValue) -> tuple[str, str, str]:
    return change.path, change.first or "–", change.second or "–"


def _deciding(comparison: Comparison) -> Iterator[PageSection]:
    if comparison.deciding:
        yield PageSection("What decides", [_table(comparison, comparison.deciding)])


def _others_changed(comparison: Comparison) -> list[ComparedNumber]:
    """Numbers that changed, besides those that decide, the clearest first."""
    others = [item for item in comparison.changed if item not in comparison.deciding]
    return sorted(others, key=importance, reverse=True)


def _changed(comparison: Comparison) -> Iterator[PageSection]:
    changed = _others_changed(comparison)
    if changed:
        yield PageSection(f"{_count(changed, 'number')} changed, the clearest first", [_table(comparison, changed)])


def _rest(comparison: Comparison) -> Iterator[PageSection]:
    shown = comparison.deciding
    rest = [item for item in comparison.differences if item.verdict != "changed" and item not in shown]
    if not comparison.alike:
        rest = [item for item in rest if item.change is not None]
    if rest:
        yield PageSection("What did not change, or cannot be judged", [_table(comparison, rest)])


def _table(comparison: Comparison, items: Sequence[ComparedNumber]) -> Table:
    many = f"The first {_MOST_ROWS} of {len(items)}; all are in differences.csv." if len(items) > _MOST_ROWS else ""
    columns = ("number", "verdict", "first", "second", "change ± standard error")
    return Table(columns, [row_of(comparison, item) for item in items[:_MOST_ROWS]], many, text_columns=2)


_PARTS = (_deciding, _changed, _runs, _changes, _rest)
"""Parts of the page, what decides first."""


PLOTS: Mapping[str, Drawing] = {"changes": draw_changes}
"""Plots on given axes by name, the main one first."""
