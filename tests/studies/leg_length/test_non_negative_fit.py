"""The fit of the spread of legs where scipy's active-set method stops with an error, as it does in early versions."""

import numpy as np
import pytest

from missionplan.studies.leg_length import analytic_transit as leg_spread


def stops(terms, values):
    raise ValueError("zero-size array to reduction operation minimum which has no identity")


@pytest.mark.parametrize("values", [[1.0, 2.0, 3.1], [3.0, 2.0, 1.0], [-1.0, -2.0, -3.0]])
def test_another_method_finds_the_same(values, monkeypatch):
    terms = np.array([[1.0, 1.0], [2.0, 1.0], [3.0, 1.0]])
    usual = leg_spread._non_negative(terms, np.array(values))
    monkeypatch.setattr("scipy.optimize.nnls", stops)
    assert leg_spread._non_negative(terms, np.array(values)) == pytest.approx(usual, abs=1e-6)
