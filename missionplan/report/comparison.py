"""Report of two runs side by side."""

import shlex
from collections.abc import Iterator, Mapping, Sequence

from missionplan.report.numbers import Unit, number, plain, unit_for, with_error
from missionplan.report.page import BLUE, INK, ORANGE, Figure, Page, PageSection, Table, Terminal, to_figure
from missionplan.results.comparison import ChangedValue, ComparedNumber, Comparison

_MOST_ROWS = 60
_MOST_DOTS = 16
_PERCENT = Unit("%", 0.01)


def page(comparison: Comparison) -> Page:
    """Lay out the report."""
    folders = [shlex.quote(run.folder) for run in comparison.runs]
    return Page(
        title=f"Two runs of {comparison.compared}: {comparison.provenance.mission}",
        answer=_answer(comparison),
        figure=_dots(comparison),
        numbers=_numbers(comparison),
        sections=[*_runs(comparison), *_changes(comparison), *_differences(comparison)],
        rerun=f"missionplan compare {' '.join(folders)}",
    )


def terminal(comparison: Comparison) -> Terminal:
    """Give the answer, the changes of the mission, and the numbers that changed."""
    changes = [
        (change.path, change.first or "–", change.second or "–", "")
        for change in (*comparison.mission_changes, *comparison.option_changes, *comparison.requirement_changes)
    ]
    rows = [_row(comparison, difference) for difference in comparison.changed[:_MOST_ROWS]]
    columns = ("what changed", "first", "second", "change")
    return Terminal(_answer(comparison), columns, [*changes, *((row[0], *row[2:]) for row in rows)])


def _answer(comparison: Comparison) -> str:
    judged = [item for item in comparison.differences if item.verdict in ("changed", "within noise", "same")]
    changed = comparison.changed
    if changed:
        largest = max(changed, key=_importance)
        words = f"{len(changed)} of {len(judged)} numbers changed by more than Monte-Carlo noise, most clearly "
        answer = f"{words}{_name(comparison, largest)} ({_shown_change(comparison, largest)})."
    elif any(item.verdict == "within noise" for item in judged):
        answer = "No number changed by more than Monte-Carlo noise."
    else:
        answer = "The results are the same."
    flips = [
        f"{plain(change.path)} was {change.first or 'not asked'} and is {change.second or 'not asked'}"
        for change in comparison.requirement_changes
    ]
    return " ".join([answer, *(f"{flip[:1].upper()}{flip[1:]}." for flip in flips)])


def _importance(difference: ComparedNumber) -> float:
    """Size of the change against its noise, or, without noise, against the number."""
    change = abs(difference.change or 0.0)
    if difference.standard_error:
        return change / difference.standard_error
    return change / max(abs(difference.first or 0.0), abs(difference.second or 0.0), 1e-300)


def _name(comparison: Comparison, difference: ComparedNumber) -> str:
    if difference.group == "requirement":
        return f"{_requirement(comparison, difference.key)} (requirement)"
    group = difference.group if difference.group not in ("sweep", "anchor") else ""
    return plain(f"{group}.{difference.key}".lstrip(".")) if group != difference.key else plain(difference.key)


def _requirement(comparison: Comparison, key: str) -> str:
    """Write a requirement with its limit as the mission does; in SI where the mission has several on a quantity."""
    quantity, _, limit = key.partition(", ")
    written = (comparison.provenance.data["second"] or {}).get("requirements") or ()
    alike = [item for item in written if isinstance(item, Mapping) and item.get("quantity") == quantity]
    if limit and len(alike) == 1:
        bounds = (
            f"{bound.replace('_', ' ')} {alike[0][bound]}" for bound in ("at_most", "at_least") if bound in alike[0]
        )
        limit = next(bounds, limit)
    return f"{plain(quantity)} {limit}".strip()


def _unit(comparison: Comparison, difference: ComparedNumber) -> Unit:
    if difference.kind == "probability":
        return _PERCENT
    data = comparison.provenance.data["second"] or {}
    typical = difference.first if difference.first is not None else difference.second
    return unit_for(difference.group, difference.key, data, typical=abs(typical or 0.0))


