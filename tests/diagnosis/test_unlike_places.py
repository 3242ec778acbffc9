"""Campaigns of two places: what the water of one did is never borrowed by the other."""

import copy
from pathlib import Path

import numpy as np
import pytest
import yaml

import missionplan
from missionplan.mission import Mission
from missionplan.report.diagnosis.campaign import answer
from missionplan.results.learned import Campaign
from tests.fixtures import TRANSIT

M2 = 2.0 * np.pi / (12.4206 * 3600.0)
EARTH, START, WEEKS = 6.371e6, 1.78e9, 5.0 * 7.0 * 86400.0
HEADER = "t_start_s,t_end_s,lat_start,lon_start,lat_dr_end,lon_dr_end,lat_end,lon_end"


def write_legs(folder: Path, legs: int, begins: float, east: float, tide: complex, rng: np.random.Generator) -> Path:
    """Legs of 20 minutes at 0.4 m/s, so far east of the origin [m], in a tide [m/s] that turns about the compass."""
    rows, place, clock = [HEADER], complex(east, 0.0), begins
    for leg in range(legs):
        course = np.exp(1j * np.radians(90.0 - 75.0 * leg))
        water = tide * np.cos(M2 * (clock + 600.0 - START)) + 1j * tide * np.sin(M2 * (clock + 600.0 - START))
        error = 0.02 * complex(*rng.standard_normal(2))
        reckoned, end = place + 480.0 * course, place + 1200.0 * (0.4 * course + water + error)
        fixes = [each + 3.0 * complex(*rng.standard_normal(2)) for each in (place, end)]
        cells = [f"{clock:.1f}", f"{clock + 1200.0:.1f}"]
        for each in (fixes[0], fixes[0] + reckoned - place, fixes[1]):
            latitude = 37.0 + np.degrees(each.imag / EARTH)
            cells += [f"{latitude:.7f}", f"{-76.0 + np.degrees(each.real / EARTH / np.cos(np.radians(37.0))):.7f}"]
        rows.append(",".join(cells))
        place, clock = end, clock + 1500.0
    folder.mkdir(parents=True)
    (folder / "legs.csv").write_text("\n".join(rows) + "\n")
    keys = {"kind": "transit", "name": folder.name, "file": "legs.csv", "noise": {"fix": "3 m"}}
    (folder / "dataset.yaml").write_text(yaml.safe_dump(keys))
    return folder


def sailed(root: Path, seed: int, km: float) -> tuple[Campaign, Mission, Path]:
    """A record of half a day in a tide, and another of nine legs so far away and five weeks later, in none."""
    rng = np.random.default_rng([seed, 4302])
    data = copy.deepcopy(TRANSIT)
    data["phases"][0]["transit"]["speed"] = "0.4 m/s"
    mission = Mission.from_data({**data, "start": f"{np.datetime64(int(START), 's')}Z"})
    tide = 0.2 * np.exp(1j * rng.uniform(0.0, 2.0 * np.pi))
    first = write_legs(root / "a", 36, START, 0.0, tide, rng)
    second = write_legs(root / "b", 9, START + WEEKS, 1000.0 * km, 0.0j, rng)
    return missionplan.diagnose_campaign(mission, [first, second], plan=False), mission, second


@pytest.mark.slow  # what a mission far away has of a current: tests/mission/test_places.py
@pytest.mark.parametrize("seed", range(1, 21))
def test_another_place_borrows_no_tide(tmp_path: Path, seed: int) -> None:
    campaign, mission, second = sailed(tmp_path, seed, 350.0)
    there, here = campaign.diagnoses
    assert "tidal-current" in there.causes
    alone = missionplan.diagnose(mission, second, plan=False)
    assert "tidal-current" not in (*here.known, *here.causes, *(each.effect for each in here.confirmed))
    assert not any("tidal-current" in each.causes for each in here.explanations)
    assert (here.verdict, here.causes) == (alone.verdict, alone.causes)
    assert "the extended mission carries all but tidal current" in answer(campaign)
    assert any("tidal-current was learned" in notice for notice in here.provenance.notices)
