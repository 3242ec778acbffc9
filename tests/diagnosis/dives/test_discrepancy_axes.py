"""Responses of dives to an unknown force, and which kind of discrepancy a hidden cause resembles."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from missionplan.diagnosis.dives.discrepancy_axes import FORCE_STEP, force_axes
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
