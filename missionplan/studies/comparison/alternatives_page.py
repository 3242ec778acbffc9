"""Report of `compare` of missions, several reports, or what was chosen: one table, and which is better."""

from collections.abc import Iterator
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.page import BLUE, ORANGE, Cells, Figure, Page, PageSection, Table, to_figure, typed
from missionplan.report.quantities import PERCENT, Unit, unit_for, with_error
from missionplan.report.wording import in_words, listed, percent
from missionplan.studies.comparison.choices_page import (
    cells_section,
    choices_in_words,
    chosen_in_words,
    curves_figure,
    differing_section,
    requirements_section,
    task_in_words,
    windows_in_words,
)
from missionplan.studies.comparison.result import DECIDES, Alternative, Alternatives

_WORDS = {"success": "P(success)", "energy_wh": "energy", "duration_s": "duration"}


_MOST_NAMED = 3
"""Values in which missions differ that a sentence names."""
_MOST_ABREAST = 3
"""Alternatives that have a column each of the page's width."""


def page(result: Alternatives) -> Page:
    """Build the page."""
    curves = cache(lambda: curves_figure(result))
    sources, made = [case.source for case in result.alternatives], result.provenance
    drawn = any(source.endswith((".yaml", ".yml")) for source in sources)
    draws = {"trials": made.trials, "seed": made.seed} if drawn else {}
    return Page(
        title=f"Which is better? {result.provenance.mission}",
        answer=answer(result),
        draw=lambda: curves() or alternatives_figure(result),
        numbers=[(case.name, percent(case.success)) for case in result.alternatives[:3]],
        write=lambda: [
            PageSection("Side by side", [_table(result), *([alternatives_figure(result)] if curves() else [])]),
            *requirements_section(result),
            *cells_section(result),
            *differing_section(result),
        ],
        rerun=typed("compare", *sources, **draws),
        table=lambda: _cells(result),
        plots={"alternatives": draw_alternatives},
    )


def answer(result: Alternatives) -> str:
    """Say which is better and by how much, or that they cannot be told apart, and in what the missions differ."""
    parts, best, differs = [], result.best_one, result.task_differs
    if differs:
        differ = f"they differ {task_in_words(differs)}, so that they are no alternatives"
        parts.append(f"The missions have unlike tasks: {differ}.")
    parts += [choices_in_words(result) if result.compared != "simulate" else "", _judged(result)]
    if best.missed and np.isfinite(best.success.value):
        which = f"{len(best.missed)} of its {len(best.requirements)} requirements"
        parts.append(f"Even {best.name} misses {which if len(best.requirements) > 1 else 'its requirement'}.")
    differing = [key for key in result.differing if key.path != "name"]
    if not differs and 0 < len(differing) <= _MOST_NAMED:
        named = [f"{in_words(key.path)} ({', '.join(value or '–' for value in key.values)})" for key in differing]
        parts.append(f"The missions differ in {', '.join(named)}.")
    return " ".join(filter(None, parts))


def _judged(result: Alternatives) -> str:
    best = result.best_one
    if not np.isfinite(best.success.value):
        return "Of none of them a choice was found that meets all requirements."
    worse = [
        case
        for case in result.others
        if len(case.missed) > len(best.missed)
        or not case.contrasts
        or (result.aim == "success" and _differs(case, "success"))
    ]
    alike = [case for case in result.others if case not in worse]
    sentences = []
    if worse:
        nearest = min(worse, key=lambda case: (len(case.missed), -case.success.value))
        verb = "does more surely what it is asked than" if result.task_differs else "is better than"
        sentences.append(f"{best.name} {verb} {listed([case.name for case in worse])}: {_why(result, nearest)}.")
    return " ".join([*sentences, *_of_alike(result, alike, is_rest=bool(worse))])


def _of_alike(result: Alternatives, alike: list[Alternative], *, is_rest: bool) -> Iterator[str]:
    """Write how those that do as well as the best differ from it in cost."""
    best = result.best_one
    if alike and result.aim == "success":
        yield _alike_in_success(best, alike, is_rest=is_rest)
        for case in alike:  # which of two takes less energy, or else less time, where that is more than chance
            cheaper = [key for key in ("energy_wh", "duration_s") if _differs(case, key)]
            yield from (_less(result, case, key) for key in cheaper[:1])
    elif alike:
        key = DECIDES[result.aim]
        same = [case for case in alike if not _differs(case, key)]
        yield from (_less(result, case, key) for case in alike if case not in same)
        if same:
            yield f"{listed([case.name for case in (best, *same)])} cannot be told apart by their {_WORDS[key]}."


def _alike_in_success(best: Alternative, alike: list[Alternative], *, is_rest: bool) -> str:
    """Write which cannot be told from the best by how often they succeed, and by how much the first differs."""
    names = [case.name for case in alike]
    who = (
        f"{listed(names)} cannot be told from it" if is_rest else f"{listed([best.name, *names])} cannot be told apart"
    )
    contrast = alike[0].contrasts["success"]
    by = f"{alike[0].name} differs by {with_error(contrast.difference, contrast.error, PERCENT)}"
    if not best.success.value and not contrast.difference:
        by = "none succeeds in any trial"
    elif not contrast.difference and not contrast.error:
        by = "they succeed in the same trials" if contrast.paired else "they succeed equally often"
    return f"{who} by P(success) ({by})."


def _differs(case: Alternative, key: str) -> bool:
    return key in case.contrasts and case.contrasts[key].differs


