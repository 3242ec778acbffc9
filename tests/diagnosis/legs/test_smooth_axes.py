"""Velocity errors over a place and in time: of flows without sources, on one side of a line, that come and go."""

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
    waves_of_water,
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
    _, words, (bearing, line), columns = across_lines(bound.data, bound.leg, np.eye(2))[0]
    along = np.array([np.sin(bearing), np.cos(bearing)])
    least, most = np.sort([along @ bound.data.start, along @ bound.data.dead_reckoned], axis=0)
    east, north = columns[::2, 0], columns[1::2, 1]
    assert words == "a velocity that changes across a line"
    assert np.all(east[most < line] == 0.0)
    assert np.ptp(east[least > line]) == pytest.approx(0.0, abs=1e-12)
    assert np.all(east[(least < line) & (most > line)] < east.max())
    assert np.mean(east**2 + north**2) == pytest.approx(2.0)


STEPS = (np.arange(400) + 0.5) / 400.0
"""Shares of a leg that is done, at which a flow is added up."""


def left_of(columns, flow):
    """What columns leave of the mean over each leg of a flow at each step, shape (2, n, s): its share."""
    own = flow.mean(axis=2).T.ravel()
    return np.linalg.norm(own - columns @ np.linalg.lstsq(columns, own)[0]) / np.linalg.norm(own)


def test_a_current_that_turns_is_a_sum_of_two_columns_and_the_opposite_turn_is_not(bound):
    data = bound.data
    turning = {
        each.shape: each.columns for each in waves_of_water(data, bound.leg, np.eye(2)) if each.words.endswith("period")
    }
    turns = 3.0
    t = data.t_start[:, None] + data.under_way[:, None] * STEPS
    angle = 2.0 * np.pi * turns * t / np.ptp(data.middle) + 0.7
    flow = np.stack([np.sin(angle), np.cos(angle)])  # clockwise from north
    assert left_of(turning[turns, 0], flow) < 1e-4
    assert left_of(turning[turns, 1], flow) > 0.5
    assert left_of(turning[turns, 2], flow) < 1e-4
    assert left_of(turning[turns, 2], np.stack([np.sin(angle), 0.3 * np.sin(angle)])) < 1e-4
    assert all(np.mean(2.0 * columns**2) == pytest.approx(1.0) for columns in turning.values())


def test_what_comes_and_goes_for_a_while_does_so_about_a_moment(bound):
    data, span = bound.data, np.ptp(bound.data.middle)
    found = [each for each in waves_of_water(data, bound.leg, np.eye(2)) if each.words.endswith("while")]
    for _, _, (middle, _), columns in found:
        power = (columns**2).sum(axis=1).reshape(-1, 2).sum(axis=1)
        assert power[np.abs(data.middle - middle) > 0.2 * span].sum() < 1e-3 * power.sum()
    assert len({each.shape for each in found}) == len(found)


def test_a_stream_that_winds_goes_across_its_waves(bound):
    data = bound.data
    extent = np.ptp(0.5 * (data.start + data.dead_reckoned), axis=1).max()
    columns = {each.shape: each.columns for each in waves_of_water(data, bound.leg, np.eye(2))}[
        -1.5, 0.5
    ]  # the waves of (1.5, −0.5)
    place = data.start[:, :, None] + (data.dead_reckoned - data.start)[:, :, None] * STEPS
    waves = 2.0 * np.pi * (1.5 * place[0] - 0.5 * place[1]) / extent
    assert left_of(columns, np.array([0.5, 1.5])[:, None, None] * np.cos(waves + 0.4)) < 1e-4
    assert left_of(columns, np.array([1.5, -0.5])[:, None, None] * np.cos(waves + 0.4)) > 0.3


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
