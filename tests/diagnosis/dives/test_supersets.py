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
    (columns,) = responses.columns[chosen]
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


def test_effect_free_dives_gain_nothing_by_a_response(measured):
    model = measured()
    (fit,) = model.fit_all([((), ())])
    assert model.responses_beside([fit]).log_gains.max() < 2.0
