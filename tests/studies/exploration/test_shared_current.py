"""The record that the cells of an exploration share is for each start what that start alone would read."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from missionplan.mission import Mission
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.exploration.cells import SharedCurrent

FIRST = datetime.fromisoformat("2026-06-01T06:00:00+00:00")
HOURS = (0.0, 0.5, 3.0, 9.25)


def mission(folder, start, times="dated", goal="800 m"):
    """In a current to the east that grows by 1 cm/s an hour, and to the north by a tenth of that."""
    stamps = [
        f"2026-06-0{1 + hour // 24}T{hour % 24:02d}:00:00Z" if times == "dated" else f"{3600 * hour}"
        for hour in range(40)
    ]
    rows = [f"{time},1,{0.01 * hour},{0.001 * hour}" for hour, time in enumerate(stamps)]
    (folder / "record.csv").write_text("\n".join(["t_s,depth_m,east_m_s,north_m_s", *rows]))
    current = {"file": str(folder / "record.csv"), "outside": "hold"}
    if times == "from its own start":
        current["start"] = "2026-06-01T00:00:00Z"
    way = {"from": ["0 m", "0 m"], "to": [goal, "0 m"], "speed": "1 m/s", "d_max": "1 km", "arrival_radius": "100 m"}
    return Mission.from_data(
        {
            "start": start.isoformat(),
            "site": {"depth": "20 m", "current": current},
            "navigation": {"velocity_error": {"sigma": "0.01 m/s"}, "surfacing_time": "10 s"},
            "phases": [{"transit": way}],
        }
    )


def met(current, t):
    return current.velocity(t, 1.0, np.zeros((2, 1)))[:, 0]


@pytest.mark.parametrize("times", ["dated", "from its own start", "from the mission's start"])
@pytest.mark.parametrize("begun", [0.0, 5.0])
def test_a_later_start_meets_a_later_part(tmp_path, times, begun):
    """In closed form, and as read anew; a record that counts from the mission's start moves with it."""
    shared = SharedCurrent.of(mission(tmp_path, FIRST + timedelta(hours=begun), times), FIRST)
    for hours in HOURS:
        later = mission(tmp_path, FIRST + timedelta(hours=hours), times)
        for t in (0.0, 1800.0, 7200.0):
            hour = t / 3600.0 + (0.0 if times == "from the mission's start" else 6.0 + hours)
            assert met(shared.for_mission(later), t) == pytest.approx([0.01 * hour, 0.001 * hour], abs=1e-9)
            assert met(recorded_current(later), t) == pytest.approx([0.01 * hour, 0.001 * hour], abs=1e-9)


def test_a_mission_at_another_place_reads_its_own(tmp_path):
    shared = SharedCurrent.of(mission(tmp_path, FIRST), FIRST)
    assert shared.for_mission(mission(tmp_path, FIRST)) is shared.current
    elsewhere = mission(tmp_path, FIRST + timedelta(hours=2.0), goal="900 m")
    assert met(shared.for_mission(elsewhere), 0.0) == pytest.approx([0.08, 0.008])


@pytest.mark.parametrize("site", [{"depth": "25 m"}, {"origin": {"latitude": "60 deg", "longitude": "5 deg"}}])
def test_a_mission_in_another_depth_or_about_another_origin_reads_its_own(tmp_path, site):
    first = mission(tmp_path, FIRST)
    shared = SharedCurrent.of(first, FIRST)
    other = Mission.from_data({**first.raw, "site": {**first.raw["site"], **site}})
    assert shared.for_mission(other) is not shared.current
