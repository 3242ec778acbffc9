"""Accuracy of the sketch: quantiles to 0.05 % of their value, and exact merging."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from missionplan.montecarlo.quantile_sketch import QuantileSketch

POSITIVE = st.floats(1e-6, 1e12)


@given(POSITIVE, st.sampled_from([1.0, -1.0]))
def test_a_value_comes_back_to_half_a_thousandth_from_either_end_of_its_bin(value, sign):
    (low,), (high,) = QuantileSketch.of(np.array([value])).bounds()
    for held in (low, value, np.nextafter(high, 0.0)):
        found = QuantileSketch.of(np.array([sign * held])).quantiles((0.5,))[0]
        assert found == pytest.approx(sign * held, rel=2.0**-11)


@given(arrays(float, st.integers(1, 40), elements=st.floats(-1e6, 1e6)), st.integers(0, 40))
def test_two_parts_merged_are_the_whole(values, cut):
    parts = [part for part in (values[:cut], values[cut:]) if part.size]
    merged = QuantileSketch.of(parts[0])
    for part in parts[1:]:
        merged = merged.merge(QuantileSketch.of(part))
    whole = QuantileSketch.of(values)
    assert merged.first == whole.first
    assert merged.counts.tolist() == whole.counts.tolist()


@pytest.mark.parametrize("gap", [0, 1, 2, 7])
def test_neighbouring_and_distant_bins_merge(gap):
    low, high = 1.0, 1.0 + gap / 1024.0
    merged = QuantileSketch.of(np.full(3, high)).merge(QuantileSketch.of(np.full(2, low)))
    bins, counts = merged.bins_in_use()
    assert np.diff(bins).tolist() == ([gap] if gap else [])
    assert counts.tolist() == ([2, 3] if gap else [5])


def test_bins_in_use_make_the_sketch_again():
    sketch = QuantileSketch.of(np.array([-3.0, 0.0, 2.0, 2.0, 900.0]))
    again = QuantileSketch.from_bins(*sketch.bins_in_use())
    assert again.first == sketch.first
    assert again.counts.tolist() == sketch.counts.tolist()
