"""Velocity errors over a place: of a flow that has no sources, and on one side of a line."""

import numpy as np
import pytest

from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.legs.kind import transit_model
from missionplan.diagnosis.legs.smooth_axes import (
    FLOW_LENGTH,
    across_lines,
    along_one_line,
    flow_columns,
    transit_axes,
)
from missionplan.diagnosis.legs.terms import terms_of


@pytest.fixture
def bound(folder, transit_mission, legs):
    kind = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}
    return transit_model(read_transit(folder(kind, legs()), transit_mission), transit_mission, seed=1)


def test_a_flow_has_the_covariance_of_the_curl_of_a_normal_function(bound):
    """Of ψ with the covariance exp(−r²/2ℓ²), that of −ℓ ∂ψ/∂y and ℓ ∂ψ/∂x is (1 − dy²/ℓ², 1 − dx²/ℓ²) exp(…)."""
    columns = flow_columns(bound.data, np.eye(2))
    found = columns @ columns.T
    middle = 0.5 * (bound.data.start + bound.data.dead_reckoned)
    d = (middle[:, :, None] - middle[:, None, :]) / np.ptp(middle, axis=1).max() / FLOW_LENGTH
    kernel = np.exp(-0.5 * np.sum(d**2, axis=0))
    np.testing.assert_allclose(found[::2, ::2], (1.0 - d[1] ** 2) * kernel, atol=0.03)
    np.testing.assert_allclose(found[1::2, 1::2], (1.0 - d[0] ** 2) * kernel, atol=0.03)
    np.testing.assert_allclose(found[::2, 1::2], d[0] * d[1] * kernel, atol=0.03)


def test_beyond_a_line_are_the_legs_that_lie_there(bound):
    words, (bearing, line), columns = across_lines(bound.data, bound.leg, np.eye(2))[0]
    along = np.array([np.sin(bearing), np.cos(bearing)])
    least, most = np.sort([along @ bound.data.start, along @ bound.data.dead_reckoned], axis=0)
    east, north = columns[::2, 0], columns[1::2, 1]
    assert words == "a velocity that changes across a line"
    assert np.all(east[most < line] == 0.0)
    assert np.ptp(east[least > line]) == pytest.approx(0.0, abs=1e-12)
    assert np.all(east[(least < line) & (most > line)] < east.max())
    assert np.mean(east**2 + north**2) == pytest.approx(2.0)


@pytest.mark.parametrize("name", ["time", "place"])
def test_along_one_line_are_all_directions_alike(bound, name):
    """What is the same along each has half the covariance of two components; east and north err by one function."""
    axes = transit_axes(bound.data, bound.leg, np.eye(2))
    whole = next(axis for axis in axes if axis.name == name)
    lines = along_one_line(whole)
    covariances = [columns @ columns.T for columns in (axis.smooth_columns(0.4) for axis in (whole, *lines))]
    np.testing.assert_allclose(np.mean(covariances[1:], axis=0), 0.5 * covariances[0], atol=1e-9)
    aslant = lines[1].smooth_columns(0.4)
    np.testing.assert_allclose(aslant[::2], aslant[1::2], atol=1e-12)
    assert {axis.description for axis in lines} == {f"a velocity along one line that changes with {name}"}


def test_shares_of_what_has_no_name_add_up(bound):
    """Each family, whatever it tries, has as much as any other."""
    shares: dict[tuple[str, str], float] = {}
    for term in terms_of(bound):
        if term.is_neutral:
            key = term.axis, term.description
            shares[key] = shares.get(key, 0.0) + np.exp(term.log_share)
    assert sum(shares.values()) == pytest.approx(0.05)
    assert max(shares.values()) == pytest.approx(min(shares.values()))
