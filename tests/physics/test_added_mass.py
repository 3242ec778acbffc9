import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from missionplan.physics.water import anchor_added_mass, lamb_axial_coefficient, lamb_lateral_coefficient


@pytest.mark.parametrize(("fineness", "k1"), [(1.0, 0.5), (2.0, 0.210), (3.0, 0.122), (9.26, 0.0233)])
def test_lambs_table(fineness, k1):
    assert lamb_axial_coefficient(fineness) == pytest.approx(k1, abs=5e-4)


def test_series_near_the_sphere_joins_the_closed_form():
    near, far = lamb_axial_coefficient(np.array([1.00503, 1.00504]))
    assert near == pytest.approx(far, abs=1e-5)


@given(st.floats(1.0, 50.0), st.floats(1.001, 2.0))
def test_slender_bodies_have_less_added_mass(fineness, factor):
    assert 0.0 < lamb_axial_coefficient(fineness * factor) < lamb_axial_coefficient(fineness) <= 0.5


@pytest.mark.parametrize(("fineness", "k2"), [(1.0, 0.5), (1.50, 0.621), (3.99, 0.860), (9.97, 0.960)])
def test_lambs_table_across_the_axis(fineness, k2):
    assert lamb_lateral_coefficient(fineness) == pytest.approx(k2, abs=1.5e-3)


@pytest.mark.parametrize("fineness", [1.001, 1.5, 2.0, 9.26])
def test_lambs_integral_across_the_axis(fineness):
    # β₀ = a b² ∫ dλ / ((a² + λ)^(1/2) (b² + λ)²) with b = 1 (Lamb, art. 114)
    integral, _ = quad(lambda x: 1.0 / (np.sqrt(fineness**2 + x) * (1.0 + x) ** 2), 0.0, np.inf, epsrel=1e-11)
    beta = fineness * integral
    assert lamb_lateral_coefficient(fineness) == pytest.approx(beta / (2.0 - beta), rel=1e-8)


def test_oblate_bodies_are_refused():
    with pytest.raises(ValueError, match="at least its diameter"):
        lamb_axial_coefficient(0.9)


def test_anchor_of_the_prototype():
    assert anchor_added_mass(0.060325, 1026.0) == pytest.approx(2.38 * 1026.0 * 0.060325**3, rel=1e-3)


@pytest.mark.parametrize("fineness", [1.0, 1.0005, 1.002, 1.004, 1.006, 1.3, 9.26])
def test_lambs_integral_agrees_on_both_branches(fineness):
    # α₀ = a b² ∫ dλ / ((a² + λ)^(3/2) (b² + λ)) with b = 1 (Lamb, art. 114), the substitution λ = tan² for its tail
    integral, _ = quad(
        lambda angle: (
            2.0
            * np.tan(angle)
            / np.cos(angle) ** 2
            / ((fineness**2 + np.tan(angle) ** 2) ** 1.5 * (1.0 + np.tan(angle) ** 2))
        ),
        0.0,
        np.pi / 2.0,
        epsabs=1e-13,
        epsrel=1e-12,
    )
    alpha = fineness * integral
    assert lamb_axial_coefficient(fineness) == pytest.approx(alpha / (2.0 - alpha), rel=1e-9)
