"""Parts of the legs' inference by hand: spreads between values, noises and scales tried, and the drift at the surface."""

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from missionplan.diagnosis.inference.marginal_likelihood import SCALES
from missionplan.diagnosis.legs.fitting import CLEARLY, TransitFitting
from missionplan.diagnosis.legs.likelihood.mean import TransitMean
from missionplan.diagnosis.legs.model import TransitModel
from missionplan.diagnosis.legs.posterior import LegPosterior
from missionplan.diagnosis.legs.set_density import MeanSet
from missionplan.phases.hooks import TransitEffect


def acting(value: float, *, effect: str = "compass-jump", name: str = "moment", strength: str = "angle") -> Any:
    coordinate = SimpleNamespace(name=strength)
    return SimpleNamespace(effect=effect, shapes={name: value}, coordinates=(coordinate,))


@pytest.mark.parametrize(
    ("name", "effect", "variance"),
    [
        (
            "moment",
            "compass-jump",
            0.75 * 25.0 + 0.25 * 225.0 + 20.0**2 / 12.0,
        ),  # between 100 and 120 s any is as likely
        ("times", "course-response", 0.75 * 25.0 + 0.25 * 225.0),  # a whole number
    ],
)
def test_a_shape_is_as_sure_as_the_values_tried_and_the_distance_between_them(monkeypatch, name, effect, variance):
    parameter = SimpleNamespace(searched="course" if name == "times" else "time")
    catalogue = {effect: SimpleNamespace(parameters={name: parameter})}
    monkeypatch.setattr("missionplan.diagnosis.legs.posterior.CATALOGUE", catalogue)
    own = [acting(value, effect=effect, name=name) for value in (100.0, 120.0)]
    other = acting(900.0, effect=effect, name=name, strength="another")
    terms = [SimpleNamespace(acting=each) for each in (*own, other)]
    keys = [("set", k) for k in range(4)]
    masses = dict(zip(keys, [0.0, np.log(0.6), np.log(0.2), 5.0], strict=True))
    self: Any = SimpleNamespace(
        _by_causes={("a",): keys}, log_masses=masses, inference=SimpleNamespace(terms=terms),
    )  # fmt: skip
    found = LegPosterior._shape(self, ("a",), own[0])
    assert np.exp(found.mean) == pytest.approx([105.0])
    assert found.covariance == pytest.approx(np.array([[variance / 105.0**2]]))
    assert LegPosterior._shape(self, ("a",), None).coordinates == ()


@pytest.mark.parametrize("heavy", [0.7, 0.0])
def test_the_posterior_over_noises_and_scales_has_the_spread_of_each_and_between_them(heavy):
    """Of a normal mixture: the mean of variances and the variance of means; scales of no share are not asked."""
    scales = len(SCALES)
    shares = np.zeros((2, scales))
    shares[:, 0], shares[:, -1] = (0.1, 0.2), (heavy, 0.0)
    means = {0: np.array([[1.0, 5.0], [3.0, 4.0]]), scales - 1: np.array([[10.0, -2.0], [0.0, 0.0]])}
    roots = {at: np.array([[[0.5, 0.0], [0.2, 1.0 + at]], [[1.0, 0.0], [0.0, 2.0]]]) for at in means}

    def priors(_, found):
        (at,) = found
        return SimpleNamespace(posterior=lambda grams: (means[at][:, None], roots[at][:, None]))

    inference = SimpleNamespace(
        model=SimpleNamespace(coordinates=("a", "b")), core=2, group=lambda one: 0, priors=priors, terms=[]
    )
    law: Any = SimpleNamespace(grams=[[SimpleNamespace(products=np.zeros(3))]])
    self: Any = SimpleNamespace(inference=inference)
    mean, covariance = LegPosterior._moments(self, law, MeanSet(()), shares / shares.sum())
    parts = [
        (shares[j, at] / shares.sum(), means[at][j], roots[at][j] @ roots[at][j].T) for at in means for j in range(2)
    ]
    expected = sum(w * m for w, m, _ in parts)
    assert mean == pytest.approx(expected)
    spread = sum(w * (own + np.outer(m - expected, m - expected)) for w, m, own in parts)
    assert covariance == pytest.approx(spread)


class Drifting(TransitEffect):
    """Drifts by when it surfaces, how long it stays, and where."""

    def surface_velocity(self, t, duration, position):
        return np.stack([t + 0.1 * duration, position[0]])


def test_a_leg_s_velocity_error_has_the_drift_at_the_surface_then_and_there(monkeypatch):
    monkeypatch.setattr("missionplan.diagnosis.legs.likelihood.mean.velocity_error", lambda *_: np.full((2, 2), 7.0))
    data = SimpleNamespace(
        t_start=np.array([0.0, 1000.0]), under_way=np.array([600.0, 300.0]), surface=np.array([60.0, 90.0]),
        end=np.array([[5.0, 6.0], [0.0, 0.0]]),
    )  # fmt: skip
    self: Any = SimpleNamespace(data=data, leg=None, site_current=None)
    found = TransitMean.velocity_error(self, [Drifting()])
    assert found == pytest.approx(7.0 + np.array([[606.0 * 0.1, 1309.0 * 0.3], [5.0 * 0.1, 6.0 * 0.3]]))


@pytest.mark.parametrize(("gain", "likeliest"), [(0.9, 0), (1.1, 1)])
def test_a_plainer_state_is_taken_where_another_is_hardly_likelier(gain, likeliest):
    evidences = {"steady": -50.0, "slow": -50.0 + gain * CLEARLY}
    self: Any = SimpleNamespace(
        _variants=lambda causes: [("steady", 0.5), ("slow", 0.5)],
        _fitted=lambda causes, forms, *_, **__: SimpleNamespace(
            posterior=SimpleNamespace(log_evidence=evidences[forms]), forms=forms
        ),
    )
    together, added, state = TransitFitting.over_forms(self, ("a",))
    assert state.forms == list(evidences)[likeliest]
    assert together == pytest.approx(np.log(0.5 * np.exp(-50.0) + 0.5 * np.exp(-50.0 + gain * CLEARLY)))
    assert added == pytest.approx(together + 50.0)


def test_the_errors_of_the_residuals_are_of_their_own_axis() -> None:
    """Covariances of three legs on either axis, and a column that both respond to, leg by leg."""
    noise = np.stack([np.diag([1.0, 2.0, 3.0]), np.diag([10.0, 20.0, 30.0]) + 0.5])
    columns = np.arange(6.0).reshape(2, 3, 1)
    linear = SimpleNamespace(columns=columns, prior_sd=lambda _: np.array([2.0]))
    self: Any = SimpleNamespace(noise=lambda _: noise, data=SimpleNamespace(n=3))
    found = TransitModel.error_covariance(self, SimpleNamespace(state=SimpleNamespace(values=None)), linear)
    for first, second in itertools.product(range(6), repeat=2):
        legs, axes = (first // 2, second // 2), (first % 2, second % 2)
        expected = noise[axes[0]][legs] if axes[0] == axes[1] else 0.0
        expected += 4.0 * columns[axes[0], legs[0], 0] * columns[axes[1], legs[1], 0]
        assert found.dense()[first, second] == expected