def _why(result: Alternatives, case: Alternative) -> str:
    best, contrast = result.best_one, case.contrasts.get("success")
    if contrast is None:
        return f"no choice tried for {case.name} meets all requirements"
    if contrast.differs and contrast.difference < 0.0:
        less = with_error(-contrast.difference, contrast.error, PERCENT)
        return f"it succeeds with {percent(best.success)}, {less} more often than {case.name}"
    names = " and ".join(f"the {in_words(item.quantity)}" for item in case.missed)
    return f"{case.name} misses the requirement on {names}"


def _less(result: Alternatives, case: Alternative, key: str) -> str:
    contrast = case.contrasts[key]
    less, more = (case, result.best_one) if contrast.difference < 0.0 else (result.best_one, case)
    size = with_error(abs(contrast.difference), contrast.error, _unit(result, key))
    return f"{less.name} takes less {'energy' if key == 'energy_wh' else 'time'}, by {size}, than {more.name}."


def _unit(result: Alternatives, key: str) -> Unit:
    data = result.provenance.data.get(result.best_one.name)
    typical = result.best_one.quantities.get(key, (float("nan"), 0.0))[0]
    return unit_for("total", key, data if isinstance(data, dict) else {}, typical=typical)


def _keys(result: Alternatives) -> list[str]:
    return [key for key in ("energy_wh", "duration_s") if any(key in case.quantities for case in result.alternatives)]


def _cells(result: Alternatives) -> Cells:
    chooses, explored, keys = result.compared != "simulate", result.compared == "explore", _keys(result)
    columns = ["", *(["chosen"] if chooses else []), "requirements", "P(success)", *(_WORDS[key] for key in keys)]
    columns += [*(["all requirements met"] if explored else []), "against the best"]
    rows = []
    for case in result.alternatives:
        met = f"{len(case.requirements) - len(case.missed)} of {len(case.requirements)} met"
        if not np.isfinite(case.success.value):
            met = "no choice meets all"
        row = [case.name, *([chosen_in_words(result, case)] if chooses else []), met if case.requirements else "–"]
        row.append(percent(case.success))
        for key in keys:
            row.append(with_error(*case.quantities[key], _unit(result, key)) if key in case.quantities else "–")
        row += [windows_in_words(result, case)] if explored else []
        rows.append([*row, "best" if case is result.best_one else _against(result, case)])
    return columns, rows


def _against(result: Alternatives, case: Alternative) -> str:
    """Write the difference from the best in what is aimed at."""
    key = DECIDES[result.aim]
    contrast = case.contrasts.get(key)
    if contrast is None:
        return "–"
    if not contrast.difference and not contrast.error and key == "success":
        return "succeeds in the same trials" if contrast.paired else "succeeds as often"
    words = with_error(contrast.difference, contrast.error, PERCENT if key == "success" else _unit(result, key))
    words = words if words.startswith("−") or not contrast.difference else f"+{words}"
    return words if contrast.differs else f"{words}: not told apart"


def _table(result: Alternatives) -> Table:
    paired = all(contrast.paired for case in result.others for contrast in case.contrasts.values())
    caption = "Reports are compared as independent runs, missions with each other trial by trial."
    if result.compared != "simulate":
        caption = "The best of each report, compared as independent runs."
    elif paired:
        caption = "Run on the same random numbers and compared trial by trial."
    caption += " Told apart: beyond chance at 5 % for all together (Bonferroni)."
    columns, rows = _cells(result)
    if len(rows) > _MOST_ABREAST:
        return Table(columns, rows, caption, text_columns=2)
    turned = [[name, *values] for name, *values in zip(columns[1:], *(row[1:] for row in rows), strict=True)]
    return Table(["", *(row[0] for row in rows)], turned, caption)


def draw_alternatives(axes: Axes, result: Alternatives, quantity: str = "success") -> None:
    """Draw P(success), ``energy_wh`` or ``duration_s`` of each, with its 95 % interval."""
    unit = PERCENT if quantity == "success" else _unit(result, quantity)
    for row, case in enumerate(result.alternatives):
        mean, error = case.quantities.get(quantity, (np.nan, np.nan))
        ends = mean - 1.96 * error, mean, mean + 1.96 * error
        if quantity == "success":
            ends = case.success.low, case.success.value, case.success.high
        low, middle, high = (value / unit.size for value in ends)
        colour = ORANGE if case is result.best_one else BLUE
        axes.errorbar(middle, row, xerr=[[middle - low], [high - middle]], fmt="o", color=colour, markersize=5)
    axes.set_title(f"{_WORDS[quantity]}{unit.axis}")
    axes.margins(x=0.15)
    axes.set_yticks(range(len(result.alternatives)), [case.name for case in result.alternatives])
    axes.set_ylim(len(result.alternatives) - 0.5, -0.5)


def alternatives_figure(result: Alternatives) -> Figure:
    """Draw P(success), energy and duration of each with 95 % intervals."""
    keys = ["success", *_keys(result)]
    figure = MatplotlibFigure(figsize=(6.4, 0.9 + 0.4 * len(result.alternatives)))
    panels = figure.subplots(1, len(keys), sharey=True, squeeze=False)[0]
    for axes, key in zip(panels, keys, strict=True):
        draw_alternatives(axes, result, key)
    return to_figure(
        figure,
        "alternatives",
        f"Probability of success, energy and duration of {len(result.alternatives)} alternatives",
        "Orange: the best. Bars: 95 % intervals of each alone; the differences are known better than that.",
    )
