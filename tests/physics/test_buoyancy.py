import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics.water import STANDARD_GRAVITY, displaced_mass, flooded_mass, lead_mass, wet_weight

WATER = 1026.0


@given(st.floats(0.1, 5000.0), st.floats(-50.0, 50.0))
def test_archimedes_gives_the_net_buoyancy_back(mass, net_buoyancy):
    displaced = displaced_mass(mass, net_buoyancy)
    assert (displaced - mass) * STANDARD_GRAVITY == pytest.approx(net_buoyancy, abs=1e-9 * mass)


def test_a_vehicle_that_floats_displaces_more_than_it_weighs():
    assert displaced_mass(10.2, 0.89) == pytest.approx(10.2 + 0.0908, abs=1e-4)


def test_a_neutral_solid_weighs_nothing_in_water():
    assert wet_weight(3.0, WATER, WATER) == 0.0
    assert wet_weight(np.array([1.0, 1.0]), np.array([7850.0, 500.0]), WATER) == pytest.approx(
        [8.524, -10.316], abs=1e-3
    )


def test_water_inside_a_flooded_anchor_replaces_the_volume_that_its_solids_do_not_fill():
    solids = {7850.0: 1.1, 1400.0: 0.5}
    dry = sum(solids.values())
    weight = sum(wet_weight(mass, density, WATER) for density, mass in solids.items())
    volume = dry / WATER - sum(mass / density for density, mass in solids.items())
    assert flooded_mass(dry, weight) == pytest.approx(dry + WATER * volume)


def test_lead_of_a_wet_weight_is_its_mass_less_the_water_it_displaces():
    mass = lead_mass(78.0, WATER)
    assert mass * STANDARD_GRAVITY - mass / 11_340.0 * WATER * STANDARD_GRAVITY == pytest.approx(78.0)
