"""Report of `compare`: two runs side by side."""

import shlex
from collections.abc import Iterator, Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.mission.checks.requirements import QUANTITIES
from missionplan.report.display_units import Unit, unit_for
from missionplan.report.numbers import NARROW_SPACE, has_spread, number, with_error
from missionplan.report.page import BLUE, INK, ORANGE, Figure, Page, PageSection, Table, Terminal, to_figure
from missionplan.report.wording import in_words
from missionplan.results.comparison import ChangedValue, ComparedNumber, Comparison

_MOST_ROWS = 60
"""Rows of a table."""
_MOST_DOTS = 16
"""Numbers in the figure."""
_PERCENT = Unit("%", 0.01)
_GROUPS = {"sweep": "", "anchor": "", "odds": "dives"}
"""How sections of `summary.json` are named, where not by their keys."""


def page(comparison: Comparison) -> Page:
    """Build the page of a comparison."""
    folders = [shlex.quote(run.folder) for run in comparison.runs]
    return Page(
        title=f"Two runs of {comparison.compared}: {comparison.provenance.mission}",
        answer=answer(comparison),
        figure=changes_figure(comparison),
        numbers=_numbers(comparison),
        sections=[*_runs(comparison), *_changes(comparison), *_differences(comparison)],
        rerun=f"missionplan compare {' '.join(folders)}",
    )


def terminal(comparison: Comparison) -> Terminal:
    """Build the terminal's view: the answer, the changes of the mission, and the numbers that changed."""
    changes = [
        (change.path, change.first or "–", change.second or "–", "")
        for change in (*comparison.mission_changes, *comparison.option_changes, *comparison.requirement_changes)
    ]
    rows = [_row(comparison, difference) for difference in comparison.changed[:_MOST_ROWS]]
    columns = ("what changed", "first", "second", "change")
    return Terminal(answer(comparison), columns, [*changes, *((row[0], *row[2:]) for row in rows)])


def answer(comparison: Comparison) -> str:
    """Write how many numbers changed, which changed most clearly, and which requirements are judged differently."""
    sentences = [_numbers_in_words(comparison), *map(_requirement_change, comparison.requirement_changes)]
    return " ".join(sentences)


def _numbers_in_words(comparison: Comparison) -> str:
    judged = [item for item in comparison.differences if item.verdict in ("changed", "within noise", "same")]
    changed = comparison.changed
    if changed:
        largest = max(changed, key=_importance)
        words = f"{len(changed)} of {len(judged)} numbers changed by more than Monte-Carlo noise, most clearly "
        return f"{words}{_name(comparison, largest)} ({_shown_change(comparison, largest)})."
    if any(item.verdict == "within noise" for item in judged):
        return "No number changed by more than Monte-Carlo noise."
    return "The results are the same."


def _requirement_change(change: ChangedValue) -> str:
    name = in_words(change.path)
    if not change.first:
        return f"The new requirement on {name} is {change.second}."
    if not change.second:
        return f"The requirement on {name}, which was {change.first}, has been dropped."
    return f"The requirement on {name} was {change.first} and is now {change.second}."


def _importance(difference: ComparedNumber) -> float:
    """Size of the change against its noise, or, without noise, against the number."""
    change = abs(difference.change or 0.0)
    noise = _noise(difference)
    if noise:
        return change / noise
    return change / max(abs(difference.first or 0.0), abs(difference.second or 0.0), 1e-300)


def _noise(difference: ComparedNumber) -> float:
    """Standard error of the change; zero where it is only rounding."""
    error = difference.standard_error or 0.0
    size = max(abs(difference.first or 0.0), abs(difference.second or 0.0))
    return error if has_spread(size, error) else 0.0


def _name(comparison: Comparison, difference: ComparedNumber) -> str:
    if difference.group == "requirement":
        return f"{_requirement(comparison, difference)} (requirement)"
    group = _GROUPS.get(difference.group, difference.group)
    return in_words(f"{group}.{difference.key}".lstrip(".")) if group != difference.key else in_words(difference.key)


def _requirement(comparison: Comparison, difference: ComparedNumber) -> str:
    """Write a requirement with its limit as the mission does, or in SI where that is not certain."""
    quantity, _, limit = difference.key.partition(", ")
    alike = [item for item in _requirements(_mission(comparison, difference)) if item.get("quantity") == quantity]
    if limit:
        limit = (_limit(alike[0]) if len(alike) == 1 else "") or _in_si(quantity, limit)
    return f"{in_words(quantity)} {limit}".strip()


