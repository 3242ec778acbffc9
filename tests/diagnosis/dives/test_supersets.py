"""Sets that add causes to a fit, in its linearisation, against the same sets fitted; and neutral responses beside it."""

import numpy as np
import pytest
from scipy import stats
from scipy.special import logsumexp

from missionplan.diagnosis.dives.fitting import likely_noises
from missionplan.diagnosis.dives.noise import noise_grid
from missionplan.diagnosis.inference.marginal_likelihood import SCALE_PRIOR, SCALES


def test_what_a_further_cause_adds_is_known_without_a_fit(measured):
    """Causes that are there and causes that are not, with a shape of their own and without."""
    model = measured("drag-bias", fraction=0.35)
    (one,) = model.fit_all([(("drag-bias",), ())])
    sets = [("drag-bias", other) for other in ("added-mass", "clock-offset", "vertical-current", "broadside-start")]
    (gains,) = model.log_gains([one], [sets])
    fits = model.fit_all([(causes, (one,)) for causes in sets])
    assert gains == pytest.approx([fit.log_evidence - one.log_evidence for fit in fits], abs=1.0)


def test_a_second_cause_that_is_there_adds_much(measured):
    model = measured("added-mass", fraction=0.6)
    (drag,) = model.fit_all([(("drag-bias",), ())])
    (gains,) = model.log_gains([drag], [[("drag-bias", "added-mass"), ("drag-bias", "clock-offset")]])
    (both,) = model.fit_all([(("drag-bias", "added-mass"), (drag,))])
    assert gains[0] > 20.0
    assert gains[0] == pytest.approx(both.log_evidence - drag.log_evidence, rel=0.35)


def test_what_a_response_adds_is_that_of_the_whole_covariance(measured):
    """By the density of all readings at once with the response in their covariance."""
    fouled = np.array([0.0, 0.16, 0.32, 0.48])
    model = measured("drag-bias", weights=np.array([16.0, 9.0, 20.0, 12.0]), fraction=fouled)
    (fit,) = model.fit_all([((), ())])
    found = model.responses_beside([fit])
    linear, prior_sd = fit.state.linear, fit.state.prior_sd
    responses = model.responses(fit)
    noises = likely_noises(fit.state)
    assert set(noises) <= set(noise_grid())
    chosen = [axis.description for axis in responses.axes].index("drag that grows or falls from dive to dive")
    columns, _ = responses.columns[chosen]  # the same over either length
    plain, beside = [], []
    for noise in noises:
        total = model.covariance(linear, noise, prior_sd).dense()
        plain.append(noise.log_prior + stats.multivariate_normal(cov=total).logpdf(linear.y))
        for scale, share in zip(SCALES, SCALE_PRIOR, strict=True):
            wider = total + scale**2 * columns @ columns.T
            density = stats.multivariate_normal(cov=wider).logpdf(linear.y)
            beside.append(noise.log_prior + np.log(share) + density)
    assert found.log_gains[0, chosen] == pytest.approx(logsumexp(beside) - logsumexp(plain), abs=0.01)
    assert found.log_gains[0, chosen] > 5.0


def test_a_response_may_do_what_a_cause_of_the_likeliest_set_does(measured):
    """Else whatever is like a named cause is that cause's before they compete."""
    model = measured("stratification", lift=3.0, depth=8.0, thickness=1.0)
    named, nothing = model.fit_all([(("stratification",), ()), ((), ())])
    found = model.responses_beside([named, nothing])
    lift = [words for _, words in found.described].index("a lift that changes with depth")
    assert found.log_gains[0, lift] < 1.0
    assert found.log_gains[1, lift] > 0.5 * (named.log_evidence - nothing.log_evidence) > 10.0


@pytest.mark.parametrize(
    ("what", "named", "effect", "parameters"),
    [
        ("drag", "drag-bias", "drag-bias", {"fraction": 0.1 * np.arange(4)}),
        pytest.param(
            *("a lift", "slow-flooding", "lift-by-depth"),
            {"lift": -0.6 * np.arange(4), "start": 0.01, "over": 0.01},
            marks=pytest.mark.slow,
        ),
        ("an error of the depth read", "depth-scale", "reading-by-time", {"offset": 0.3 * np.arange(4), "time": 0.01}),
    ],
)
def test_what_grows_from_dive_to_dive_needs_no_cause_beside_it(measured, what, named, effect, parameters):
    """A trend has a level of its own: without one its mean would be a cause's."""
    model = measured(effect, weights=np.array([16.0, 9.0, 20.0, 12.0]), **parameters)
    nothing, cause = model.fit_all([((), ()), ((named,), ())])
    found = model.responses_beside([nothing, cause])
    trend = [words for _, words in found.described].index(f"{what} that grows or falls from dive to dive")
    alone, beside = (
        fit.log_evidence + gain for fit, gain in zip((nothing, cause), found.log_gains[:, trend], strict=True)
    )
    assert found.log_gains[0, trend] > 5.0
    assert alone > beside - np.log(len(model.candidates) - len(model.unnamed))  # the prior of a cause


def test_effect_free_dives_gain_nothing_by_a_response(measured):
    model = measured()
    (fit,) = model.fit_all([((), ())])
    assert model.responses_beside([fit]).log_gains.max() < 2.0
