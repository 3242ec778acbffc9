"""Report of `identify`: the parameters, and each fit over its data with the residuals below."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.errors import InputError, Problem, shown
from missionplan.report.page import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PINK,
    Cells,
    Figure,
    Listing,
    Page,
    PageSection,
    Table,
    to_figure,
    typed,
)
from missionplan.report.wording import capitalised, significant
from missionplan.results import to_yaml
from missionplan.studies.identification.fits import FitPanel, Identification, IdentifiedParameter

_MANY = 60
"""Number of points above which they are drawn small and without error bars."""


def page(result: Identification) -> Page:
    """Build the page of an identification."""
    return Page(
        title=f"Identification: {result.name}",
        answer=result.answer,
        draw=lambda: panel_figure(result.panels[0]),
        numbers=_numbers(result),
        write=lambda: _sections(result),
        rerun=typed("identify", result.provenance.file),
        table=lambda: _cells(result),
        plots={"fit": fit},
    )


def _sections(result: Identification) -> list[PageSection]:
    best, source = result.fits[0], [f"The data: {result.source}"] if result.source else []
    heading = f"Model of the data: {best.name}"
    if best.does_not_fit:
        heading = f"Best, but not good: {best.name}"
    elif len(result.fits) > 1:
        heading = f"Model that the data support: {best.name}, not {result.fits[1].name}"
    sections = [PageSection(heading, [parameter_table(result), *result.remarks, *source])]
    if others := [panel_figure(panel) for panel in result.panels[1:]]:
        sections.append(PageSection("The fit against the other readings", others))
    fragment = "Paste this into the vehicle file; it is also in vehicle-fragment.yaml."
    sections.append(PageSection("What to write in the vehicle file", [fragment, Listing(to_yaml(result.fragment))]))
    return sections


def _numbers(result: Identification) -> list[tuple[str, str]]:
    """The first parameters, those for the vehicle file where the data are of a model."""
    shown = (result.derived or result.estimates)[:4]
    return [(capitalised(_name_in_words(estimate)), estimate_in_words(estimate)) for estimate in shown]


def _name_in_words(estimate: IdentifiedParameter) -> str:
    return estimate.name.replace("_", " ").replace("reynolds", "Reynolds")


def _cells(result: Identification) -> Cells:
    rows = [(_name_in_words(e), *_numbers_of(e)) for e in result.estimates]
    return ("parameter", "value", "standard error", "90 % interval", "unit"), rows


def panel_figure(panel: FitPanel) -> Figure:
    """Draw data with their errors, the fitted models over them, and the residuals of the preferred one below."""
    has_residuals = bool(np.any(panel.y != panel.fitted))
    figure = MatplotlibFigure(figsize=(6.0, 4.4 if has_residuals else 2.6))
    ratios = (3, 1) if has_residuals else (1,)
    panels = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios, squeeze=False)[:, 0]
    if has_residuals:
        _draw_residuals(panels[1], panel)
    panels[-1].set_xlabel(panel.x_label)
    draw_fit(panels[0], panel)
    bars = "" if _is_plain(panel) else "Bars: the standard deviation of a reading."
    return to_figure(figure, panel.name, panel.alt, bars)


def _is_plain(panel: FitPanel) -> bool:
    """Whether the readings are drawn without their errors: they are many, or have none."""
    return len(panel.x) > _MANY or panel.y_sd is None or bool(np.all(np.isnan(panel.y_sd)))


def draw_fit(axes: Axes, panel: FitPanel) -> None:
    """Draw the data with their errors, and the fitted models over them."""
    many = len(panel.x) > _MANY
    if _is_plain(panel):
        axes.plot(panel.x, panel.y, ".", color=GREY, markersize=3 if many else 7, label="measured", zorder=2)
    else:
        axes.errorbar(
            panel.x, panel.y, panel.y_sd, fmt="o", color=GREY, markersize=4, capsize=2, label="measured", zorder=3
        )
    looks = zip((BLUE, ORANGE, GREEN, PINK), ("-", "--", ":", "-."), strict=True)
    for curve, (colour, dash) in zip(panel.curves, looks, strict=False):
        if curve.dots:
            axes.plot(curve.x, curve.y, "s", color=colour, markersize=4, label=curve.label)
        else:
            axes.plot(curve.x, curve.y, dash, color=colour, label=curve.label, zorder=4)
    if panel.ticks:
        axes.set_xticks(panel.x, panel.ticks)
        axes.margins(x=0.25)
        axes.set_ylim(bottom=0.0)
    if panel.curves:
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    axes.set_ylabel(panel.y_label)


def _draw_residuals(axes: Axes, panel: FitPanel) -> None:
    residual = panel.y - panel.fitted
    axes.axhline(0.0, color=BLUE, linewidth=1.0)
    if _is_plain(panel):
        axes.plot(panel.x, residual, ".", color=GREY, markersize=3)
    else:
        axes.errorbar(panel.x, residual, panel.y_sd, fmt="o", color=GREY, markersize=4, capsize=2)
    axes.set_ylabel("residual")


def parameter_table(result: Identification) -> Table:
    """Tabulate the parameters of every fitted model and those derived from the preferred one."""
    groups = [(fit.name, fit.estimates) for fit in result.fits] + [("derived", result.derived)]
    rows = [
        (f"{_name_in_words(e)} ({e.symbol.partition(' ')[0]})", group, *_numbers_of(e))
        for group, estimates in groups
        for e in estimates
    ]
    columns = ("parameter", "model", "value", "standard error", "90 % interval", "unit")
    return Table(columns, rows, "The first model is the preferred one.", text_columns=2)


def estimate_in_words(estimate: IdentifiedParameter) -> str:
    """Write a parameter with its error and unit, to two figures of the error."""
    sd = f" ± {significant(estimate.sd, estimate.sd)}" if estimate.has_interval and estimate.sd > 0.0 else ""
    value = significant(estimate.value, estimate.sd) if sd else f"{estimate.value:.4g}"
    return f"{value}{sd} {estimate.unit}".rstrip()


def _numbers_of(estimate: IdentifiedParameter) -> tuple[str, str, str, str]:
    """Write value, standard error, interval and unit."""
    value, sd, low, high = (
        significant(number, estimate.sd) for number in (estimate.value, estimate.sd, estimate.low, estimate.high)
    )
    if not estimate.has_interval:
        return value, "not known", "none", estimate.unit
    return value, sd, f"{low} to {high}", estimate.unit


def fit(axes: Axes, result: Identification, panel: int = 0) -> None:
    """Draw one panel of data with the models, by its number."""
    panels = result.panels
    if not isinstance(panel, int) or not 0 <= panel < len(panels):
        raise InputError([Problem(f"given {shown(panel)}, expected 0 to {len(panels) - 1}", key="panel")])
    draw_fit(axes, panels[panel])
    axes.set_xlabel(panels[panel].x_label)
