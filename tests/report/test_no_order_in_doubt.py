"""No headline gives an order while the truth is in doubt, assumed or two-fold: every command, over such missions."""

import json
import re
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import yaml

import missionplan
from missionplan.mission import Mission
from missionplan.report.render import terminal_view
from missionplan.results import Result
from missionplan.studies.leg_length import optimise_legs
from missionplan.studies.leg_length.analytic_transit import PolicyFamily

MISSIONS = Path(__file__).parents[2] / "missions"
VERBS = (
    "accept|add|build|calibrate|choose|correct|drop|enter|go|keep|lengthen|let|plan|put|replace|sail|set|shorten|size|"
    "start|swing|take|trim|use|write"
)
ORDER = re.compile(rf"(?:^|[.:;,] (?:and |or )?)(?:{VERBS})\b(?! (?:nothing|no)\b)", re.IGNORECASE)
"""A sentence or clause that begins with the plain form of a verb; ``first …`` asks for what would end the doubt."""

TRANSIT = {
    "name": "Across a bay",
    "site": {"origin": {"latitude": "37 deg", "longitude": "-76 deg"}, "depth": "30 m"},
    "navigation": {"velocity_error": {"sigma": "0.02 m/s"}, "surfacing_time": "90 s", "fix_error": "3 m"},
    "phases": [
        {"transit": {"name": "out", "from": ["0 m", "0 m"], "to": ["0 m", "3 km"], "speed": "1.2 m/s",
                     "d_max": "1 km", "arrival_radius": "150 m"}}
    ],
    "requirements": [{"quantity": "total.duration", "at_most": "70 min", "probability": 0.9}],
    "optimise": {"choose": [{"key": "out.d_max", "from": "800 m", "to": "1600 m", "step": "800 m"}]},
    "sweep": {"d_max": {"from": 0.25, "to": 1.0, "points": 4, "of": "distance"}},
    "monte_carlo": {"trials": 200, "seed": 1},
}  # fmt: skip
BIASED, CARRIED = {"compass-bias": {"angle": "0.2 deg"}}, {"mean-current": {"east": "0.35 m/s"}}
EXACT = [{"down_to": "30 m", "speed": "0 m/s", "toward": "0 deg"}]
WAYS = {
    "two-fold": {"effects": [{"one-of": [{"probability": 0.5, "effects": [each]} for each in (BIASED, CARRIED)]}]},
    "in doubt": {"effects": [{"one-of": [{"probability": 0.5, "effects": [CARRIED]}]}]},
    "assumed": {
        "site": {**TRANSIT["site"], "current": EXACT},
        "requirements": [{**TRANSIT["requirements"][0], "at_most": "44.5 min"}],
    },
}


def headline(result: Result) -> str:
    """What the terminal, the page, the summary and Python give as the answer."""
    words = terminal_view(result).sentence.replace("\u00a0", " ")
    assert result.decision_for_crew().do.replace("\u00a0", " ").split() == words.split()
    return words


COMMANDS = {
    "simulate": lambda mission: missionplan.simulate(mission, assumptions=True),
    "sweep-dmax": missionplan.sweep_dmax,
    "plan-legs": missionplan.plan_legs,
    "optimise": missionplan.optimise,
    "explore": lambda mission: missionplan.explore(mission, ["out.speed=1.0:1.4:0.4m/s"]),
    "compare": lambda mission: missionplan.compare(mission, mission.with_(speed="1.4 m/s")),
    "simulate --rare": lambda mission: missionplan.find_rare_failure(mission, trials=8192),
}


@pytest.mark.parametrize(
    ("command", "way"),
    [
        pytest.param(*pair, marks=pytest.mark.slow if pair == ("plan-legs", "two-fold") else ())
        for pair in product(COMMANDS, WAYS)
    ],
)
def test_no_headline_orders_while_the_truth_is_not_known(command, way, monkeypatch):
    monkeypatch.setattr(optimise_legs, "MEAN_FAMILY", PolicyFamily((1.0,), ()))
    found = COMMANDS[command](Mission.from_data({**TRANSIT, **WAYS[way]}))
    words = headline(found)
    assert not ORDER.search(words), words
    assert way != "assumed" or terminal_view(found).verdict != "good"


