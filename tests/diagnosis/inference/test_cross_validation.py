"""Two models' held-out scores side by side."""

import math

import numpy as np
import pytest

from missionplan.diagnosis.inference.model import HeldOutScore, compare_held_out


def scores(logs, squared=1.0, inside=9, count=10):
    return [HeldOutScore(f"dive-{k}", log, squared, inside, count) for k, log in enumerate(logs)]


def test_the_standard_error_is_that_of_a_sum():
    rng = np.random.default_rng(2)
    sums, errors = [], []
    for _ in range(2000):
        gain = compare_held_out(scores(np.zeros(9)), scores(rng.normal(0.4, 1.5, 9))).gain
        sums.append(gain.log_score_gain)
        errors.append(gain.paired_se)
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(np.std(sums), rel=0.06)


def test_gain_counts_groups_and_values():
    gain = compare_held_out(scores([0.0, 1.0, 2.0], 4.0, 5), scores([1.0, 0.5, 4.0], 1.0, 8)).gain
    assert gain.log_score_gain == pytest.approx(2.5)
    assert (gain.groups_improved, gain.groups) == (2, 3)
    assert gain.rmse_base == pytest.approx(math.sqrt(0.4))
    assert gain.rmse_extended == pytest.approx(math.sqrt(0.1))
    assert (gain.coverage_90_base, gain.coverage_90_extended) == (0.5, 0.8)
