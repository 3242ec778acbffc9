"""Neutral terms beside a term with a name: their density and prior, and terms whose size is none of their effect's."""

import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from scipy.stats import multivariate_normal

from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.inference.marginal_likelihood import SCALES
from missionplan.diagnosis.legs.kind import transit_model
from missionplan.diagnosis.legs.noise_integration import NoiseSearch
from missionplan.diagnosis.legs.set_density import LegInference, MeanSet
from missionplan.diagnosis.legs.terms import UNNAMED, refined, terms_of, without_a_name
from missionplan.mission import Mission
from tests.fixtures import TRANSIT, make_legs

KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}


@pytest.fixture(scope="module")
def inference(tmp_path_factory):
    place, mission = tmp_path_factory.mktemp("legs"), Mission.from_data(TRANSIT)
    (place / "dataset.yaml").write_text(yaml.safe_dump({"file": "rows.csv", **KIND}))
    make_legs().to_csv(place / "rows.csv", index=False)
    bound = transit_model(read_transit(place, mission), mission, seed=1)
    return LegInference(bound, terms_of(bound))


def jump(inference):
    return next(i for i, each in enumerate(inference.terms, start=1) if each.effect == "compass-jump")


@pytest.mark.parametrize("early", [0.0, 3.0 * 3600.0, 1e6])
def test_nothing_changes_before_the_first_leg_or_the_start_of_the_mission(folder, transit_mission, legs, early):
    """A log may begin before the mission does: what changed until then is the same throughout the mission."""
    data = read_transit(folder(KIND, legs()), transit_mission)
    bound = transit_model(replace(data, t_start=data.t_start - early), transit_mission, seed=1)
    changing = [each for each in terms_of(bound) if each.effect == "compass-jump"]
    found = [each.acting.shapes["moment"] for term in changing for each in (term, *refined(bound, term))]
    assert all(max(0.0, bound.data.t_start[0]) < moment for moment in found)
    assert bool(found) is bool(bound.data.t_start[int(0.8 * bound.data.n)] > 0.0)


@pytest.mark.parametrize("causes", [(), ("mean-current",)])
def test_density_of_two_terms_is_that_of_their_covariance_written_out(inference, causes):
    number, logs = jump(inference), np.log([0.03, 5.0])
    beside = inference.beside(number, [causes])
    law = NoiseSearch(beside, (), MeanSet(causes)).errors
    found = beside.log_densities(law, logs, [MeanSet(causes)], [3, 8])[0]
    model = inference.model
    spread = np.array([SCALES[1] * c.slab if c.effect in causes else c.spike for c in model.coordinates])
    noise = np.tile(0.03**2 + 2.0 * 25.0 / model.data.under_way**2, 2)
    parts = [model.columns(np.zeros(len(spread))) * spread, SCALES[1] * inference.terms[number - 1].columns]
    for value, others in zip(found, ([], [beside.terms[2]], [beside.terms[7]]), strict=True):
        joined = np.concatenate([*parts, *(SCALES[1] * each.columns for each in others)], axis=2)
        flat = joined.reshape(len(noise), -1)
        expected = multivariate_normal(np.zeros(len(noise)), flat @ flat.T + np.diag(noise)).logpdf(model.y.ravel())
        assert value == pytest.approx(expected, abs=1e-5)


def test_a_set_beside_a_term_is_charged_for_both(inference):
    number = jump(inference)
    beside = inference.beside(number, [("mean-current",)])
    first = inference.log_prior(MeanSet(("mean-current",), number), ())
    assert beside.log_prior(MeanSet(("mean-current",)), ()) == pytest.approx(first)
    with_neutral = beside.log_priors(())[0]
    assert with_neutral[0] == pytest.approx(first)
    assert with_neutral[3] == pytest.approx(first + beside.terms[2].log_share)
    assert all(each.is_neutral for each in beside.terms)


def test_a_term_of_no_size_of_its_effect_is_as_probable_as_what_has_no_name(inference):
    number = jump(inference)
    terms = without_a_name(inference.terms, {number})
    own, before = terms[number - 1], inference.terms[number - 1]
    assert own.is_neutral
    assert own.columns is before.columns
    assert own.log_share - before.log_share < math.log(UNNAMED)
    assert all(a is b for i, (a, b) in enumerate(zip(terms, inference.terms, strict=True), start=1) if i != number)
