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


def page(found: Alternatives) -> Page:
    """Build the page."""
    curves = cache(lambda: curves_figure(found))
    sources, made = [each.source for each in found.alternatives], found.provenance
    drawn = any(source.endswith((".yaml", ".yml")) for source in sources)
    draws = {"trials": made.trials, "seed": made.seed} if drawn else {}
    return Page(
        title=f"Which is better? {found.provenance.mission}",
        answer=answer(found),
        draw=lambda: curves() or alternatives_figure(found),
        numbers=[(each.name, percent(each.success)) for each in found.alternatives[:3]],
        write=lambda: [
            PageSection("Side by side", [_table(found), *([alternatives_figure(found)] if curves() else [])]),
            *requirements_section(found),
            *cells_section(found),
            *differing_section(found),
        ],
        rerun=typed("compare", *sources, **draws),
        table=lambda: _cells(found),
        plots={"alternatives": draw_alternatives},
    )


def answer(found: Alternatives) -> str:
    """Say which is better and by how much, or that they cannot be told apart, and in what the missions differ."""
    parts, best, differs = [], found.best_one, found.task_differs
    if differs:
        differ = f"they differ {task_in_words(differs)}, so that they are no alternatives"
        parts.append(f"The missions have unlike tasks: {differ}.")
    parts += [choices_in_words(found) if found.compared != "simulate" else "", _judged(found)]
    if best.missed and np.isfinite(best.success.value):
        which = f"{len(best.missed)} of its {len(best.requirements)} requirements"
        parts.append(f"Even {best.name} misses {which if len(best.requirements) > 1 else 'its requirement'}.")
    differing = [each for each in found.differing if each.path != "name"]
    if not differs and 0 < len(differing) <= _MOST_NAMED:
        named = [f"{in_words(each.path)} ({', '.join(value or '–' for value in each.values)})" for each in differing]
        parts.append(f"The missions differ in {', '.join(named)}.")
    return " ".join(filter(None, parts))


def _judged(found: Alternatives) -> str:
    best = found.best_one
    if not np.isfinite(best.success.value):
        return "Of none of them a choice was found that meets all requirements."
    worse = [
        each
        for each in found.others
        if len(each.missed) > len(best.missed)
        or not each.contrasts
        or (found.aim == "success" and _differs(each, "success"))
    ]
    alike = [each for each in found.others if each not in worse]
    sentences = []
    if worse:
        nearest = min(worse, key=lambda each: (len(each.missed), -each.success.value))
        verb = "does more surely what it is asked than" if found.task_differs else "is better than"
        sentences.append(f"{best.name} {verb} {listed([each.name for each in worse])}: {_why(found, nearest)}.")
    return " ".join([*sentences, *_of_alike(found, alike, is_rest=bool(worse))])


def _of_alike(found: Alternatives, alike: list[Alternative], *, is_rest: bool) -> Iterator[str]:
    """Write how those that do as well as the best differ from it in cost."""
    best = found.best_one
    if alike and found.aim == "success":
        yield _alike_in_success(best, alike, is_rest=is_rest)
        for each in alike:  # which of two takes less energy, or else less time, where that is more than chance
            cheaper = [key for key in ("energy_wh", "duration_s") if _differs(each, key)]
            yield from (_less(found, each, key) for key in cheaper[:1])
    elif alike:
        key = DECIDES[found.aim]
        same = [each for each in alike if not _differs(each, key)]
        yield from (_less(found, each, key) for each in alike if each not in same)
        if same:
            yield f"{listed([each.name for each in (best, *same)])} cannot be told apart by their {_WORDS[key]}."


def _alike_in_success(best: Alternative, alike: list[Alternative], *, is_rest: bool) -> str:
    """Write which cannot be told from the best by how often they succeed, and by how much the first differs."""
    names = [each.name for each in alike]
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


def _differs(each: Alternative, key: str) -> bool:
    return key in each.contrasts and each.contrasts[key].differs


def _why(found: Alternatives, each: Alternative) -> str:
    best, contrast = found.best_one, each.contrasts.get("success")
    if contrast is None:
        return f"no choice tried for {each.name} meets all requirements"
    if contrast.differs and contrast.difference < 0.0:
        less = with_error(-contrast.difference, contrast.error, PERCENT)
        return f"it succeeds with {percent(best.success)}, {less} more often than {each.name}"
    names = " and ".join(f"the {in_words(item.quantity)}" for item in each.missed)
    return f"{each.name} misses the requirement on {names}"


def _less(found: Alternatives, each: Alternative, key: str) -> str:
    contrast = each.contrasts[key]
    less, more = (each, found.best_one) if contrast.difference < 0.0 else (found.best_one, each)
    size = with_error(abs(contrast.difference), contrast.error, _unit(found, key))
    return f"{less.name} takes less {'energy' if key == 'energy_wh' else 'time'}, by {size}, than {more.name}."


