"""Fits whose numbers are not finite are none."""

import math
from dataclasses import replace

import numpy as np
import pytest

from missionplan.diagnosis.coordinates import coordinates_of, estimates
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, _in_numbers
from missionplan.effects import CATALOGUE
from missionplan.results.learned.evidence import ParameterEstimate

ESTIMATE = ParameterEstimate("drag-bias", "fraction", 0.1, 0.02, 0.07, 0.13, "")
FIT = CauseFit(("drag-bias",), -3.0, (ESTIMATE,), {}, True, None)


def test_a_fit_of_finite_numbers_is_left_as_it_is():
    assert _in_numbers(FIT) is FIT


@pytest.mark.parametrize("name", ["value", "sd", "low", "high"])
@pytest.mark.parametrize("place", ["estimates", "given"])
@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_fit_that_is_not_is_none(name, place, number):
    fit = replace(FIT, **{place: (replace(ESTIMATE, **{name: number}),)})
    assert _in_numbers(fit) == FailedFit(("drag-bias",), "the data do not determine its parameters")


def test_a_size_known_to_nothing_is_no_overflow():
    coordinates = [each for each in coordinates_of(CATALOGUE["random-walk"]) if each.kind == "shape"]
    (found,) = estimates(coordinates[:1], np.array([0.0]), np.array([[1e8]]))
    assert np.all(np.isfinite([found.low, found.high]))