def _shown_change(comparison: Comparison, difference: ComparedNumber) -> str:
    change = difference.change
    if change is None:
        return "–"
    words = with_error(change, difference.standard_error or 0.0, _unit(comparison, difference))
    return words if words.startswith("−") or change == 0.0 else f"+{words}"


def _row(comparison: Comparison, difference: ComparedNumber) -> tuple[str, str, str, str, str]:
    unit, error = _unit(comparison, difference), difference.standard_error or 0.0
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


def _dots(comparison: Comparison) -> Figure | None:
    """Show the changes in standard errors, the clearest first."""
    from matplotlib.figure import Figure as MatplotlibFigure

    noisy = [item for item in comparison.differences if item.standard_error and item.change is not None]
    shown = sorted(noisy, key=_importance, reverse=True)[:_MOST_DOTS]
    if not shown:
        return None
    figure = MatplotlibFigure(figsize=(5.0, 0.7 + 0.42 * len(shown)))
    axes = figure.add_subplot()
    axes.axvspan(-1.96, 1.96, color=BLUE, alpha=0.15, linewidth=0.0)
    axes.axvline(0.0, color=INK, linewidth=0.8)
    scores = [(item.change or 0.0) / (item.standard_error or 1.0) for item in shown]
    clearest = _name(comparison, shown[0])
    for row, (item, score) in enumerate(zip(shown, scores, strict=True)):
        axes.plot(score, row, "o", color=ORANGE if item.verdict == "changed" else BLUE, markersize=6)
        axes.text(
            0.01, row - 0.22, _name(comparison, item), transform=axes.get_yaxis_transform(), va="bottom", fontsize=9
        )
    reach = 1.1 * max(3.0, *(abs(score) for score in scores))
    axes.set(yticks=[], ylim=(len(shown) - 0.5, -0.8), xlim=(-reach, reach))
    axes.set_xlabel("second − first, in standard errors of the difference")
    axes.grid(visible=False, axis="y")
    return to_figure(
        figure,
        "changes",
        f"Changes of {len(shown)} numbers in standard errors; the clearest is {clearest} at {scores[0]:.1f}.",
        "Orange: more than noise, all numbers taken together (Holm's correction at 5 %). Band: where 95 % of the "
        "differences of one number lie by noise alone.",
    )


def _runs(comparison: Comparison) -> Iterator[PageSection]:
    rows = [
        (run.folder, run.created[:16].replace("T", " "), run.version, number(run.trials), f"{run.seed}")
        for run in comparison.runs
    ]
    columns = ("folder", "made (UTC)", "missionplan", "trials", "seed")
    heading = "Both runs are of one mission" if not comparison.mission_changes else "The runs are of different missions"
    yield PageSection(heading, [Table(columns, rows, words=3)])


def _changes(comparison: Comparison) -> Iterator[PageSection]:
    for noun, changes in (("mission", comparison.mission_changes), ("run", comparison.option_changes)):
        if changes:
            heading = f"{_count(changes, 'value')} of the {noun} {'is' if len(changes) == 1 else 'are'} different"
            yield PageSection(
                heading, [Table(("key", "first", "second"), [_change(item) for item in changes], words=3)]
            )


def _change(change: ChangedValue) -> tuple[str, str, str]:
    return change.path, change.first or "–", change.second or "–"


def _differences(comparison: Comparison) -> Iterator[PageSection]:
    changed = sorted(comparison.changed, key=_importance, reverse=True)
    rest = [item for item in comparison.differences if item.verdict != "changed"]
    if changed:
        yield PageSection(f"{_count(changed, 'number')} changed", [_table(comparison, changed)])
    if rest:
        yield PageSection("What did not change, or cannot be told", [_table(comparison, rest)])


def _table(comparison: Comparison, items: Sequence[ComparedNumber]) -> Table:
    many = f"The first {_MOST_ROWS} of {len(items)}; all are in differences.csv." if len(items) > _MOST_ROWS else ""
    columns = ("number", "verdict", "first", "second", "change ± standard error")
    return Table(columns, [_row(comparison, item) for item in items[:_MOST_ROWS]], many, words=2)
