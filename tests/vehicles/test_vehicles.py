"""Exported files, sailed by their formats' own semantics in their missions' own sea, against `simulate --as-exported`."""

import json
import re
from dataclasses import dataclass, replace
from pathlib import Path

import dune
import numpy as np
import others
import pytest
import states
from helm import Helm, Sailed
from sea import Voyage
from voyages import voyage_of

import missionplan
from missionplan.mission import Mission
from missionplan.results.simulation import Outcome

FAST = [3]
TRIALS = 4000


@dataclass(frozen=True)
class Compared:
    """What was sailed, and what was simulated of the same mission."""

    sailed: list[Sailed]
    simulated: Outcome
    data: dict


def sail(number: int, voyages: int, tmp_path: Path, climb: float) -> tuple[list[Sailed], Mission, dict]:
    data, sea, facts = voyage_of(number)
    data["site"].pop("origin")  # points in the mission's own plane: the frame of UTM is tested with the files
    mission = Mission.from_data(data, file="voyage.yaml")
    (path,) = missionplan.export(mission, "moos", out=tmp_path / "voyage.bhv").files
    text, sailed = path.read_text(), []
    for k in range(voyages):
        voyage = Voyage(sea, np.random.default_rng((number, k)))
        sailed.append(Helm(text, voyage, climb, facts["goal"], (facts["bottom"], facts["galvanic"])).sail())
    return sailed, mission, data


def compared(number: int, voyages: int, tmp_path: Path) -> Compared:
    sailed, mission, data = sail(number, voyages, tmp_path, climb=np.tan(np.radians(5.0)))
    simulated = missionplan.simulate(mission, trials=TRIALS, seed=9, as_exported="moos", keep_trials=True, sheet=False)
    return Compared(sailed, simulated, data)


def agree(sailed: np.ndarray, simulated: np.ndarray, at_least: float = 0.0) -> None:
    """Means within three standard errors, by the spread of the many: of the few, all may be alike.

    What happens in none of the many may happen in three of the few's number (rule of three, of both).
    """
    error = 3.0 * simulated.std() * np.sqrt(1.0 / sailed.size + 1.0 / simulated.size)
    if set(np.unique(simulated)) <= {0.0, 1.0}:
        at_least = max(at_least, 3.0 / sailed.size)
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


HOME = (37.25, -76.38)


def sail_other(form: str, number: int, voyages: int, folder: Path) -> None:
    """Legs, and arrivals by the last fix, as `simulate --as-exported` has them."""
    data, sea, facts = voyage_of(number, gliding=form == "slocum")
    data["phases"] = data["phases"][:1]  # these formats have no more than the transits
    mission = Mission.from_data(data, file="voyage.yaml")
    (folder / "out").mkdir()
    written = missionplan.export(mission, form, out=folder / "out").files
    texts = [path.read_text() for path in written if path.suffix in (".mis", ".ma", ".mi") or "ardusub" in path.name]
    radius = float(data["phases"][0]["transit"]["arrival_radius"].split()[0])
    arrived, off, legs = [], [], []
    for k in range(voyages):
        voyage = Voyage(sea, np.random.default_rng((number, k)))
        if form == "neptus":
            home, plans = dune.read(written[0].read_bytes())
            assert home == pytest.approx(HOME)
            done = dune.sail(plans, voyage)
        elif form == "iver":
            done = others.iver(texts, HOME, voyage)
        elif form == "qgc":
            done = others.autopilot(texts, HOME, voyage)
        else:
            named = {path.name: text for path, text in zip(written, texts, strict=True)}
            done = others.glider(named, HOME, voyage, facts["speed"], facts["depth"])
        true, fix = done.ends[0]
        arrived.append(float(np.hypot(*np.subtract(fix, facts["goal"])) < radius))
        legs.append(float(done.legs[0]))
        off.append(float(np.hypot(*np.subtract(true, facts["goal"]))))
    trials = missionplan.simulate(
        mission, trials=TRIALS, seed=9, as_exported=form, keep_trials=True, sheet=False
    ).trials
    came = np.array(arrived) > 0.0
    agree(np.array(arrived), trials["out.arrived"].to_numpy(dtype=float), at_least=0.02)
    if came.any():
        agree(np.array(legs)[came], trials["out.surfacings"].dropna().to_numpy(dtype=float), at_least=0.1)
        agree(np.array(off)[came], trials["out.arrival_error_m"].dropna().to_numpy(dtype=float), at_least=0.3)


OTHERS = ["neptus", "iver", "qgc", "slocum"]


