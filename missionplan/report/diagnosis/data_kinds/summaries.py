"""Summaries of dives in the report: the numbers of each test, a panel a quantity."""

from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.report.diagnosis.data_kinds.dives import REPORT as DIVES
from missionplan.report.diagnosis.data_kinds.kind_report import KindReport
from missionplan.report.page import BLUE, GREY, ORANGE, Figure, to_figure
from missionplan.report.quantities import split_key
from missionplan.report.wording import in_words
from missionplan.results.learned.diagnosis import Diagnosis


def _data_figure(diagnosis: Diagnosis) -> Figure:
    """Draw the numbers of each test, a panel for each quantity."""
    quantities = list(diagnosis.residuals.groupby("quantity", sort=False))
    figure = MatplotlibFigure(figsize=(6.4, 0.35 * diagnosis.residuals["run"].nunique() + 1.6), layout="constrained")
    panels = figure.subplots(1, len(quantities), sharey=True, squeeze=False)[0]
    for axes, (name, table) in zip(panels, quantities, strict=True):
        runs = table["run"].astype(str)
        axes.errorbar(table["measured"], runs, xerr=table["sd"], fmt="o", color=GREY, label="measured")
        axes.plot(table["base"], runs, "s", color=ORANGE, fillstyle="none", label="mission")
        if diagnosis.causes:
            axes.plot(table["extended"], runs, "D", color=BLUE, fillstyle="none", label="extended")
        difference = ",\nmeasured less simulated" if table["less_simulated"].all() else ""
        axes.set_xlabel(f"{in_words(str(name)).capitalize()}{difference} ({split_key(str(name))[1]})")
        axes.margins(y=0.25)
    panels[0].invert_yaxis()
    shown = panels[0].get_legend_handles_labels()
    figure.legend(*shown, loc="outside upper center", ncols=3, fontsize=9, frameon=False)
    extended = ", extended model" if diagnosis.causes else ""
    against = "the mission's and the extended model" if diagnosis.causes else "the mission's model"
    return to_figure(
        figure,
        "data",
        alt=f"Numbers of each test: measured, mission's model{extended}",
        caption=f"The numbers of each test with their standard deviations, against {against}.",
    )


REPORT = KindReport(unit="sd", data_figure=_data_figure, calibration=DIVES.calibration)
