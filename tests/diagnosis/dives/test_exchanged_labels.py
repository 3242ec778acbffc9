"""Labels of weights that were exchanged in the log book: found where they were, and nowhere else."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from missionplan import diagnose
from missionplan.diagnosis.dives import consistency
from missionplan.diagnosis.dives.consistency import exchanged_labels
from missionplan.diagnosis.inference.selection import FURTHER
from missionplan.report.diagnosis.page import answer

WEIGHTS = np.array([20.0, 30.0, 20.0, 30.0, 25.0])


def _relabelled(model, order):
    """The same dives, with the labels of others."""
    logs = model.forward.logs
    relabelled = tuple(replace(log, wet_weight=logs[other].wet_weight) for log, other in zip(logs, order, strict=True))
    return replace(model, forward=replace(model.forward, logs=relabelled))


def _found(model, *causes):
    """The likeliest exchange, if it says clearly more of the dives than the best cause; else None."""
    base, *best = model.fit_all([((), ()), *((cause, ()) for cause in causes)])
    found = exchanged_labels(model, base)
    best = max(fit.log_evidence for fit in (base, *best)) - base.log_evidence
    return found if found is not None and found.log_gain > best + 3.0 else None


@pytest.fixture
def five_dives(measured):
    return measured(weights=WEIGHTS, lines=np.full(5, 5.0))


@pytest.mark.parametrize("order", [pytest.param((1, 0, 2, 3, 4), marks=pytest.mark.slow), (1, 0, 3, 2, 4)])
def test_exchanged_labels_are_found(five_dives, order):
    """Of two dives, and of every other dive, which no trend and no outlying dive shows."""
    found = _found(_relabelled(five_dives, order), ("drag-bias",), ("vertical-current",))
    assert found.dives == tuple(f"dive-{k}" for k, other in enumerate(order) if k != other)
    truth = {f"dive-{k}": WEIGHTS[k] for k in range(5)}
    assert found.weights == pytest.approx([truth[name] for name in found.dives])
    assert "Check the log book" in str(found)


def test_dives_of_right_labels_keep_them(five_dives, measured):
    assert _found(five_dives) is None
    dragged = measured("drag-bias", weights=WEIGHTS, lines=np.full(5, 5.0), fraction=0.35)
    assert _found(dragged, ("drag-bias",)) is None


def test_dives_of_one_weight_have_nothing_to_exchange(measured):
    assert _found(measured(weights=np.full(4, 20.0))) is None


@pytest.mark.slow
def test_the_diagnosis_says_so_first(five_dives, folder, descent_mission):
    logs = _relabelled(five_dives, (1, 0, 3, 2, 4)).forward.logs
    runs = {
        log.name: {"anchor_wet_weight": f"{log.wet_weight} N", "line_length": "5 m", "depth": "60 m"} for log in logs
    }
    rows = pd.concat([pd.DataFrame({"run": log.name, "t_s": log.t, "depth_m": log.depth}) for log in logs])
    data = folder({"kind": "descent", "name": "dives", "noise": {"depth": "0.03 m"}, "runs": runs}, rows)
    found = diagnose(descent_mission, data, plan=False)
    assert found.verdict in ("partly-explained", "unexplained")
    assert found.none_of_these > 0.95
    assert found.diagnosis()["suspect_labels"] == found.suspect_labels
    told = answer(found)
    assert told.startswith("The labels of the weights look exchanged between dive-0, dive-1, dive-2, dive-3: with 20 N")


def test_exchanges_share_the_probability_of_their_step_and_a_second_costs_as_a_cause(monkeypatch):
    """Of five dives: six pairs and both weights at once, 50 nats; then five pairs and both, 80 nats, none going back."""
    evidence = {(1, 0, 0, 1, 0): 50.0, (1, 0, 1, 0, 0): 80.0}
    monkeypatch.setattr(consistency, "_labelled", lambda *_: [])
    monkeypatch.setattr(
        consistency,
        "_changed",
        lambda whole, likelihoods, labels, own: SimpleNamespace(
            log_joint=lambda _: np.array([evidence.get(labels, -1e3)])
        ),
    )
    logs = [SimpleNamespace(name=f"dive-{k}", wet_weight=20.0 + 10.0 * (k % 2)) for k in range(5)]
    state = SimpleNamespace(likelihood=None, prior_sd=None)
    found = exchanged_labels(
        SimpleNamespace(forward=SimpleNamespace(logs=logs)), SimpleNamespace(state=state, log_evidence=0.0)
    )
    assert found.dives == ("dive-0", "dive-1", "dive-2", "dive-3")
    assert found.log_gain == pytest.approx(80.0 - math.log(7.0) - math.log(6.0) - FURTHER)