def _in_si(quantity: str, limit: str) -> str:
    """Write the limit of a requirement, as the comparison's keys have it, with its SI unit."""
    units = {name: unit for kind in QUANTITIES.values() for name, unit in kind.items()}
    unit = units.get(quantity.partition(".")[2], "")
    return f"{limit}\u00a0{unit}" if unit else limit


def _requirements(mission: Mapping[str, object]) -> list[Mapping[str, object]]:
    written = mission.get("requirements")
    return [item for item in written if isinstance(item, Mapping)] if isinstance(written, list | tuple) else []


def _mission(comparison: Comparison, difference: ComparedNumber) -> Mapping[str, object]:
    """Data of the second run's mission; of the first's where only that has the number."""
    data = comparison.provenance.data["second" if difference.second is not None else "first"]
    return data if isinstance(data, Mapping) else {}


def _limit(requirement: Mapping[str, object]) -> str:
    for bound in ("at_most", "at_least"):
        if bound in requirement:
            return f"{bound.replace('_', ' ')} {str(requirement[bound]).replace('*', NARROW_SPACE)}"
    return ""


def _unit(comparison: Comparison, difference: ComparedNumber) -> Unit:
    if difference.kind == "probability":
        return _PERCENT
    typical = difference.first if difference.first is not None else difference.second
    return unit_for(difference.group, difference.key, _mission(comparison, difference), typical=abs(typical or 0.0))


def _shown_change(comparison: Comparison, difference: ComparedNumber) -> str:
    change = difference.change
    if change is None:
        return "–"
    words = with_error(change, _noise(difference), _unit(comparison, difference))
    return words if words.startswith("−") or change == 0.0 else f"+{words}"


def _row(comparison: Comparison, difference: ComparedNumber) -> tuple[str, str, str, str, str]:
    unit, error = _unit(comparison, difference), _noise(difference)
    first, second = (
        "–" if value is None else number(unit(value), unit(error)) + unit.suffix
        for value in (difference.first, difference.second)
    )
    return _name(comparison, difference), difference.verdict, first, second, _shown_change(comparison, difference)


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
    noisy = [item for item in comparison.differences if item.change is not None and _noise(item)]
    shown = sorted(noisy, key=_importance, reverse=True)[:_MOST_DOTS]
    if not shown:
        return None
    figure = MatplotlibFigure(figsize=(5.0, 0.7 + 0.42 * len(shown)))
    axes = figure.add_subplot()
    axes.axvspan(-1.96, 1.96, color=BLUE, alpha=0.15, linewidth=0.0)
    axes.axvline(0.0, color=INK, linewidth=0.8)
    scores = [(item.change or 0.0) / _noise(item) for item in shown]
    _draw_scores(axes, scores, [(_name(comparison, item), item.verdict == "changed") for item in shown])
    reach = 1.1 * max(3.0, *(abs(score) for score in scores))
    axes.set(yticks=[], ylim=(len(shown) - 0.5, -0.8), xlim=(-reach, reach))
    axes.set_xlabel("second − first, in standard errors of the difference")
    axes.grid(visible=False, axis="y")
    clearest = _name(comparison, shown[0])
    return to_figure(
        figure,
        "changes",
        f"Changes of {len(shown)} numbers in standard errors; the clearest is {clearest} at {scores[0]:.1f}.",
        "Orange: more than noise, all numbers taken together (Holm's correction at 5 %). Band: where 95 % of the "
        "differences of one number lie by noise alone.",
    )


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
    groups = (("value", "mission", comparison.mission_changes), ("option", "run", comparison.option_changes))
    for noun, whole, changes in groups:
        if changes:
            heading = f"{_count(changes, noun)} of the {whole} {'differs' if len(changes) == 1 else 'differ'}"
            yield PageSection(
                heading, [Table(("key", "first", "second"), [_change(item) for item in changes], text_columns=3)]
            )


def _change(change: ChangedValue) -> tuple[str, str, str]:
    return change.path, change.first or "–", change.second or "–"


def _differences(comparison: Comparison) -> Iterator[PageSection]:
    changed = sorted(comparison.changed, key=_importance, reverse=True)
    rest = [item for item in comparison.differences if item.verdict != "changed"]
    if changed:
        yield PageSection(f"{_count(changed, 'number')} changed", [_table(comparison, changed)])
    if rest:
        yield PageSection("What did not change, or cannot be judged", [_table(comparison, rest)])


def _table(comparison: Comparison, items: Sequence[ComparedNumber]) -> Table:
    many = f"The first {_MOST_ROWS} of {len(items)}; all are in differences.csv." if len(items) > _MOST_ROWS else ""
    columns = ("number", "verdict", "first", "second", "change ± standard error")
    return Table(columns, [_row(comparison, item) for item in items[:_MOST_ROWS]], many, text_columns=2)
