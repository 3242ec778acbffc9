"""The value of information against closed forms: a linear Gaussian experiment, and a choice between two alternatives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm

from missionplan.diagnosis.next_trial.experiment import (
    DecisionProblem,
    Experiment,
    _fit,
    drawn,
    polynomial,
    value_of_information,
)
from missionplan.diagnosis.next_trial.prediction import Explanation, Prediction
from tests.next_trial.seen import realised_information

DRAWS = 20_000


def repeated(count: int, sd: float, mean: float = 0.4, spread: float = 1.0) -> Experiment:
    """A parameter N(mean, spread²), measured `count` times with error `sd`."""
    known = Explanation(1.0, np.array([mean]), np.array([[spread**2]]))
    columns = np.ones((count, 1))
    return Experiment((known,), (Prediction(columns[:, 0] * mean, columns, sd**2 * np.eye(count)),))


def choice(experiment: Experiment, seed: int = 1) -> tuple[DecisionProblem, np.ndarray, np.ndarray]:
    """Alternatives of loss 0 and of loss θ, the draws of θ, and the experiment's data."""
    generator = np.random.default_rng(seed)
    draws = drawn(experiment.explanations, [DRAWS], generator)
    data = experiment.data(draws, generator)
    theta = draws.parameters[0]
    losses = np.concatenate([np.zeros_like(theta), theta], axis=1)
    return DecisionProblem(np.arange(2.0), losses, draws.weight), theta, data


def exact(mean: float, sd: float) -> float:
    """E max(0, −m) − max(0, −E m) of a normal m: the unit-normal loss integral (Raiffa & Schlaifer 1961)."""
    return sd * norm.pdf(mean / sd) - abs(mean) * norm.cdf(-abs(mean) / sd)


@pytest.mark.parametrize(("count", "sd"), [(1, 1.0), (4, 1.0), (4, 3.0)])
def test_the_value_of_a_sample_is_the_unit_normal_loss_integral(count: int, sd: float) -> None:
    experiment = repeated(count, sd)
    problem, _, data = choice(experiment)
    found = value_of_information(problem, experiment.summaries(data))
    posterior_sd = np.sqrt(1.0 / (1.0 + sd**2 / count))  # of the posterior mean
    assert found.mean == pytest.approx(exact(0.4, posterior_sd), abs=4.0 * found.error)
    assert found.error < 0.05 * exact(0.4, 1.0)


def test_unlimited_data_are_worth_perfect_information() -> None:
    experiment = repeated(1, 1e-4)
    problem, theta, data = choice(experiment)
    perfect = value_of_information(problem, np.stack(polynomial(theta), axis=1))
    assert perfect.mean == pytest.approx(exact(0.4, 1.0), abs=4.0 * perfect.error)
    assert value_of_information(problem, experiment.summaries(data)).mean == pytest.approx(perfect.mean, rel=0.01)


def test_data_that_cannot_change_the_choice_are_worth_nothing() -> None:
    experiment = repeated(4, 1.0)
    problem, theta, data = choice(experiment)
    losses = np.stack([theta[:, 0] ** 2, theta[:, 0] ** 2 + 1.0], axis=1)
    found = value_of_information(DecisionProblem(np.arange(2.0), losses, problem.weight), experiment.summaries(data))
    assert found.mean == 0.0
    assert not found.changes
    assert np.all(found.chosen == 0)


