"""The choice meets all requirements, is that of a full grid, and says what binds or what the obstacle is."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

import missionplan
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.mission import with_values
from missionplan.report.optimisation import answer
from missionplan.studies.optimisation import read_lattice

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked", "unheld")

MISSIONS = Path(__file__).parents[3] / "missions"
CHOOSE = ["out.speed=0.6:2:0.1 m/s", "out.d_max=150:1650:150 m"]


def transit(*, minutes=26.0, at="at_most", **changes):
    """A transit alone, that must end in time: fast is early and costly, and a surfacing takes time too."""
    whole = missionplan.load(MISSIONS / "chesapeake.yaml").raw
    data = {
        "vehicle": whole["vehicle"],
        "site": whole["site"],
        "navigation": whole["navigation"],
        "phases": [
            {
                "transit": {
                    **{"name": "out", "from": ["0 m", "0 m"], "to": ["1600 m", "0 m"], "depth": "2 m"},
                    **{"speed": "1.5 m/s", "d_max": "350 m", "arrival_radius": "15 m"},
                }
            }
        ],
        "requirements": [
            {"quantity": "out.arrived", "probability": 0.95},
            {"quantity": "total.duration", at: f"{minutes} min", "probability": 0.9},
        ],
        "monte_carlo": {"trials": 2000, "seed": 3},
    }
    return Mission.from_data(data | changes)


@pytest.fixture(scope="module")
def mission():
    return transit()


@pytest.fixture(scope="module")
def found(mission):
    return missionplan.optimise(mission, choose=CHOOSE)


@pytest.mark.slow  # of few choices: test_against_brute_force
def test_the_choice_is_that_of_the_full_grid(mission, found):
    grid = missionplan.explore(mission, CHOOSE, aim="energy", trials=2000)
    best = grid.best_cell.quantities["total.energy_wh"].mean
    assert found.feasible
    assert found.checked.total.quantities["energy_wh"].mean <= 1.01 * best
    assert found.search_trials < 0.3 * 2000 * len(grid.cells)  # of 165 cells; of larger lattices far fewer


def test_simulate_confirms_the_mission_that_is_written(found, tmp_path):
    found.save(tmp_path / "report")
    again = missionplan.simulate(missionplan.load(tmp_path / "report" / "mission-optimised.yaml"), sheet=False)
    assert again.requirements_met
    assert again.total.quantities == found.checked.total.quantities
    assert found.fresh.requirements_met
    assert found.fresh.provenance.seed != found.checked.provenance.seed
    page = (tmp_path / "report" / "report.html").read_text()
    assert "The least energy" in page
    assert (tmp_path / "report" / "front.csv").read_text().count("\n") > 1


def test_a_deadline_that_binds_says_what_a_later_one_would_buy(found):
    buys = {each.quantity: each.saved for each in found.relaxations}
    assert set(buys) == {"out.arrived", "total.duration"}
    assert all(value >= 0.0 for value in buys.values())
    free = missionplan.optimise(transit(minutes=60.0), choose=CHOOSE[:1], trials=500)
    assert free.checked.total.quantities["energy_wh"].mean < found.checked.total.quantities["energy_wh"].mean
    assert not any(each.saved for each in free.relaxations if each.quantity == "total.duration")


def test_a_requirement_that_rules_out_what_costs_less_is_named_where_one_percent_saves_nothing(found):
    quantity, saved, values = found.ruled_out.quantity, found.ruled_out.saves, found.ruled_out.values
    assert quantity == "total.duration", "slower would cost less"
    slower = Mission.from_data(with_values(transit().raw, values))
    energy = missionplan.simulate(slower, sheet=False).total.quantities["energy_wh"].mean
    assert saved == pytest.approx(found.checked.total.quantities["energy_wh"].mean - energy, rel=0.1)
    assert found.summary()["ruled_out"]["saves"] == saved
    words = answer(replace(found, relaxations=()))
    assert "saves nothing at these steps; without that on the total duration, at least about" in words


@pytest.mark.slow
def test_the_obstacle_is_named_with_how_much_is_reached(tmp_path):
    hopeless = missionplan.optimise(transit(minutes=12.0), choose=CHOOSE, trials=300)
    assert not hopeless.feasible
    assert [each.quantity for each in hopeless.obstacles] == ["total.duration"]
    assert hopeless.obstacles[0].reached.value < 0.9
    assert answer(hopeless).startswith("No choice tried meets all requirements. The obstacle is the total duration")
    would_do = hopeless.obstacles[0].would_do
    assert would_do > 12.0 * 60.0
    values = {key: value for name, value in hopeless.chosen.items() for key in name.split("+")}
    nearest = missionplan.simulate(Mission.from_data(with_values(transit().raw, values)), trials=2000, sheet=False)
    assert would_do == pytest.approx(nearest.total.quantities["duration_s"].p95, rel=0.1)
    assert "instead of 12\N{NO-BREAK SPACE}min would do" in answer(hopeless)
    hopeless.save(tmp_path / "report")
    assert not (tmp_path / "report" / "mission-optimised.yaml").exists()


@pytest.mark.parametrize(("at", "minutes"), [("at_most", 12.0), ("at_least", 90.0)])
def test_with_the_bound_that_the_report_says_would_do_the_mission_is_feasible(at, minutes):
    hopeless = missionplan.optimise(transit(minutes=minutes, at=at), choose=CHOOSE[:1], trials=300)
    told = re.search(rf"\(([\d.]+)\smin instead of {minutes:g}\smin would do\)", answer(hopeless))
    assert told is not None
    values = {key: value for name, value in hopeless.chosen.items() for key in name.split("+")}
    nearest = [f"{key}={value}" for key, value in values.items()]
    looser = missionplan.optimise(transit(minutes=float(told[1]), at=at), choose=nearest, trials=2000)
    assert looser.feasible
    assert all(item.met and not item.undecided for item in looser.checked.requirements)


def test_where_no_requirement_is_alone_each_that_is_missed_says_by_how_much():
    hard = transit(minutes=12.0)
    both = [*hard.raw["requirements"], {"quantity": "total.energy", "at_most": "0.1 W*h", "probability": 0.9}]
    found = missionplan.optimise(Mission.from_data({**hard.raw, "requirements": both}), choose=CHOOSE[:1], trials=200)
    assert {each.quantity for each in found.obstacles} == {"total.duration", "total.energy"}
    assert not any(each.alone for each in found.obstacles)
    assert all(each.would_do > each.limit for each in found.obstacles)
    assert "Dropping one requirement alone would not do." in answer(found)


def test_the_choice_does_not_depend_on_the_number_of_processes(mission):
    one, two = (missionplan.optimise(mission, choose=CHOOSE[:1], trials=400, jobs=jobs) for jobs in (1, 2))
    assert one.chosen == two.chosen
    assert one.tried == two.tried


def test_a_search_that_was_cut_short_is_resumed_to_the_same_numbers(mission, tmp_path):
    class CutError(Exception):
        pass

    def cut(done, _):
        if done == 1:  # after the wide search
            raise CutError

    kept = {"choose": CHOOSE[:1], "trials": 400, "checkpoint": tmp_path / "blocks"}
    with pytest.raises(CutError):
        missionplan.optimise(mission, **kept, progress=cut)
    finished = {path: path.stat().st_mtime_ns for path in (tmp_path / "blocks").glob("block-*.npz")}
    assert finished
    resumed = missionplan.optimise(mission, **kept, resume=True)
    whole = missionplan.optimise(mission, choose=CHOOSE[:1], trials=400)
    assert resumed.tried == whole.tried
    assert resumed.checked.total.summary() == whole.checked.total.summary()
    assert resumed.relaxations == whole.relaxations
    assert resumed.search_trials == whole.search_trials
    assert {path: path.stat().st_mtime_ns for path in finished} == finished  # none was run again
    with pytest.raises(InputError, match="another run"):
        missionplan.optimise(mission, **kept | {"choose": ["out.speed=1:2:0.5 m/s"]}, resume=True)


WRONG = """
optimise:
  choose:
    - {key: start, from: 2026-06-01T14:00, to: 2026-06-01T04:00, step: 10 min}
    - {keys: [ingress.spede, egress.speed], from: 0.6 m/s, to: 1.8 m/s}
    - {key: ingress.d_max, from: 200 kg, to: 1200 kg, step: 50 kg}
    - {key: egress.d_max, from: 200 m, to: 1200 kg}
    - {key: moor.line_length, from: 6 m, to: 3 m}
    - {key: vehicle, choices: [no.yaml, vehicles/vt475-self-mooring.yaml]}
    - {key: moor.hold, choices: [20 m, 10 min]}
    - {key: navigation.drift_compensation, choices: [none, meen]}
