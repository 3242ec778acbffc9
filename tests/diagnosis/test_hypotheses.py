"""What a record tells of levels is read under explanations that hold, or add to one that does."""

from types import SimpleNamespace

import pytest

from missionplan.diagnosis import extended_mission as hypotheses
from missionplan.diagnosis.extended_mission import seen_after

TOLD = {("drag",): {"drag": 0.3}, ("scale",): {"scale": -0.135}, ("drag", "scale"): {"drag": 0.29, "scale": 0.01}}


def believed(**probabilities):
    found = [SimpleNamespace(causes=tuple(name.split("_")), probability=p) for name, p in probabilities.items()]
    return sorted(found, key=lambda each: -each.probability)


@pytest.fixture(autouse=True)
def told(monkeypatch):
    monkeypatch.setattr(
        hypotheses, "_seen_under", lambda each, record: {key: (value,) for key, value in TOLD[each.causes].items()}
    )


def test_a_level_is_not_taken_from_an_explanation_that_lacks_what_the_record_shows():
    """Without the drag the scale takes its place: −0.135 of a scale that is not off."""
    assert seen_after(believed(drag=0.97, scale=0.02, drag_scale=0.01), "record") == (0.3, 0.01)


def test_a_level_is_taken_from_any_explanation_that_may_hold():
    assert seen_after(believed(drag=0.6, scale=0.39, drag_scale=0.01), "record") == (0.3, -0.135)
