"""A CSV of waypoints and moorings, for spreadsheets and one's own programs; needs no origin."""

import pandas as pd

from missionplan.exporters.header import header, one_line
from missionplan.exporters.rows import rows
from missionplan.results.base import to_csv
from missionplan.results.plan import Plan

TITLE = "CSV"
NEEDS_ORIGIN = False


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the form cannot hold."""
    tables = [transit.name for transit in plan.transits if transit.surfacing.table]
    return tuple(f"the table of legs of {name}; the waypoints are those of its nominal legs" for name in tables)


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file: lines of comment with `#`, then the table."""
    return {f"{stem}.csv": waypoints_csv(plan)}


def waypoints_csv(plan: Plan) -> str:
    """Write the table."""
    frame = pd.DataFrame(list(rows(plan)))
    for name in ("name", "phase"):
        frame[name] = frame[name].map(one_line)
    comments = "".join(f"# {line}\n" for line in header(plan, TITLE, lost(plan)))
    return comments + to_csv(frame)
