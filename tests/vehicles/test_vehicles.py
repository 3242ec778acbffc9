"""Exported files, sailed by their formats' own semantics in their missions' own sea, against `simulate --as-exported`."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from helm import Helm, Sailed
from sea import Voyage
from voyages import voyage_of

import missionplan
from missionplan.mission import Mission
from missionplan.results.simulation import Outcome

FAST = [3, 8]
TRIALS = 4000


@dataclass(frozen=True)
class Compared:
    """What was sailed, and what was simulated of the same mission."""

    sailed: list[Sailed]
    simulated: Outcome
    data: dict


def sail(number: int, voyages: int, tmp_path: Path, climb: float) -> Compared:
    data, sea, facts = voyage_of(number)
    data["site"].pop("origin")  # points in the mission's own plane: the frame of UTM is tested with the files
    mission = Mission.from_data(data, file="voyage.yaml")
    (path,) = missionplan.export(mission, "moos", out=tmp_path / "voyage.bhv", seed=5).files
    text, sailed = path.read_text(), []
    for k in range(voyages):
        voyage = Voyage(sea, np.random.default_rng((number, k)))
        sailed.append(Helm(text, voyage, climb, facts["goal"], (facts["bottom"], facts["galvanic"])).sail())
    simulated = missionplan.simulate(mission, trials=TRIALS, seed=9, as_exported="moos", keep_trials=True)
    return Compared(sailed, simulated, data)


def agree(sailed: np.ndarray, simulated: np.ndarray, at_least: float = 0.0) -> None:
    """Means within three standard errors, by the spread of the many: of the few, all may be alike."""
    error = 3.0 * simulated.std() * np.sqrt(1.0 / sailed.size + 1.0 / simulated.size)
    assert sailed.mean() == pytest.approx(simulated.mean(), abs=max(error, at_least))


def check(found: Compared) -> None:
    trials, radius = found.simulated.trials, float(found.data["phases"][0]["transit"]["arrival_radius"].split()[0])
    longest = float(found.data["phases"][0]["transit"]["d_max"].split()[0])
    releases = [each.release for each in found.sailed if each.release]
    assert all(release["fix_off"] < radius for release in releases)
    assert all(release["depth"] == 0.0 for release in releases)
    assert all(8.0 <= release["since_fix"] <= 13.0 for release in releases)
    assert all(max(each.legs) <= longest for each in found.sailed)
    legs = np.array([sum(name == "1_out_decide" for name in each.phases) for each in found.sailed], dtype=float)
    simulated = trials["out.surfacings"].dropna().to_numpy(dtype=float)
    agree(legs, simulated, at_least=0.15)
    arrived = np.array([each.release is not None for each in found.sailed], dtype=float)
    agree(arrived, trials["out.arrived"].to_numpy(dtype=float), at_least=0.02)
    within = np.array(
        [np.hypot(*np.subtract(each.arrived[0], voyage_goal(found))) < radius for each in found.sailed if each.arrived]
    )
    error = trials["out.arrival_error_m"].dropna().to_numpy(dtype=float)
    agree(within.astype(float), (error < radius).astype(float), at_least=0.02)


def voyage_goal(found: Compared) -> tuple[float, float]:
    east, north = found.data["phases"][0]["transit"]["to"]
    return float(east.split()[0]), float(north.split()[0])


@pytest.mark.parametrize("number", FAST)
def test_moos(number, tmp_path):
    check(sail(number, 12, tmp_path, climb=np.tan(np.radians(5.0))))


@pytest.mark.slow
@pytest.mark.parametrize("number", [n for n in range(20) if n not in FAST])
def test_moos_many(number, tmp_path):
    check(sail(number, 40, tmp_path, climb=np.tan(np.radians(5.0))))


@pytest.mark.parametrize("climb", [0.02, 0.4])
def test_no_leg_is_longer_and_none_released_before_a_fix_however_the_vehicle_climbs(climb, tmp_path):
    found = sail(4, 3, tmp_path, climb)
    longest = float(found.data["phases"][0]["transit"]["d_max"].split()[0])
    assert all(max(each.legs) <= longest for each in found.sailed)
    assert all(each.release["fix_off"] < 40.0 and each.release["depth"] == 0.0 for each in found.sailed)


def test_the_interpreters_share_nothing_with_the_package():
    for path in ("helm.py", "sea.py", "dune.py", "logs.py"):
        source = (Path(__file__).parent / path).read_text()
        assert not re.search(r"^\s*(from|import) missionplan", source, re.M)


def test_a_way_round_is_sailed_point_by_point(tmp_path):
    """With a point on the way the vehicle arrives there by its fix, then at the goal; nothing leads straight."""
    data, sea, facts = voyage_of(2)
    data["site"].pop("origin")
    east, north = facts["goal"]
    data["phases"][0]["transit"]["via"] = [[f"{east / 2 - north / 3} m", f"{north / 2 + east / 3} m"]]
    mission = Mission.from_data(data, file="voyage.yaml")
    (path,) = missionplan.export(mission, "moos", out=tmp_path / "voyage.bhv", seed=5).files
    sailed = Helm(path.read_text(), Voyage(sea, np.random.default_rng(1)), 0.3, facts["goal"], (facts["bottom"], 120.0))
    done = sailed.sail()
    assert not done.aborted
    assert done.phases.index("1_1_out_decide") < done.phases.index("1_2_out_leg") < done.phases.index("2_moor_release")
    via = np.array([east / 2 - north / 3, north / 2 + east / 3])
    radius = float(data["phases"][0]["transit"]["arrival_radius"].split()[0])
    assert np.hypot(*(np.array(done.arrived[0]) - via)) < radius + 15.0
