"""The kinds of data that a report can show: a new kind has a module of its own and a line here."""

from collections.abc import Mapping

from missionplan.report.diagnosis.data_kinds import dives, legs, tank
from missionplan.report.diagnosis.data_kinds.kind_report import KindReport

REPORTS: Mapping[str, KindReport] = {
    "transit": legs.REPORT,
    "descent": dives.REPORT,
    "summary": dives.SUMMARY_REPORT,
    **tank.REPORTS,
}
"""By the data set's kind."""
