"""Trials that meet a limit of the world fail with its reason, and what did not happen is missing."""

import pytest
from simulate_missions import chesapeake

from missionplan.report.simulation.page import answer
from missionplan.studies.simulation.simulate import simulate

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")


def lost(found):
    return {step.step: step.lost.value for step in found.attrition if step.lost.value}


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (
            {"phases.1.moor.line_length": {"choices": ["5 m", "11.5 m"]}},
            "moor: line and vehicle longer than the water is deep",
        ),
        ({"phases.0.transit.depth": {"choices": ["2 m", "13 m"]}}, "ingress: aground"),
        (
            {
                "phases.1.moor.anchor_wet_weight": {"choices": ["11.8 N", "0.5 N"]},
                "vehicle.anchor.flooded_mass": "2.5 kg",
            },
            "moor: anchor too light to sink the vehicle",
        ),
    ],
)
def test_half_of_the_trials_meet_a_limit(tmp_path, changes, reason):
    found = simulate(chesapeake(tmp_path, changes), trials=400, sheet=False)
    assert lost(found)[reason] == pytest.approx(0.5, abs=0.1)
    good = round(400 * (1.0 - sum(lost(found).values())))
    assert found.phases[1].quantities["descent_time_s"].count == good
    assert found.phases[1].quantities["terminal_velocity_m_s"].count == good
    assert "works" not in answer(found) or "% of the time" in answer(found)


def test_a_current_faster_than_the_vehicle_is_a_reason_and_its_share_is_said(tmp_path):
    layers = [
        {"down_to": "20 ft", "speed": {"choices": ["0.2 m/s", "1.8 m/s"]}, "toward": "0 deg"},
        {"down_to": "40 ft", "speed": "0.1 m/s", "toward": "0 deg"},
    ]
    found = simulate(chesapeake(tmp_path, {"site.current": layers}), trials=400, sheet=False)
    share = found.limits["current_faster"].value
    assert share == pytest.approx(0.5, abs=0.1)
    assert lost(found)["ingress: current faster than the vehicle"] == pytest.approx(share)
    assert "of the trials the current is faster than the vehicle" in answer(found)
