"""Make the four diagnoses of ``docs/log-book.md`` in a folder, or draw their history beside this file.

``python docs/figures/history.py [FOLDER]``
"""

import re
import sys
import tempfile
from pathlib import Path

import numpy as np

import missionplan

ERRORS = {"mission-1": 3.0, "mission-2": 3.0, "mission-3": 7.0, "mission-4": 7.0}
"""Error of the compass in each mission [deg], in none of the mission files."""

LEGS = 40


def mission() -> missionplan.Mission:
    """Return the mission that knows of no error: legs of 300 m at 1.5 m/s."""
    transit = {"from": ["0 m", "0 m"], "to": ["3 km", "0 m"], "speed": "1.5 m/s", "d_max": "300 m", "depth": "2 m"}
    return missionplan.Mission.from_data(
        {
            "name": "Log book",
            "site": {"depth": "30 m"},
            "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "fix_error": "2 m", "surfacing_time": "90 s"},
            "phases": [{"transit": {**transit, "arrival_radius": "30 m"}}],
        }
    )


def write_legs(folder: Path, compass_error: float, rng: np.random.Generator) -> Path:
    """Write legs to the east, north, west and south in turn, sailed with an error of the compass [deg]."""
    rows = ["t_start_s,t_end_s,x_start_m,y_start_m,x_dr_m,y_dr_m,x_end_m,y_end_m"]
    here, turn = 0j, np.exp(-1j * np.radians(compass_error))
    for number in range(LEGS):
        reckoned = 300.0 * 1j**number
        drift = 200.0 * 0.03 * complex(*rng.normal(size=2))
        start, end = (place + 2.0 * complex(*rng.normal(size=2)) for place in (here, here + reckoned * turn + drift))
        places = [start, start + reckoned, end]
        numbers = [290.0 * number, 290.0 * number + 200.0, *(each for p in places for each in (p.real, p.imag))]
        rows.append(",".join(f"{each:.2f}" for each in numbers))
        here += reckoned * turn + drift
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "legs.csv").write_text("\n".join(rows) + "\n")
    (folder / "dataset.yaml").write_text(f"kind: transit\nname: {folder.name}\nfile: legs.csv\n")
    return folder


def diagnose_all(reports: Path) -> None:
    """Diagnose each mission with what the one before has learned."""
    rng = np.random.default_rng(1)
    known = mission()
    for name, error in ERRORS.items():
        legs = write_legs(reports.parent / "logs" / name, error, rng)
        folder = missionplan.diagnose(known, legs, jobs=1).save(reports / name)
        known = missionplan.load(folder / "mission.yaml")


def main() -> None:
    """Make the diagnoses in the folder named; without one, draw them, on white so that they are legible on any page."""
    if sys.argv[1:]:
        diagnose_all(Path(sys.argv[1]))
        return
    with tempfile.TemporaryDirectory() as folder:
        diagnose_all(Path(folder) / "reports")
        drawn = missionplan.history(Path(folder) / "reports").save(Path(folder) / "history")
        svg = (drawn / "figures" / "history.svg").read_text(encoding="utf-8")
    white = '<rect width="100%" height="100%" fill="#ffffff"/>'
    picture = Path(__file__).parent / "history.svg"
    picture.write_text(re.sub(r"(<svg[^>]*>)", rf"\1{white}", svg, count=1), encoding="utf-8")


if __name__ == "__main__":
    main()
