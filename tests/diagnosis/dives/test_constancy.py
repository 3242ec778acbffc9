"""A cause that is claimed is the same in all dives, or the verdict says that it is not."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from missionplan import diagnose
from missionplan.diagnosis.dives.consistency import not_constant
from missionplan.diagnosis.inference.discrepancy import discrepancy
from missionplan.effects import CATALOGUE
from missionplan.report.diagnosis.page import answer

LINES = np.full(5, 5.0)
WEIGHTS = np.array([20.0, 30.0, 20.0, 30.0, 25.0])


def _found(model, *causes):
    (fit,) = model.fit_all([(causes, ())])
    return not_constant(model, fit)


def _late(measured, delays):
    """Five dives, each late by its own delay [s]."""
    return measured(weights=WEIGHTS, lines=LINES, late=np.array(delays))


@pytest.mark.parametrize("delay", [0.5, pytest.param(1.5, marks=pytest.mark.slow)])
def test_a_clock_that_is_late_in_all_dives_is_constant(measured, delay):
    assert _found(_late(measured, delay + np.array([0.05, -0.08, 0.1, -0.04, 0.0])), "clock-offset") == ()


def test_a_clock_that_is_late_in_some_dives_is_not(measured):
    assert _found(_late(measured, [0.0, 1.1, 0.05, 0.9, -0.05]), "clock-offset") == ("clock-offset",)


@pytest.mark.parametrize(
    ("cause", "parameters"),
    [
        pytest.param("drag-bias", {"fraction": 0.35}, marks=pytest.mark.slow),
        ("trapped-gas", {"lift": 1.5}),
        ("depth-scale", {"fraction": 0.08}),
    ],
)
def test_other_causes_are_the_same_in_all_dives(measured, cause, parameters):
    assert _found(measured(cause, weights=WEIGHTS, lines=LINES, **parameters), cause) == ()


def _jammed(measured, shares):
    """Five dives in which shares of the line stay on the spool: the vehicle starts early."""
    model = measured(weights=WEIGHTS, lines=LINES * (1.0 - np.array(shares)))
    logs = tuple(replace(log, line_length=5.0) for log in model.forward.logs)
    return replace(model, forward=replace(model.forward, logs=logs))


@pytest.mark.slow
def test_a_line_that_jams_in_some_dives_is_no_late_clock(measured, folder, descent_mission):
    logs = _jammed(measured, [0.2, 0.35, 0.3, 0.0, 0.5]).forward.logs
    runs = {
        log.name: {"anchor_wet_weight": f"{log.wet_weight} N", "line_length": "5 m", "depth": "60 m"} for log in logs
    }
    rows = pd.concat([pd.DataFrame({"run": log.name, "t_s": log.t, "depth_m": log.depth}) for log in logs])
    data = folder({"kind": "descent", "name": "dives", "noise": {"depth": "0.03 m"}, "runs": runs}, rows)
    found = diagnose(descent_mission, data, plan=False)
    assert found.causes == ("clock-offset",)
    assert found.diagnosis()["not_constant"] == ["clock-offset"]
    assert found.verdict == "partly-explained"
    assert "Clock offset is not the same in all dives." in re.sub("[\u00a0\u202f]", " ", answer(found))


def test_a_line_that_jams_where_nothing_is_claimed_is_a_discrepancy(measured):
    model = _jammed(measured, [0.0, 0.45, 0.3, 0.0, 0.6])
    (fit,) = model.fit_all([((), ())])
    left = discrepancy(model.residuals(fit))
    assert left.significant
    assert left.resembles == "a delay that differs from dive to dive"


def test_every_physical_effect_on_dives_has_a_strength_that_can_be_compared(measured):
    model = measured(weights=WEIGHTS, lines=LINES)
    strengths = {c.effect for c in model.coordinates if c.kind != "shape"}
    assert {name for name in model.candidates if CATALOGUE[name].tier == "physical"} <= strengths