def _unit(found: Alternatives, key: str) -> Unit:
    data = found.provenance.data.get(found.best_one.name)
    typical = found.best_one.quantities.get(key, (float("nan"), 0.0))[0]
    return unit_for("total", key, data if isinstance(data, dict) else {}, typical=typical)


def _keys(found: Alternatives) -> list[str]:
    return [key for key in ("energy_wh", "duration_s") if any(key in each.quantities for each in found.alternatives)]


def _cells(found: Alternatives) -> Cells:
    chooses, explored, keys = found.compared != "simulate", found.compared == "explore", _keys(found)
    columns = ["", *(["chosen"] if chooses else []), "requirements", "P(success)", *(_WORDS[key] for key in keys)]
    columns += [*(["all requirements met"] if explored else []), "against the best"]
    rows = []
    for each in found.alternatives:
        met = f"{len(each.requirements) - len(each.missed)} of {len(each.requirements)} met"
        if not np.isfinite(each.success.value):
            met = "no choice meets all"
        row = [each.name, *([chosen_in_words(found, each)] if chooses else []), met if each.requirements else "–"]
        row.append(percent(each.success))
        for key in keys:
            row.append(with_error(*each.quantities[key], _unit(found, key)) if key in each.quantities else "–")
        row += [windows_in_words(found, each)] if explored else []
        rows.append([*row, "best" if each is found.best_one else _against(found, each)])
    return columns, rows


def _against(found: Alternatives, each: Alternative) -> str:
    """Write the difference from the best in what is aimed at."""
    key = DECIDES[found.aim]
    contrast = each.contrasts.get(key)
    if contrast is None:
        return "–"
    if not contrast.difference and not contrast.error and key == "success":
        return "succeeds in the same trials" if contrast.paired else "succeeds as often"
    words = with_error(contrast.difference, contrast.error, PERCENT if key == "success" else _unit(found, key))
    words = words if words.startswith("−") or not contrast.difference else f"+{words}"
    return words if contrast.differs else f"{words}: not told apart"


def _table(found: Alternatives) -> Table:
    paired = all(contrast.paired for each in found.others for contrast in each.contrasts.values())
    caption = "Reports are compared as independent runs, missions with each other trial by trial."
    if found.compared != "simulate":
        caption = "The best of each report, compared as independent runs."
    elif paired:
        caption = "Run on the same random numbers and compared trial by trial."
    caption += " Told apart: beyond chance at 5 % for all together (Bonferroni)."
    columns, rows = _cells(found)
    if len(rows) > _MOST_ABREAST:
        return Table(columns, rows, caption, text_columns=2)
    turned = [[name, *values] for name, *values in zip(columns[1:], *(row[1:] for row in rows), strict=True)]
    return Table(["", *(row[0] for row in rows)], turned, caption)


def draw_alternatives(axes: Axes, found: Alternatives, quantity: str = "success") -> None:
    """Draw P(success), ``energy_wh`` or ``duration_s`` of each, with its 95 % interval."""
    unit = PERCENT if quantity == "success" else _unit(found, quantity)
    for row, each in enumerate(found.alternatives):
        mean, error = each.quantities.get(quantity, (np.nan, np.nan))
        ends = mean - 1.96 * error, mean, mean + 1.96 * error
        if quantity == "success":
            ends = each.success.low, each.success.value, each.success.high
        low, middle, high = (value / unit.size for value in ends)
        colour = ORANGE if each is found.best_one else BLUE
        axes.errorbar(middle, row, xerr=[[middle - low], [high - middle]], fmt="o", color=colour, markersize=5)
    axes.set_title(f"{_WORDS[quantity]}{unit.axis}")
    axes.margins(x=0.15)
    axes.set_yticks(range(len(found.alternatives)), [each.name for each in found.alternatives])
    axes.set_ylim(len(found.alternatives) - 0.5, -0.5)


def alternatives_figure(found: Alternatives) -> Figure:
    """Draw P(success), energy and duration of each with 95 % intervals."""
    keys = ["success", *_keys(found)]
    figure = MatplotlibFigure(figsize=(6.4, 0.9 + 0.4 * len(found.alternatives)))
    panels = figure.subplots(1, len(keys), sharey=True, squeeze=False)[0]
    for axes, key in zip(panels, keys, strict=True):
        draw_alternatives(axes, found, key)
    return to_figure(
        figure,
        "alternatives",
        f"Probability of success, energy and duration of {len(found.alternatives)} alternatives",
        "Orange: the best. Bars: 95 % intervals of each alone; the differences are known better than that.",
    )
