"""What dives to come show: an error of a cause's law that they share, scatter known as far as the dives so far tell."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from missionplan.diagnosis.dives.designs import stretched_dives
from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.dives.noise import SHAPE_SD
from missionplan.diagnosis.dives.preparation import MIN_NOISE
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.next_trial.belief import Believed, Posterior
from missionplan.diagnosis.next_trial.dive_trials import made, planned
from missionplan.diagnosis.next_trial.prediction import Explanation, Prediction

from .dive_campaign import of_some

LIFT = 3.0


def believed(model: DescentModel, causes: tuple[str, ...]) -> Believed:
    """A set of causes as dives leave it."""
    (fit,) = model.fit_all([(causes, ())])
    assert isinstance(fit, CauseFit)
    places, state = model.searched(causes), fit.state
    mean = model.prior(causes).centre.copy()
    mean[places] = (state.linear.centre + state.marginal.mean)[places]
    posterior = Posterior(places, mean, state.marginal.covariance[np.ix_(places, places)])
    own: Any = SimpleNamespace(model=model)
    coordinates = tuple(model.coordinates[index] for index in places)
    explanation = Explanation(1.0, mean[places], posterior.covariance)
    mission: Any = None
    return Believed(causes, own, fit, posterior, explanation, coordinates, mission)


def test_many_dives_know_a_lift_no_better_than_its_law(measured) -> None:
    """However many: an error exp(−½(Δt/ℓ)²) along a record of four ℓ leaves 1ᵀk⁻¹1 readings of the lift at most."""
    model = measured("trapped-gas", lift=LIFT)
    found = believed(model, ("trapped-gas",))
    log = model.forward.logs[0]
    dives = tuple(replace(log, name=f"dive {k}", sd=np.full(len(log.t), 1e-3)) for k in range(24))
    prediction = planned(dives, found)
    error = np.linalg.solve(prediction.noises[-1], prediction.columns[:, 0])
    sd = float((prediction.columns[:, 0] @ error) ** -0.5)
    distance = np.subtract.outer(log.t, log.t) / (0.25 * np.ptp(log.t))
    kernel = np.exp(-0.5 * distance**2) + 1e-6 * np.eye(len(log.t))
    readings = float(np.ones(len(log.t)) @ np.linalg.solve(kernel, np.ones(len(log.t))))
    lift = float(found.explanation.mean[0])
    assert sd > 0.9 * SHAPE_SD * lift / readings**0.5
    assert readings < 5.0


def test_dives_that_scatter_are_expected_to_scatter_again(measured) -> None:
    def wide(late: np.ndarray) -> float:
        model = measured(late=late)
        prediction = planned(model.forward.logs[:2], believed(model, ()))
        assert prediction.shares.sum() == pytest.approx(1.0)
        spread = np.trace(prediction.noises, axis1=1, axis2=2)
        assert np.all(np.diff(spread) > 0.0)
        return float(prediction.shares @ spread)

    assert wide(np.array([0.25, -0.2, 0.22, -0.28])) > 2.0 * wide(np.zeros(4))


def test_dives_released_late_are_read_about_their_own_releases(measured) -> None:
    """A start with a jerk a quarter of a second late is no matter of first order about none."""
    found = believed(measured(), ())
    logs = measured(late=np.full(4, 0.25)).forward.logs
    (prediction,) = made(logs, [found])
    error = np.concatenate([log.depth for log in logs]) - prediction.centre
    loose = prediction.noises[-1]
    assert float(error @ np.linalg.solve(loose, error)) < 1.3 * len(error)
    speed = np.mean([np.ptp(log.depth) / np.ptp(log.t) for log in logs])
    assert error.mean() == pytest.approx(-0.25 * speed, rel=0.2)  # a dive to come is released as usual, and deeper


def test_a_dive_to_come_is_read_as_those_so_far(measured) -> None:
    forward = measured().forward
    log = replace(forward.logs[0], site_depth=15.0)
    deeper = replace(log, site_depth=27.0)
    short, long = stretched_dives(forward, [log, deeper])
    ends = 0.8 * (15.0 - log.line_length), 15.0 - log.line_length
    depth = replace(forward, logs=(short, long)).readings((), np.zeros((0, 1)))[:, 0]
    assert len(short.t) == len(long.t) == len(log.t)
    assert ends[0] < depth[len(short.t) - 1] < ends[1]  # near touchdown
    factor = np.ptp(long.t) / np.ptp(short.t)
    np.testing.assert_allclose(long.sd, np.maximum(short.sd / np.sqrt(factor), MIN_NOISE), rtol=0.1)
    assert factor > 1.5


def test_parameters_that_are_not_asked_for_are_integrated_out() -> None:
    """The data's distribution stays as it is."""
    generator = np.random.default_rng(3)
    root, columns = generator.standard_normal((3, 3)), generator.standard_normal((5, 3))
    known = Explanation(1.0, generator.standard_normal(3), root @ root.T)
    whole = Prediction(np.zeros(5), columns, np.eye(5))
    own, part = of_some(known, whole, np.array([True, False, True]))
    np.testing.assert_allclose(
        part.columns @ own.covariance @ part.columns.T + part.noises[0],
        columns @ known.covariance @ columns.T + np.eye(5),
        atol=1e-9,
    )
    np.testing.assert_allclose(  # and what the data say of those asked for
        own.covariance @ part.columns.T, (known.covariance @ columns.T)[[0, 2]], atol=1e-9
    )
