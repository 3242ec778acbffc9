"""How the vehicle stands in the mean and in the worst current, and what would mend what is wrong."""

import copy
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.mission import Mission
from missionplan.phases.recorded_currents import SeriesCurrent
from missionplan.report.anchor import drawing
from missionplan.report.anchor.drawing import hold_section
from missionplan.report.page import Table, draw, drawing_by, style
from missionplan.report.simulation.page import answer
from missionplan.report.simulation.quantities import requirement_in_words
from missionplan.scenario.scenario import Scenario
from missionplan.studies.held_vehicle import _worst, held_vehicle
from missionplan.studies.simulation.simulate import simulate

MISSIONS = Path(__file__).parents[2] / "missions"


def stands(
    file="chesapeake.yaml",
    weight=11.8,
    *,
    recorded=None,
    requirements=(),
    moor=None,
    vehicle=None,
    slope=None,
    anchor=None,
):
    data = copy.deepcopy(dict(missionplan.load(MISSIONS / file).raw))
    data["requirements"] = list(requirements)
    data["vehicle"] |= vehicle or {}
    data["vehicle"]["anchor"] |= anchor or {}
    data["site"] |= {"slope": slope} if slope else {}
    section = next(phase["moor"] for phase in data["phases"] if "moor" in phase)
    section |= {"line_material": None, "line_diameter": "0 m", **(moor or {})}
    mission = Mission.from_data(data)
    means = Scenario.at_means(mission, recorded)
    return held_vehicle(means, means.moor(), weight)


def test_the_independent_estimate_for_both_missions():
    mean, worst = stands().states
    assert (mean.nose_altitude, mean.excursion) == pytest.approx((4.0, 2.9), abs=0.06)
    assert (worst.nose_altitude, worst.excursion) == pytest.approx((2.5, 4.4), abs=0.06)
    fast, _ = stands("anchor-design.yaml").states
    assert (fast.nose_altitude, fast.excursion) == pytest.approx((0.6, 5.0), abs=0.06)


@pytest.mark.parametrize("file", ["chesapeake.yaml", "anchor-design.yaml"])
def test_the_whole_of_line_and_vehicle_is_in_the_figure(file, monkeypatch):
    seen = []
    monkeypatch.setattr(drawing, "to_figure", lambda figure, *_, **__: seen.append(figure))
    held = stands(file)
    drawing.hold_figure(held)
    (axes,) = seen[0].axes
    (west, east), (low, high) = axes.get_xlim(), axes.get_ylim()
    for state in held.states:
        for x, y in (state.tail, *state.line, (-held.anchor_length, 0.0)):
            assert west <= x <= east
            assert low <= y <= high


def test_a_line_of_which_only_the_diameter_is_known_is_told_with_what_polyester_would_change():
    held = stands(moor={"line_diameter": "4 mm"})
    assert held.if_polyester == pytest.approx(1.36, abs=0.02)
    assert "of polyester, the nose would stand 1.36" in "".join(map(str, hold_section(held).blocks))
    assert held.summary()["line_weight_assumed"]
    heavy = stands(moor={"line_diameter": "4 mm", "line_material": "polyester"})
    assert heavy.if_polyester is None
    assert heavy.states[1].nose_altitude == pytest.approx(held.if_polyester, abs=1e-3)


def test_the_worst_current_is_the_design_current():
    mean, worst = stands("anchor-design.yaml").states
    assert (mean.speed, worst.speed) == pytest.approx((0.9, 1.13))
    assert worst.friction_needed > mean.friction_needed
    assert stands().states[1].speed == pytest.approx(0.4 * 0.514444, rel=1e-5)  # mean + 2 sd of the lower layer


def test_the_least_weight_needs_the_holding_factor_that_there_is():
    state = stands("anchor-design.yaml").states[0]
    assert state.least_weight > 11.8
    heavier = stands("anchor-design.yaml", state.least_weight)
    # an anchor built for it is longer, and so has more drag
    assert heavier.friction < heavier.states[0].friction_needed < 1.1 * heavier.friction


