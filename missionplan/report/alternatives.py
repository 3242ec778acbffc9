"""Report of `compare` of missions or several reports: one table, and which is better."""

import shlex
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.display_units import Unit, unit_for
from missionplan.report.numbers import number, percent, with_error
from missionplan.report.page import BLUE, ORANGE, Figure, Page, PageSection, Table, Terminal, to_figure
from missionplan.report.wording import in_words
from missionplan.results.choosing.alternatives import Alternative, Alternatives, Contrast

_PERCENT = Unit("%", 0.01)
_WORDS = {"success": "P(success)", "energy_wh": "energy", "duration_s": "duration"}


def page(found: Alternatives) -> Page:
    """Build the page."""
    return Page(
        title=f"Which is better? {found.provenance.mission}",
        answer=answer(found),
        figure=alternatives_figure(found),
        numbers=[(each.name, percent(each.success)) for each in found.alternatives[:3]],
        sections=[*_table_section(found), *_requirements(found)],
        rerun=_rerun(found),
    )


def _rerun(found: Alternatives) -> str:
    sources = [each.source for each in found.alternatives]
    command = f"missionplan compare {' '.join(map(shlex.quote, sources))}"
    if not any(source.endswith((".yaml", ".yml")) for source in sources):
        return command
    return f"{command} --trials {found.provenance.trials} --seed {found.provenance.seed}"


def terminal(found: Alternatives) -> Terminal:
    """Build the terminal's view."""
    return Terminal(answer(found), _columns(found), _rows(found))


def answer(found: Alternatives) -> str:
    """Say which is better and by how much, or that they cannot be told apart."""
    best = found.best_one
    worse = [each for each in found.others if _is_worse(found, each)]
    alike = [each for each in found.others if each not in worse]
    sentences = []
    if worse:
        nearest = min(worse, key=lambda each: (len(each.missed), -each.success.value))
        sentences.append(f"{best.name} is better than {_listed(worse)}: {_why(found, nearest)}.")
    if alike:
        verb = "cannot be told apart" if not worse else "cannot be told from it"
        who = _listed([best, *alike]) if not worse else _listed(alike)
        sentences.append(f"{who} {verb} by P(success) ({_success_words(alike[0])}).")
        sentences += [words for each in alike if (words := _cheaper(found, each))]
    return " ".join(sentences) + _missed_words(best)


def _is_worse(found: Alternatives, each: Alternative) -> bool:
    return len(each.missed) > len(found.best_one.missed) or each.contrasts["success"].differs


def _listed(items: list[Alternative]) -> str:
    names = [each.name for each in items]
    return ", ".join(names[:-1]) + f" and {names[-1]}" if len(names) > 1 else names[0]


def _why(found: Alternatives, each: Alternative) -> str:
    best, contrast = found.best_one, each.contrasts["success"]
    if contrast.differs:
        less = with_error(-contrast.difference, contrast.error, _PERCENT)
        return f"it succeeds with {percent(best.success)}, {less} more often than {each.name}"
    names = " and ".join(f"the {in_words(item.quantity)}" for item in each.missed)
    return f"{each.name} misses the requirement on {names}"


def _success_words(each: Alternative) -> str:
    contrast = each.contrasts["success"]
    if not contrast.difference and not contrast.error:
        return "they succeed in the same trials"
    return f"{each.name} differs by {with_error(contrast.difference, contrast.error, _PERCENT)}"


def _cheaper(found: Alternatives, each: Alternative) -> str:
    """Say which of two takes less energy, or else less time, where that is more than chance."""
    for key in ("energy_wh", "duration_s"):
        contrast = each.contrasts.get(key)
        if contrast is not None and contrast.differs:
            less, more = (each, found.best_one) if contrast.difference < 0.0 else (found.best_one, each)
            size = with_error(abs(contrast.difference), contrast.error, _unit(found, key))
            what = "energy" if key == "energy_wh" else "time"
            return f"{less.name} takes less {what}, by {size}, than {more.name}."
    return ""


def _missed_words(best: Alternative) -> str:
    if not best.missed:
        return ""
    return f" Even {best.name} misses {len(best.missed)} of its {len(best.requirements)} requirements."


def _unit(found: Alternatives, key: str) -> Unit:
    data = found.provenance.data.get(found.best_one.name)
    typical = found.best_one.quantities.get(key, (float("nan"), 0.0))[0]
    return unit_for("total", key, data if isinstance(data, dict) else {}, typical=typical)


def _keys(found: Alternatives) -> list[str]:
    return [key for key in ("energy_wh", "duration_s") if any(key in each.quantities for each in found.alternatives)]


def _columns(found: Alternatives) -> list[str]:
    return ["", "requirements", "P(success)", *(_WORDS[key] for key in _keys(found)), "against the best"]


def _rows(found: Alternatives) -> list[list[str]]:
    rows = []
    for each in found.alternatives:
        met = f"{len(each.requirements) - len(each.missed)} of {len(each.requirements)} met"
        numbers = [
            with_error(*each.quantities[key], _unit(found, key)) if key in each.quantities else "–"
            for key in _keys(found)
        ]
        contrast = each.contrasts.get("success")
        rows.append([each.name, met if each.requirements else "–", percent(each.success), *numbers, _against(contrast)])
    return rows


def _against(contrast: Contrast | None) -> str:
    if contrast is None:
        return "best"
    if not contrast.difference and not contrast.error:
        return "succeeds in the same trials"
    words = with_error(contrast.difference, contrast.error, _PERCENT)
    return words if contrast.differs else f"{words}: not told apart"


def _table_section(found: Alternatives) -> Iterator[PageSection]:
    paired = all(contrast.paired for each in found.others for contrast in each.contrasts.values())
    caption = (
        "Run on the same random numbers and compared trial by trial."
        if paired
        else "Reports are compared as independent runs, missions with each other trial by trial."
    )
    caption += " Told apart: beyond chance at 5 % for all together (Bonferroni)."
    yield PageSection("Side by side", [Table(_columns(found), _rows(found), caption, text_columns=2)])


def _requirements(found: Alternatives) -> Iterator[PageSection]:
    names = list(dict.fromkeys(item.quantity for each in found.alternatives for item in each.requirements))
    if not names:
        return
    rows = []
    for each in found.alternatives:
        by_name = {item.quantity: item for item in each.requirements}
        cells = [percent(by_name[name].probability) if name in by_name else "–" for name in names]
        rows.append([each.name, *cells])
    required = {item.quantity: item.required for each in found.alternatives for item in each.requirements}
    columns = ["", *(f"{in_words(name)}, {number(100.0 * required[name])} %" for name in names)]
    yield PageSection("What each reaches of what is required", [Table(columns, rows)])


def draw_alternatives(axes: Axes, found: Alternatives, quantity: str = "success") -> None:
    """Draw P(success), ``energy_wh`` or ``duration_s`` of each, with its 95 % interval."""
    unit = _PERCENT if quantity == "success" else _unit(found, quantity)
    for row, each in enumerate(found.alternatives):
        low, middle, high = (value / unit.size for value in _interval(each, quantity))
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


def _interval(each: Alternative, key: str) -> tuple[float, float, float]:
    if key == "success":
        return each.success.low, each.success.value, each.success.high
    mean, error = each.quantities.get(key, (np.nan, np.nan))
    return mean - 1.96 * error, mean, mean + 1.96 * error