@pytest.mark.parametrize("form", OTHERS)
def test_others(form, tmp_path):
    sail_other(form, 3, 150, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("form", OTHERS)
@pytest.mark.parametrize("number", [n for n in range(20) if n != 3])
def test_others_many(form, number, tmp_path):
    sail_other(form, number, 400, tmp_path)


def voyage_goal(found: Compared) -> tuple[float, float]:
    east, north = found.data["phases"][0]["transit"]["to"]
    return float(east.split()[0]), float(north.split()[0])


@pytest.mark.parametrize("number", FAST)
def test_moos(number, tmp_path):
    check(compared(number, 6, tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize("number", range(20))
def test_moos_many(number, tmp_path):
    check(compared(number, 40, tmp_path))


@pytest.mark.parametrize("climb", [0.02, 0.4])
def test_no_leg_is_longer_and_none_released_before_a_fix_however_the_vehicle_climbs(climb, tmp_path):
    sailed, _, data = sail(4, 3, tmp_path, climb)
    longest = float(data["phases"][0]["transit"]["d_max"].split()[0])
    assert all(max(each.legs) <= longest for each in sailed)
    assert all(each.release["fix_off"] < 40.0 and each.release["depth"] == 0.0 for each in sailed)


def test_moos_gives_up_where_no_fix_comes_or_the_battery_is_used(tmp_path):
    data, sea, facts = voyage_of(4)
    data["site"].pop("origin")
    (path,) = missionplan.export(Mission.from_data(data, file="voyage.yaml"), "moos", out=tmp_path / "voyage.bhv").files
    climb, bottom = np.tan(np.radians(5.0)), (facts["bottom"], facts["galvanic"])

    def sail(sea, power=0.0):
        voyage = Voyage(sea, np.random.default_rng(4))
        return Helm(path.read_text(), voyage, climb, facts["goal"], bottom, power=power).sail()

    assert sail(sea, power=10.0).aborted == ""
    emptied = sail(sea, power=1000.0)  # 60 W h in 216 s
    assert (emptied.aborted, emptied.release) == ("BATTERY", None)
    deaf = sail(replace(sea, fix_time=100_000.0))
    assert (deaf.aborted, deaf.release, deaf.legs != []) == ("NO_FIX", None, True)


def test_a_glider_gives_up_with_a_tenth_of_its_battery_left():
    data, *_ = voyage_of(4, gliding=True)
    data["phases"] = data["phases"][:1]
    mission = Mission.from_data(data, file="voyage.yaml")
    used = missionplan.simulate(mission, trials=200, seed=1, as_exported="slocum", keep_trials=True, sheet=False).trials
    most, least = used["out.energy_wh"].max(), used["out.energy_wh"].min()
    for capacity, share in ((1.12 * most, used["out.arrived"].mean()), (1.05 * least, 0.0)):
        emptied = mission.with_({"energy.capacity": f"{capacity} W*h"})
        found = (
            missionplan.simulate(emptied, trials=200, seed=1, as_exported="slocum", sheet=False)
            .total.events["success"]
            .value
        )
        assert found == share
    assert missionplan.simulate(emptied, trials=200, seed=1, sheet=False).total.events["success"].value > 0.0


def test_simulate_runs_the_states_of_the_plan(tmp_path):
    """A mission without a correction for drift: the states of plan.json, run one by one, are its trials."""
    data, sea, facts = voyage_of(5)
    data["navigation"]["drift_compensation"] = "none"
    data["phases"] = data["phases"][:1]
    mission = Mission.from_data(data, file="voyage.yaml")
    (path,) = missionplan.export(mission, "json", out=tmp_path / "plan.json").files
    plan = json.loads(path.read_text())
    sailed = [states.sail(plan, Voyage(sea, np.random.default_rng((5, k)))) for k in range(80)]
    trials = missionplan.simulate(mission, trials=TRIALS, seed=9, keep_trials=True, sheet=False).trials
    radius = float(data["phases"][0]["transit"]["arrival_radius"].split()[0])
    fixes = [np.hypot(*np.subtract(each.ends[0][1], facts["goal"])) for each in sailed]
    assert max(fixes) < radius
    agree(np.array([float(each.legs[0]) for each in sailed]), trials["out.surfacings"].to_numpy(dtype=float), 0.1)
    off = np.array([np.hypot(*np.subtract(each.ends[0][0], facts["goal"])) for each in sailed])
    agree(off, trials["out.arrival_error_m"].to_numpy(dtype=float), 0.3)
    times = np.array([each.fixes[-1][0] for each in sailed])
    agree(times, trials["out.duration_s"].to_numpy(dtype=float), 5.0)


def test_the_interpreters_share_nothing_with_the_package():
    for path in ("helm.py", "sea.py", "dune.py", "logs.py", "others.py", "states.py"):
        source = (Path(__file__).parent / path).read_text()
        assert not re.search(r"^\s*(from|import) missionplan", source, re.M)


def test_a_way_round_is_sailed_point_by_point(tmp_path):
    """With a point on the way the vehicle arrives there by its fix, then at the goal; nothing leads straight."""
    data, sea, facts = voyage_of(2)
    data["site"].pop("origin")
    east, north = facts["goal"]
    data["phases"][0]["transit"]["via"] = [[f"{east / 2 - north / 3} m", f"{north / 2 + east / 3} m"]]
    mission = Mission.from_data(data, file="voyage.yaml")
    (path,) = missionplan.export(mission, "moos", out=tmp_path / "voyage.bhv").files
    sailed = Helm(path.read_text(), Voyage(sea, np.random.default_rng(1)), 0.3, facts["goal"], (facts["bottom"], 120.0))
    done = sailed.sail()
    assert not done.aborted
    assert done.phases.index("1_1_out_decide") < done.phases.index("1_2_out_leg") < done.phases.index("2_moor_release")
    via = np.array([east / 2 - north / 3, north / 2 + east / 3])
    radius = float(data["phases"][0]["transit"]["arrival_radius"].split()[0])
    assert np.hypot(*(np.array(done.arrived[0]) - via)) < radius + 15.0