def test_an_anchor_of_the_holding_factor_that_it_needs_just_holds():
    for number, state in enumerate(stands().states):
        same = stands(anchor={"holding_factor": state.friction_needed}).states[number]
        assert same.friction_needed == pytest.approx(state.friction_needed)
        assert same.holding_margin == pytest.approx(0.0, abs=1e-6)


def test_the_line_ends_at_the_nose_and_is_as_long_as_it_is():
    held = stands(moor={"line_diameter": "4 mm"})
    for state in held.states:
        assert state.line[0] == pytest.approx([0.0, 0.0], abs=1e-9)
        assert state.line[-1] == pytest.approx([state.excursion, state.nose_altitude], abs=1e-4)
        assert np.hypot(*np.diff(state.line, axis=0).T).sum() == pytest.approx(5.0, rel=1e-4)  # chords
        assert np.hypot(*(np.array(state.tail) - state.line[-1])) == pytest.approx(held.length, abs=1e-3)


def test_an_anchor_that_drags_is_mended_by_a_heavier_one_and_nothing_else():
    (words,) = stands("anchor-design.yaml", 11.7).remedies
    assert words.startswith("In the worst current the anchor drags. It would be mended by an anchor of ")
    needed = float(re.search(r"an anchor of ([\d.]+) N wet instead of 11.7 N wet", words)[1])
    mended, short = (stands("anchor-design.yaml", factor * needed) for factor in (1.005, 0.98))
    assert mended.states[1].holding_margin > 0.0 > short.states[1].holding_margin
    assert mended.remedies == ()
    assert "No net buoyancy and no line" in words


def test_a_nose_too_low_is_mended_by_buoyancy_or_a_longer_line():
    bound = {"quantity": "moor.nose_altitude", "at_least": "3 m", "probability": 0.9}
    (words,) = stands(requirements=[bound]).remedies
    needed = float(re.search(r"net buoyancy of ([\d.]+) N", words)[1])
    changed = stands(requirements=[bound], vehicle={"net_buoyancy": f"{1.01 * needed} N"})
    assert changed.remedies == ()
    assert changed.states[1].nose_altitude == pytest.approx(3.0, abs=0.05)
    assert re.search(r"a line of 6\.\d+ m instead of 5 m", words)


def test_a_watch_circle_too_wide_is_mended_by_a_shorter_line():
    bound = {"quantity": "moor.excursion", "at_most": "3 m", "probability": 0.9}
    (words,) = stands(requirements=[bound]).remedies
    assert re.search(r"a line of 3\.4\d m instead of 5 m", words)


def test_a_record_gives_its_fastest_moment_in_the_hold():
    hours = np.arange(0.0, 4.0) * 3600.0
    east = np.array([0.05, 0.3, 0.05, 0.05])[:, None] * np.ones(2)
    held = stands(
        recorded=SeriesCurrent(hours, np.array([0.0, 12.0]), east, 0.0 * east),
        moor={"hold": "2 h", "design_current": "1 m/s"},
    )
    assert [state.current for state in held.states] == ["current at touchdown", "fastest current of the hold"]
    assert held.states[1].speed == pytest.approx(0.3, abs=0.02)


def test_uphill_is_drawn_and_measured():
    held = stands(slope={"angle": "10 deg", "toward": "240 deg"})  # the current flows toward 60 deg
    state = held.states[0]
    assert state.uphill == pytest.approx(np.tan(np.radians(10.0)))
    assert state.nose_altitude == pytest.approx(state.line[-1, 1] - state.excursion * state.uphill)
    assert np.hypot(*(np.array(state.tail) - state.line[-1])) == pytest.approx(held.length, abs=1e-3)
    assert state.tail_altitude == pytest.approx(state.tail[1] - state.tail[0] * state.uphill)
    with style(), drawing_by(draw):
        assert hold_section(held).blocks


