"""What the plan of a vehicle expects of its transits, from the tracks of some trials."""

import numpy as np
import pytest

from missionplan.studies.planned_phases import _last_drift

START, NOTHING = [0.0, 0.0], [np.nan, np.nan]


def track(*trials):
    """Points of trials: start, where each leg surfaces and dives again, then nothing."""
    most = max(map(len, trials))
    return np.array([[*each, *[NOTHING] * (most - len(each))] for each in trials]).transpose(2, 1, 0)


def test_the_last_drift_at_the_surface_is_that_after_each_trials_last_leg():
    one_leg = [START, [100.0, 0.0], [101.0, 2.0]]
    two_legs = [START, [90.0, 0.0], [95.0, 9.0], [180.0, 9.0], [183.0, 13.0]]
    assert _last_drift(track(one_leg)) == pytest.approx([1.0, 2.0])
    assert _last_drift(track(two_legs)) == pytest.approx([3.0, 4.0])
    assert _last_drift(track(one_leg, two_legs)) == pytest.approx([2.0, 3.0])


def test_without_a_leg_there_is_no_drift():
    assert _last_drift(None).tolist() == [0.0, 0.0]
    assert _last_drift(track([START])).tolist() == [0.0, 0.0]
    there, far = [START], [START, [100.0, 0.0], [101.0, 2.0]]
    assert _last_drift(track(there, far)) == pytest.approx([1.0, 2.0]), "only trials that have made a leg count"
