"""Further scenarios: what they hold, and a study that can be continued."""

import numpy as np
import pytest

from .. import further
from ..tool import Outcome
from . import random_records
from .draw import STRONG


def test_a_strong_effect_is_several_times_the_usual_size():
    case = further.draw(5, "transit", "strong")
    (name,) = case.truth
    low, high = STRONG[name]
    assert low <= case.notes["sizes"][name] <= high
    assert case.strength > 40.0


def test_narrow_headings_are_within_ten_degrees():
    case = further.draw(3, "transit", "narrow")
    places = np.array([row[3:9] for row in case.rows if "" not in row], dtype=float)
    if "lat_start" in case.header:
        latitude = np.radians(places[:, 0])
        way = np.stack([(places[:, 3] - places[:, 1]) * np.cos(latitude), places[:, 2] - places[:, 0]])
    else:
        way = (places[:, 2:4] - places[:, 0:2]).T
    heading = np.arctan2(*way)
    about = np.angle(np.exp(1j * heading).mean())
    assert np.abs(np.angle(np.exp(1j * (heading - about)))).max() < np.radians(21.0)


@pytest.mark.parametrize(("scenario", "sign"), [("given", 1.0), ("changed", -1.0)])
def test_a_mission_knows_its_effect(scenario, sign):
    case = further.draw(8, "transit", scenario)
    ((name, entry),) = case.mission["effects"][0].items()
    for key, known in entry.items():
        mean, sd = (float(str(known[part]).split()[0]) for part in ("mean", "sd"))
        assert abs(mean - sign * case.parameters[f"{name}.{key}"]) < 4.0 * sd
    assert case.truth == (() if scenario == "given" else (name,))


@pytest.mark.slow
def test_records_have_the_strength_of_their_own_law():
    """Over seeds, the law that generated them beats the best without the effect, and loses where there is none."""
    with_walk = [random_records.gathering(seed).strength for seed in range(4)]
    without = [random_records.gathering(seed, walking=False).strength for seed in range(4)]
    assert np.mean(with_walk) > 2.0 > 0.5 > np.max(without)
    assert random_records.wandering(1).strength > random_records.wandering(1, inertial=False).strength


def test_a_line_holds_what_is_scored():
    case = further.draw(2, "transit", "gathering")
    outcome = Outcome(case, {"verdict": "adequate", "causes": [], "credible_set": [[]], "ranking": []}, 1.0)
    again = further.outcome_of(further.line_of(outcome))
    assert (again.case.truth, again.case.strength) == (case.truth, case.strength)
    assert again.diagnosis == outcome.diagnosis


def test_cases_that_are_known_are_not_run_again(tmp_path, capsys):
    lines = tmp_path / "lines.jsonl"
    known = [
        Outcome(further.draw(*argument), {"verdict": "adequate", "causes": []}, 1.0)
        for argument in further.plan(2, 7, "further")
    ]
    lines.write_text("".join(further.line_of(outcome) + "\n" for outcome in known))
    before = lines.read_text()
    assert further.main(["--lines", str(lines), "--cases", "2", "--seed", "7"]) == 0
    assert lines.read_text() == before
    assert "given: adequate 1 of 1" in capsys.readouterr().out