def test_a_current_that_stays_as_it_is_is_told_once():
    held = stands()
    touchdown, worst = held.states
    with style(), drawing_by(draw):
        figure, table, *_ = hold_section(replace(held, states=(replace(touchdown, speed=worst.speed), worst))).blocks
        _, both, *_ = hold_section(held).blocks
    assert list(table.columns) == ["", worst.current]
    assert touchdown.current not in figure.svg
    assert list(both.columns) == ["", touchdown.current, worst.current]


def test_the_report_says_what_it_assumed():
    with style():
        given = replace(stands(), friction_assumed=False, centres_assumed=False)
        bare, told = (
            [each.caption for each in hold_section(held).blocks if isinstance(each, Table)]
            for held in (stands(), given)
        )
    assert (
        "a holding factor of 0.4 (assumed: 0.2 on clay to 0.6 on sand), the net buoyancy at mid-length (assumed"
        in bare[0]
    )
    assert "assumed" not in told[0]


def test_simulate_has_it_in_summary_and_report():
    outcome = simulate(missionplan.load(MISSIONS / "chesapeake.yaml"), trials=20, sheet=False)
    (hold,) = outcome.summary()["holds"]
    assert hold["phase"] == "moor"
    assert [state["current"] for state in hold["states"]] == ["mean current", "worst current"]


def test_an_anchor_that_drags_is_told_where_it_does_not_count():
    silent = simulate(missionplan.load(MISSIONS / "anchor-design.yaml"), trials=300, sheet=False)
    words = answer(silent).replace("\u00a0", " ")
    dragged = 1.0 - silent.phases[0].events["anchor_holds"].value
    assert 0.6 < dragged < 0.9
    assert f"with an assumed holding factor of 0.4 the anchor (moor) drags in {100 * dragged:.0f} % of the" in words
    assert "drags" not in answer(simulate(missionplan.load(MISSIONS / "chesapeake.yaml"), trials=50, sheet=False))


def test_requirements_may_name_what_the_hold_gives():
    data = copy.deepcopy(dict(missionplan.load(MISSIONS / "chesapeake.yaml").raw))
    wanted = {
        "moor.nose_altitude": {"at_least": "2 m"},
        "moor.excursion": {"at_most": "4.5 m"},
        "moor.line_tension": {"at_most": "2 N"},
        "moor.holding_margin": {"at_least": 0.5},
        "moor.touchdown_speed": {"at_most": "2 m/s"},
        "moor.anchor_holds": {},
    }
    data["requirements"] = [{"quantity": name, **bound, "probability": 0.9} for name, bound in wanted.items()]
    outcome = simulate(Mission.from_data(data), trials=200, sheet=False)
    assert outcome.requirements_met
    assert "at most 2\u00a0N" in requirement_in_words(outcome, outcome.requirements[2])


def test_the_worst_current_flows_the_way_that_each_layer_does():
    """Mean and two deviations of each; one that flows against its direction does so in the worst case too."""
    layers = [{"down_to": "20 ft", "speed": {"mean": "-0.3 m/s", "sd": "0.05 m/s"}, "toward": "90 deg"},
              {"down_to": "40 ft", "speed": {"mean": "0.2 m/s", "sd": "0.05 m/s"}, "toward": "150 deg"}]  # fmt: skip
    data = copy.deepcopy(dict(missionplan.load(MISSIONS / "chesapeake.yaml").raw))
    means = Scenario.at_means(Mission.from_data({**data, "site": data["site"] | {"current": layers}}))
    found = _worst(means, means.moor(), means.current)
    assert np.ravel(found.east) == pytest.approx([-0.4, 0.3 * np.sin(np.radians(150.0))])
    assert np.ravel(found.north) == pytest.approx([0.0, 0.3 * np.cos(np.radians(150.0))], abs=1e-12)