def test_the_same_command_orders_where_nothing_is_in_doubt(monkeypatch):
    """So that the test above can fail: the words that it looks for are those of a mission that is known."""
    current = [{"down_to": "30 m", "speed": {"mean": "0 m/s", "sd": "0.01 m/s"}, "toward": "90 deg"}]
    site = {**TRANSIT["site"], "current": current, "wind": {"speed": "0 m/s", "from": "0 deg"}}
    known = Mission.from_data({**TRANSIT, "site": site})
    monkeypatch.setattr(optimise_legs, "MEAN_FAMILY", PolicyFamily((1.0,), ()))
    assert ORDER.search(headline(missionplan.sweep_dmax(known)))
    assert ORDER.search(headline(missionplan.plan_legs(known)))


def test_an_anchor_whose_holding_is_assumed_or_whose_dive_is_in_doubt_is_no_order(sized):
    mission = missionplan.load(MISSIONS / "anchor-design.yaml").with_(trials=50)
    doubt = [{"probability": 0.5, "effects": [{"stratification": {"lift": "2 N", "depth": "8 m", "thickness": "2 m"}}]}]
    doubtful = missionplan.size_anchor(mission.with_({"effects": [{"one-of": doubt}]}))
    for found in (sized.result, replace(sized.result, probable=None), doubtful):
        words = headline(found)
        assert not ORDER.search(words), words
        assert terminal_view(found).verdict != "good"


def found_once(folder):
    """A report of `diagnose` whose cause is as likely as not."""
    (folder / "first").mkdir()
    numbers = {"value": 0.05, "sd": 0.01, "low": 0.03, "high": 0.07, "unit": "rad"}
    held = [{"causes": [each], "probability": 0.5} for each in ("compass-bias", "mean-current")]
    parameters = [{"effect": "compass-bias", "name": "angle", **numbers}]
    known = {"mission": "made", "dataset": "first", "created_utc": "2026-05-01T00:00:00+00:00", "confirmed": []}
    found = {"causes": ["compass-bias"], "ranking": [{"parameters": parameters}], "explanations": held}
    (folder / "first" / "summary.json").write_text(json.dumps({**known, **found, "changed": False}))
    (folder / "first" / "diagnosis.json").write_text("{}")
    (folder / "first" / "mission.yaml").write_text("name: made\n")
    return missionplan.history(folder)


def tide_of_two_days(folder):
    """A record that tells no M2 from an S2."""
    seconds = np.arange(0.0, 2 * 86400.0, 1800.0)
    east, north = 0.3 * np.cos(2.0 * np.pi * seconds / 44714.0), np.random.default_rng(1).normal(0.0, 0.1, seconds.size)
    rows = "".join(f"{t},8,{u},{v}\n" for t, u, v in zip(seconds, east, north, strict=True))
    (folder / "record.csv").write_text("t_s,depth_m,east_m_s,north_m_s\n" + rows)
    return missionplan.tide(folder / "record.csv", latitude=0.65, start="2026-04-01T00:00Z")


def four_tows(folder):
    """Tows whose scatter is as large as their drag."""
    data = {"file": "rows.csv", "kind": "drag", "reference_area": "0.1 m^2", "reference_length": "0.3 m"}
    (folder / "dataset.yaml").write_text(yaml.safe_dump(data))
    rows = ((0.4, 30.0), (0.7, 12.0), (1.0, 160.0), (1.3, 60.0))
    (folder / "rows.csv").write_text("speed_m_s,force_n\n" + "".join(f"{u},{force}\n" for u, force in rows))
    return missionplan.identify(folder)


@pytest.mark.parametrize("learn", [found_once, tide_of_two_days, four_tows])
def test_no_headline_orders_of_data_that_do_not_tell(learn, tmp_path):
    words = headline(learn(tmp_path))
    assert not ORDER.search(words), words
