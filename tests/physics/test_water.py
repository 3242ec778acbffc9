import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics.water import sea_water, sea_water_density, sea_water_dynamic_viscosity


def test_ittc_sea_water_at_15_degrees():
    water = sea_water(15.0, 35.0)
    assert water.density == pytest.approx(1025.98, abs=0.005)
    assert water.viscosity == pytest.approx(1.1892e-6, rel=2e-3)


def test_brackish_water_at_20_degrees():
    water = sea_water(20.0, 15.0)
    assert water.density == pytest.approx(1009.5, abs=0.1)
    assert water.viscosity == pytest.approx(1.022e-6, rel=1e-3)


def test_fresh_water_at_20_degrees_has_the_viscosity_of_iapws():
    assert sea_water_dynamic_viscosity(20.0, 0.0) == pytest.approx(1.0016e-3, rel=2e-3)


def test_salt_thickens_as_isdale_measured():
    """Isdale, Spence & Tudhope (1972), Desalination 10, 319: another fit to much the same data."""
    t, s = np.meshgrid(np.linspace(10.0, 100.0, 19), np.linspace(0.0, 60.0, 13))
    a = 1.474e-3 + 1.5e-5 * t - 3.927e-8 * t**2
    b = 1.073e-5 - 8.5e-8 * t + 2.23e-10 * t**2
    thicker = sea_water_dynamic_viscosity(t, s) / sea_water_dynamic_viscosity(t, 0.0)
    assert thicker == pytest.approx(1.0 + a * s + b * s**2, rel=0.005)


def test_arrays_go_through_elementwise():
    temperature = np.array([5.0, 15.0, 25.0])
    densities = sea_water_density(temperature, 35.0)
    assert densities == pytest.approx([sea_water_density(float(t), 35.0) for t in temperature])


@given(st.floats(5.0, 35.0), st.floats(0.0, 39.0))
def test_warmer_is_lighter_and_thinner_and_saltier_is_heavier(temperature, salinity):
    water, warmer, saltier = (
        sea_water(t, s) for t, s in ((0, 0), (1, 0), (0, 1)) for t, s in [(temperature + t, salinity + s)]
    )
    assert warmer.density < water.density < saltier.density
    assert warmer.viscosity < water.viscosity