"""


def test_validate_says_all_that_is_wrong_with_what_may_be_chosen_line_by_line(tmp_path):
    shutil.copytree(MISSIONS / "vehicles", tmp_path / "vehicles")
    lines = (MISSIONS / "chesapeake.yaml").read_text() + "start: 2026-06-01T12:00" + WRONG
    (tmp_path / "m.yaml").write_text(lines)
    (found,) = missionplan.validate(tmp_path / "m.yaml")
    said = dict.fromkeys(problem.key for problem in found.problems)
    assert list(said) == [f"optimise.choose[{i}]" for i in range(8)]
    first = lines[: lines.index("- {key: start")].count("\n") + 1
    assert [problem.line for problem in found.problems if problem.key == "optimise.choose[7]"] == [first + 7]
    words = "\n".join(map(str, found.problems))
    for expected in (
        "before the first",
        "did you mean ingress.speed",
        "ingress.d_max cannot be 200 kg",
        "given 200 m, expected a quantity in kg",
        "expected `from` less than `to`",
        "no.yaml: no such file",
        "given 20 m, expected a quantity in min",
        "given 'meen', expected 'none'",
    ):
        assert expected in words


@pytest.mark.parametrize(
    ("values", "wrong"), [("1:40:1 m/s", "40 m/s"), ("0:2:0.5 m/s", "0 m/s"), ("1 m/s,50 m/s,2 m/s", "50 m/s")]
)
def test_the_least_and_the_greatest_value_are_tried_before_the_search(values, wrong):
    with pytest.raises(InputError, match=f"out.speed cannot be {wrong}"):
        missionplan.optimise(transit(), choose=[f"out.speed={values}"])


def test_validate_says_whether_a_mission_is_ready_to_be_optimised(mission):
    (found,) = missionplan.validate(mission)
    assert "optimise          ready; needs optimise.choose in the mission, or --choose" in map(str, found.table)
    (found,) = missionplan.validate(transit(requirements=[]))
    assert "optimise          needs requirements" in map(str, found.table)


def test_the_section_of_the_mission_says_what_may_be_chosen():
    section = {
        "aim": "duration",
        "choose": [
            {"key": "out.speed", "from": "1 m/s", "to": "2 m/s"},
            {"keys": ["out.d_max"], "choices": ["350 m", {"table": [["0 m", "100 m"], ["1600 m", "400 m"]]}]},
            {"key": "navigation.drift_compensation", "choices": ["none", "mean"]},
        ],
    }
    mission = transit(optimise=section)
    lattice = read_lattice(mission, [])
    assert lattice.shape == (41, 2, 2)
    assert dict(lattice[1]) == {"out.speed": "1 m/s", "out.d_max": "350 m", "navigation.drift_compensation": "mean"}
    assert lattice.number((40, 1, 1)) == len(lattice) - 1
    assert len(set(lattice.neighbours((0, 0, 0)))) == 3 + 3


@pytest.mark.parametrize(
    ("changes", "choose", "words"),
    [
        ({}, [], "what may be chosen"),
        ({"requirements": []}, CHOOSE, "what every choice must meet"),
        ({}, ["out.sped=1:2:1 m/s"], "did you mean out.speed"),
        ({}, [CHOOSE[0], CHOOSE[0]], "chosen twice"),
        ({"optimise": {"choose": [{"key": "out.spee", "from": "1 m/s", "to": "2 m/s"}]}}, [], "did you mean out.speed"),
    ],
)
def test_what_is_wrong_is_said_in_one_message(changes, choose, words):
    with pytest.raises(InputError, match=words):
        missionplan.optimise(transit(**changes), choose=choose)


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ({"choose": [{"key": "out.speed"}]}, "either from and to, or choices"),
        ({"choose": [{"from": "1 m/s", "to": "2 m/s"}]}, "either key or keys"),
        ({"choose": [{"key": "out.speed", "choices": ["1 m/s"], "step": "1 m/s"}]}, "needs from and to"),
        ({"aim": "cost"}, "'energy' or 'duration'"),
    ],
)
def test_a_section_that_is_wrong_is_refused_when_the_mission_is_read(section, words):
    with pytest.raises(InputError, match=words):
        transit(optimise=section)


def test_an_anchor_that_its_parts_make_is_a_choice_and_one_that_they_do_not_is_none():
    mission = missionplan.load(MISSIONS / "chesapeake.yaml")
    found = missionplan.optimise(mission, choose=["moor.anchor_wet_weight=1:12.6:5.8 N"], trials=64)
    assert found.feasible
    assert found.chosen == {"moor.anchor_wet_weight": "12.6 N"}
    with pytest.raises(InputError, match="no choice tried can be run: moor: the anchor cannot be built"):
        missionplan.optimise(mission, choose=["moor.anchor_wet_weight=1:1.2:0.2 N"], trials=64)
