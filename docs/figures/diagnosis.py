"""Figures of docs/validation: two gliders (if their data are beside the repository) and Table I of Briggs et al."""

from pathlib import Path

from missionplan import diagnose, load
from missionplan.report.diagnosis.evidence import ranking_figure
from missionplan.report.diagnosis.kinds import REPORTS
from missionplan.report.page import style

HERE = Path(__file__).parent
PROJECT = HERE.parent.parent
MEASURED = PROJECT.parent / "shared" / "data"


def main() -> None:
    """Write the figures of the data sets that are available."""
    table = PROJECT / "missions"
    cases = {
        "modena": (MEASURED / "modena" / "mission.yaml", MEASURED / "modena"),
        "saanich": (MEASURED / "saanich" / "mission.yaml", MEASURED / "saanich"),
        "table-1": (table / "chesapeake.yaml", table / "measured" / "table-1"),
    }
    for name, (mission, data) in cases.items():
        if not data.is_dir():
            continue
        found = diagnose(load(mission), data, plan=False)
        with style():
            pictures = {"data": REPORTS[found.kind].data_figure(found), "ranking": ranking_figure(found)}
        for kind, picture in pictures.items():
            (HERE / f"diagnosis-{name}-{kind}.svg").write_text(picture.svg, encoding="utf-8")


if __name__ == "__main__":
    main()
