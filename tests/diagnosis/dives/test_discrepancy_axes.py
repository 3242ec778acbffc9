"""Responses of dives to an unknown force, and which kind of discrepancy a hidden cause resembles."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from missionplan.diagnosis.dives.discrepancy_axes import FORCE_STEP, UnknownForce, _trend, _wrong_anchor, force_axes
from missionplan.diagnosis.dives.kind import DescentKind, descent_shares
from missionplan.diagnosis.dives.likelihood import DescentLikelihood
from missionplan.diagnosis.dives.noise import noise_grid
from missionplan.diagnosis.inference.axes import AxisScale
from missionplan.diagnosis.inference.block_covariance import InnerProducts
from missionplan.diagnosis.inference.discrepancy import discrepancy
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class Steady(DescentEffect):
    """The same force throughout."""

    share: float = 0.0
    newton: float = 0.0

    def drag_factor(self, since_taut, speed):
        return 1.0 + self.share

    def lift(self, depth):
        return self.newton


def axes_of(model):
    readings = model.base.readings
    t = np.concatenate([log.t for log in model.forward.logs])
    extents = {"time": t, "depth": readings, "speed": np.gradient(readings, t)}
    delays = np.zeros(len(model.forward.logs))
    found = force_axes(model.forward, model.coordinates, model.centre, delays, extents)
    return {axis.description: axis for axis in found}


def moved(model, effect):
    """By how much an effect moves the readings [m]."""
    forward = replace(model.forward, given=(effect,))
    at = model.centre[:, None]
    return (forward.readings(model.coordinates, at) - model.forward.readings(model.coordinates, at))[:, 0]


@pytest.mark.parametrize("what", ["time", "speed"])
def test_the_same_drag_everywhere_is_a_steady_drag(measured, what):
    model = measured()
    response = axes_of(model)[f"drag that changes with {what}"].response
    np.testing.assert_allclose(response.sum(axis=1), moved(model, Steady(share=FORCE_STEP)), rtol=0.01, atol=2e-4)


def test_the_same_lift_everywhere_is_a_steady_lift(measured):
    model = measured(weights=np.full(4, 12.0))
    found = axes_of(model)
    expected = moved(model, Steady(newton=12.0 * FORCE_STEP))
    np.testing.assert_allclose(
        found["a lift that changes with depth"].response.sum(axis=1), expected, rtol=0.01, atol=2e-4
    )
    np.testing.assert_allclose(
        found["drag that changes with depth"].response.sum(axis=1), expected, rtol=0.01, atol=2e-4
    )


def test_a_force_changes_later_readings_only(measured):
    model = measured()
    response = axes_of(model)["drag that changes with time"].response
    t = np.concatenate([log.t for log in model.forward.logs])
    late = response[:, -4]  # a hat about 13/16 of the longest time since the line is taut
    assert np.abs(late[t < 9.0]).max() < 1e-9
    assert np.abs(late[t > 12.5]).max() > 1e-3


@pytest.mark.parametrize(
    ("name", "parameters", "looks_like"),
    [
        ("drag-crisis", {"fraction": 0.3, "speed": 1.3, "width": 0.1}, "drag that changes with speed"),
        ("stratification", {"lift": 3.0, "depth": 8.0, "thickness": 1.0}, "a lift that changes with depth"),
        ("broadside-start", {"extra_drag": 3.0, "time": 4.0}, "drag that changes with time"),
    ],
)
def test_a_discrepancy_is_recognised_for_what_it_is(measured, name, parameters, looks_like):
    """A cause of the catalogue that was not fitted is an unknown force of its kind."""
    model = measured(name, **parameters)
    (base,) = model.fit_all([((), ())])
    found = discrepancy(model.residuals(base))
    assert found.significant
    assert found.resembles == looks_like


def test_the_shape_of_a_lost_drag_is_drawn_in_its_units(measured):
    """To first order: a speed that grows as (1 − fraction)^−½ is read as twice as much less drag."""
    model = measured("drag-crisis", fraction=0.15, speed=1.3, width=0.1)
    (base,) = model.fit_all([((), ())])
    shape = discrepancy(model.residuals(base)).shape
    assert shape is not None
    assert (shape.place, shape.value) == ("Speed (m/s)", "Extra drag (%)")
    fast = shape.at > 1.6
    assert np.abs(shape.mean[fast] + 200.0 * (0.85**-0.5 - 1.0)).max() < 3.0 * shape.sd[fast].max() < 12.0
    assert shape.mean[0] > shape.mean[fast].max() + 5.0


def test_an_axis_of_logarithms_is_drawn_in_seconds():
    scale = AxisScale(0.0, np.log(5.0), "Time (s)", "", unit=2.0)
    assert scale.at(np.array([0.0, 0.5, 1.0])) == pytest.approx([0.0, 2.0 * (np.sqrt(5.0) - 1.0), 8.0])


def test_products_are_those_of_the_whole_covariance(measured):
    """Dive by dive with the coordinates integrated out, against the inverse of the covariance of all readings."""
    model = measured("drag-bias", fraction=0.3)
    (fit,) = model.fit_all([(("drag-bias",), ())])
    columns = np.random.default_rng(3).normal(size=(len(model.y), 2))
    residuals = model.residuals(fit)
    found = list(residuals.inner_products(columns))
    assert [each.log_weight for each in found] == [noise.log_prior for noise in noise_grid()]
    best: InnerProducts = found[fit.state.best_noise]
    both = np.column_stack([columns, residuals.values])
    whole = both.T @ np.linalg.solve(residuals.covariance.dense(), both)
    np.testing.assert_allclose(best.gram, whole, rtol=1e-6, atol=1e-6 * np.abs(whole).max())
    assert best.log_determinant == pytest.approx(np.linalg.slogdet(residuals.covariance.dense())[1], abs=1e-6)


def test_hats_trends_and_wrong_anchors_by_hand():
    hat = UnknownForce(lift_at_depth=3.0, drag_in_time=0.5, centre=2.0, width=1.0, ends=(1.5, 4.0))
    assert hat.lift(np.array([0.0, 1.5, 2.0, 2.25, 3.0, 9.0])) == pytest.approx([1.5, 1.5, 3.0, 2.25, 0.0, 0.0])
    assert hat.drag_factor(2.25, 9.0) == pytest.approx(1.0 + 0.5 * 0.75)
    trend = _trend("drag", np.array([1.0, 2.0, 3.0, 4.0]), np.array([0, 0, 1, 2]), 0.1, ("Extra drag (%)", 100.0))
    np.testing.assert_allclose(trend.response, [[1.0, 0.0], [2.0, 0.0], [1.5, 1.5], [0.0, 4.0]])
    logs = [SimpleNamespace(wet_weight=weight) for weight in (9.0, 12.0, 9.0)]
    own, weight = np.eye(3), np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(_wrong_anchor(logs, own, weight).response, [[1, 0, 0, 1], [0, 2, 0, 0], [0, 0, 3, 3]])


def test_how_late_dives_end_is_told_in_seconds_of_their_own_speed():
    """At 1 m/s half a metre short is 0.5 s late; at 2 m/s from half-way on 2.2 m too deep is 1.1 s early."""
    t = np.arange(10.0)
    slow, quick = t, np.where(t < 5.0, 0.5 * t, 2.0 * t - 7.5)
    rows = [("a", t, slow, -0.5), ("b", t, quick, 2.2)]
    table = pd.concat([pd.DataFrame({"run": run, "t_s": when, "base_m": base, "residual_base_m": off, "depth_m": base + off})
                       for run, when, base, off in rows])  # fmt: skip
    assert DescentKind.misfit(None, table) == (
        "The vehicle arrives 0.3 s early at 9 m on the mean of the dives; the farthest off is b, 1.1 s early at 11 m."
    )


def test_shares_of_dives_are_of_squares_in_their_own_units():
    places = {0.0: [0.0, 0.0], 1.0: [1.0, 0.0], 2.0: [9.0, 9.0]}
    forward = SimpleNamespace(readings=lambda _, at: np.stack([places[each] for each in at[0]], axis=1))
    model = SimpleNamespace(forward=forward, coordinates=(), y=np.array([1.0, 4.0]), units=np.array([1.0, 2.0]))
    base, better, worse = (
        SimpleNamespace(state=SimpleNamespace(linear=SimpleNamespace(at=np.array([at])))) for at in places
    )
    assert descent_shares(model, base, [better, worse]) == pytest.approx([1.0 - 4.0 / 5.0, 0.0])


def test_what_all_dives_share_of_their_scatter_is_as_great_as_the_noise_has_it():
    linear = SimpleNamespace(columns=np.array([[1.0], [2.0], [3.0]]), curvature=np.array([0.1, 0.2, 0.4]))
    own = SimpleNamespace(parts=(np.arange(3),), covariances=lambda *_: [np.eye(3)[None]])
    noise = replace(noise_grid()[0], scatter=0.5)
    found = DescentLikelihood.covariance(own, linear, noise, np.array([10.0]))
    assert found.root == pytest.approx(np.array([[10.0, 0.05], [20.0, 0.1], [30.0, 0.2]]))
    assert found.blocks[0].tolist() == np.eye(3).tolist()