def test_more_data_are_worth_more() -> None:
    values = []
    for count in (1, 3, 10, 30):
        experiment = repeated(count, 2.0)
        problem, _, data = choice(experiment)
        values.append(value_of_information(problem, experiment.summaries(data)).mean)
    assert values == sorted(values)


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 3), st.integers(1, 6), st.integers(0, 10_000))
def test_the_information_of_a_linear_gaussian_experiment_is_half_a_log_determinant(k: int, n: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    columns, root = generator.standard_normal((n, k)), generator.standard_normal((k, k))
    covariance = root @ root.T + 0.1 * np.eye(k)
    known = Explanation(1.0, generator.standard_normal(k), covariance)
    experiment = Experiment((known,), (Prediction(np.zeros(n), columns, 0.5 * np.eye(n)),))
    draws = drawn((known,), [50], generator)
    data = experiment.data(draws, generator)
    expected = 0.5 * np.linalg.slogdet(np.eye(k) + 2.0 * covariance @ columns.T @ columns)[1]
    assert experiment.expected_information(draws, data) == pytest.approx(expected, abs=1e-9)
    after = np.linalg.inv(np.linalg.inv(covariance) + 2.0 * columns.T @ columns)
    np.testing.assert_allclose(experiment.covariances[0], after, rtol=1e-6, atol=1e-9)


def two_explanations(distance: float) -> Experiment:
    """A reading of 0 or of `distance` with unit error, equally likely."""
    nothing = Explanation(0.5, np.zeros(0), np.zeros((0, 0)))
    centres = (np.zeros(1), np.array([distance]))
    return Experiment((nothing, nothing), tuple(Prediction(c, np.zeros((1, 0)), np.eye(1)) for c in centres))


def test_which_explanation_holds_is_worth_one_bit_at_most() -> None:
    generator = np.random.default_rng(2)
    found = []
    for distance in (0.0, 1.0, 3.0, 12.0):
        experiment = two_explanations(distance)
        draws = drawn(experiment.explanations, [4000, 4000], generator)
        found.append(experiment.expected_information(draws, experiment.data(draws, generator)))
    assert found == sorted(found)
    assert found[0] == pytest.approx(0.0, abs=1e-12)
    assert found[-1] == pytest.approx(np.log(2.0), rel=1e-6)


def test_gained_information_averages_to_what_was_expected() -> None:
    generator = np.random.default_rng(3)
    a = Explanation(0.3, np.array([1.0]), np.array([[0.5]]))
    b = Explanation(0.7, np.array([-0.5, 0.0]), np.diag([0.2, 2.0]))
    wide = generator.standard_normal((4, 2))
    experiment = Experiment(
        (a, b), (Prediction(wide[:, 0], wide[:, :1], np.eye(4)), Prediction(np.zeros(4), wide, 0.5 * np.eye(4)))
    )
    draws = drawn(experiment.explanations, [180, 420], generator)
    data = experiment.data(draws, generator)
    truths = [theta for own in draws.parameters for theta in own]
    gained = [
        realised_information(experiment, int(which), theta, y)
        for which, theta, y in zip(draws.explanation, truths, data, strict=True)
    ]
    error = np.std(gained) / np.sqrt(len(gained))
    assert np.mean(gained) == pytest.approx(experiment.expected_information(draws, data), abs=4.0 * error)


def test_a_choice_that_hangs_on_the_explanation_is_worth_its_prior_regret() -> None:
    """Losses (0, 1) or (1, 0): a sure answer saves the smaller of the two probabilities, a half."""
    generator = np.random.default_rng(4)
    experiment = two_explanations(12.0)
    draws = drawn(experiment.explanations, [2000, 2000], generator)
    losses = np.where(draws.explanation[:, None] == np.arange(2), 0.0, 1.0)
    found = value_of_information(
        DecisionProblem(np.arange(2.0), losses, draws.weight), experiment.summaries(experiment.data(draws, generator))
    )
    assert found.mean == pytest.approx(0.5, abs=1e-3)


def of_unknown_noise(sds: tuple[float, float]) -> Experiment:
    """One reading of a parameter N(0, 1), its error of either size with the same probability."""
    known = Explanation(1.0, np.zeros(1), np.eye(1))
    noise = np.square(sds)[:, None, None]
    return Experiment((known,), (Prediction(np.zeros(1), np.ones((1, 1)), noise, np.full(2, 0.5)),))


def test_the_information_of_a_reading_of_unknown_error_is_that_of_a_mixture() -> None:
    """By quadrature: ∬ p(θ) p(y | θ) ln(p(y | θ)/p(y)), p(y | θ) a mixture of two normals."""
    sds = (0.2, 3.0)
    theta, y = np.meshgrid(np.linspace(-6.0, 6.0, 601), np.linspace(-18.0, 18.0, 1801), indexing="ij")
    given = sum(0.5 * norm.pdf(y, theta, sd) for sd in sds)
    alone = sum(0.5 * norm.pdf(y, 0.0, np.hypot(1.0, sd)) for sd in sds)
    exact = float(np.sum(norm.pdf(theta) * given * np.log(given / alone)) * 0.02 * 0.02)
    generator, experiment = np.random.default_rng(5), of_unknown_noise(sds)
    draws = drawn(experiment.explanations, [DRAWS], generator)
    assert experiment.expected_information(draws, experiment.data(draws, generator)) == pytest.approx(exact, abs=0.01)


def test_a_reading_of_unknown_error_moves_the_mean_by_what_each_error_would() -> None:
    sds, y = (0.2, 3.0), 1.5
    weights = np.array([norm.pdf(y, 0.0, np.hypot(1.0, sd)) for sd in sds])
    expected = weights @ [y / (1.0 + sd**2) for sd in sds] / weights.sum()
    (found,) = of_unknown_noise(sds).means(np.array([[y]]))
    assert found[0, 0] == pytest.approx(expected, rel=1e-9)


def test_information_gained_with_an_unknown_error_averages_to_what_was_expected() -> None:
    generator, experiment = np.random.default_rng(6), of_unknown_noise((0.3, 2.0))
    draws = drawn(experiment.explanations, [600], generator)
    data = experiment.data(draws, generator)
    gained = [realised_information(experiment, 0, theta, y) for theta, y in zip(draws.parameters[0], data, strict=True)]
    error = np.std(gained) / np.sqrt(len(gained))
    assert np.mean(gained) == pytest.approx(experiment.expected_information(draws, data), abs=4.0 * error)


def test_of_each_noise_there_are_as_many_draws_as_its_share_and_each_weighs_what_it_does() -> None:
    known = Explanation(1.0, np.array([0.4]), np.array([[1.0]]))
    noises = np.array([[[0.0]], [[1.0]]])
    experiment = Experiment((known,), (Prediction(np.array([2.0]), np.zeros((1, 1)), noises, np.array([0.25, 0.75])),))
    generator = np.random.default_rng(1)
    found = experiment.data(drawn(experiment.explanations, [8], generator), generator)[:, 0]
    assert np.flatnonzero(found == 2.0).tolist() == [0, 1]
    fitted = _fit(np.ones((3, 1)), np.array([[0.0], [1.0], [4.0]]), np.array([0.25, 0.25, 0.5]))
    assert fitted[0, 0] == pytest.approx(2.25, rel=1e-5)
