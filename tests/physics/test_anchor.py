import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.physics import water
from missionplan.physics.anchor import (
    AnchorProblem,
    Construction,
    Part,
    added_displacement,
    cap_centroid,
    cap_height,
    cylinder_and_trim,
    displacement_centroid,
    dry_mass,
    solve_anchor,
)
from missionplan.physics.anchor_remedies import buildable_weights, find_remedies

INCH = 0.0254
MADE = Construction(Part(0.7, 7850.0, 1.2 * INCH), Part(0.35, 2700.0, 0.6 * INCH), 1.3, 1200.0, 8500.0)
PROBLEM = AnchorProblem(4.75 * INCH / 2, 0.3e-3, 4.75 * INCH / 2, 1026.02, MADE)


def test_prototype():
    design = solve_anchor(PROBLEM, 11.69737)
    assert design.feasible
    assert design.cylinder_length == pytest.approx(0.12248, abs=5e-6)
    assert design.trim_mass == pytest.approx(0.3915, abs=5e-5)
    assert design.trim_position == pytest.approx(0.1072, abs=5e-5)
    assert design.dry_mass == pytest.approx(1.6007, abs=5e-5)
    assert design.displaced_mass == pytest.approx(1.6007, abs=5e-5)
    assert design.centre_of_buoyancy == pytest.approx(0.0883, abs=5e-5)
    assert design.flooded_mass == pytest.approx(2.79, abs=5e-3)


@given(st.floats(9.0, 40.0))
def test_the_anchor_meets_its_own_conditions(weight):
    design = solve_anchor(PROBLEM, weight)
    tube = MADE.tube_mass_per_length * design.cylinder_length
    parts = [
        (MADE.front.mass, MADE.front.density, MADE.front.centre),
        (tube, MADE.tube_density, PROBLEM.radius + design.cylinder_length / 2),
        (MADE.back.mass, MADE.back.density, design.length - MADE.back.centre),
        (design.trim_mass, MADE.trim_density, design.trim_position),
    ]
    rho = PROBLEM.water_density
    assert sum(water.wet_weight(m, d, rho) for m, d, _ in parts) == pytest.approx(weight)
    assert sum(m for m, _, _ in parts) == pytest.approx(rho * added_displacement(PROBLEM, design.cylinder_length))
    moment = sum(m * x for m, _, x in parts)
    assert moment / design.dry_mass == pytest.approx(displacement_centroid(PROBLEM, design.cylinder_length))
    solids = sum(m / d for m, d, _ in parts)
    flooded = design.dry_mass + rho * (added_displacement(PROBLEM, design.cylinder_length) - solids)
    assert design.flooded_mass == pytest.approx(flooded)
    assert dry_mass(PROBLEM, weight) == pytest.approx(design.dry_mass)


def test_weights_go_through_as_arrays():
    lengths, trims = cylinder_and_trim(PROBLEM, np.array([10.0, 12.0]))
    assert (lengths[1], trims[1]) == pytest.approx(cylinder_and_trim(PROBLEM, 12.0))


@given(st.floats(0.0, 1.0), st.floats(0.01, 1.0))
def test_cap_of_a_volume(share, radius):
    volume = share * 2 / 3 * math.pi * radius**3
    height = cap_height(volume, radius)
    assert 0.0 <= height <= radius * (1 + 1e-9)
    assert math.pi * height**2 * (3 * radius - height) / 3 == pytest.approx(volume, rel=1e-6, abs=1e-12 * radius**3)
    assert -1e-12 <= cap_centroid(height, radius) <= height + 1e-12


def test_half_a_sphere_has_its_centroid_at_three_eighths():
    assert cap_centroid(1.0, 1.0) == pytest.approx(5 / 8)
    assert cap_centroid(1e-6, 1.0) == pytest.approx(2 / 3 * 1e-6, rel=1e-3)


def test_displacement_centroid_against_quadrature():
    height = cap_height(PROBLEM.overlap_volume, PROBLEM.nose_radius)
    r, c = PROBLEM.radius, 0.1
    x = (np.arange(400_000) + 0.5) / 400_000 * (r + c)
    outer = np.where(x < r, r**2 - (r - x) ** 2, r**2)
    into = x - (r + c - height)
    inner = np.where(into > 0, 2 * PROBLEM.nose_radius * into - into**2, 0.0)
    expected = np.sum((outer - inner) * x) / np.sum(outer - inner)
    assert displacement_centroid(PROBLEM, c) == pytest.approx(expected, rel=1e-6)


def test_more_overlap_than_the_nose_holds_is_refused():
    with pytest.raises(ValueError, match="at most"):
        cap_height(1.0, 0.06)


def test_a_ring_of_negative_mass_is_reported_with_its_amount():
    design = solve_anchor(PROBLEM, 6.0)
    assert not design.feasible
    assert design.failures[0].condition == "trim_mass >= 0"
    assert design.failures[0].amount == pytest.approx(-design.trim_mass)
    low, high = buildable_weights(PROBLEM)
    assert 6.0 < low < 11.7 < high


def test_a_ring_outside_the_tube_is_remedied_by_a_change_of_the_front():
    nose_heavy = replace(PROBLEM, construction=replace(MADE, front=Part(0.9, 7850.0, 1.2 * INCH)))
    design = solve_anchor(nose_heavy, 11.6974)
    assert [failure.condition for failure in design.failures] == ["ring inside the tube"]
    assert "behind the tube" in design.failures[0].words
    remedies = find_remedies(design)
    assert remedies[0].part == "front"
    mended = replace(MADE, front=replace(nose_heavy.construction.front, mass=remedies[0].needed))
    assert solve_anchor(replace(nose_heavy, construction=mended), 11.6974).feasible
    told = float(remedies[0].words.split(" instead of ")[0].split()[-2])  # rounded to the side that does
    assert told <= remedies[0].needed < remedies[0].given
    least = replace(mended, front=replace(mended.front, mass=remedies[0].needed * 1.01))
    assert not solve_anchor(replace(nose_heavy, construction=least), 11.6974).feasible


@pytest.mark.parametrize(("mass", "at", "back", "is_remedy"), [(1.0, 0.03, 0.4, True), (1.3, 0.026, 0.05, False)])
def test_the_front_s_centre_is_moved_no_farther_than_its_half_sphere_reaches(mass, at, back, is_remedy):
    made = replace(MADE, front=Part(mass, 7850.0, at), back=replace(MADE.back, mass=back))
    found = find_remedies(solve_anchor(replace(PROBLEM, construction=made), 11.7))
    assert any(each.quantity == "its centre at" for each in found) == is_remedy


def test_no_room_for_a_tube():
    heavy = replace(
        PROBLEM, construction=replace(MADE, front=Part(0.05, 7850.0, 0.03), back=Part(0.05, 2700.0, 0.0152))
    )
    design = solve_anchor(heavy, 0.1)
    assert any(failure.condition == "cylinder_length > 0" for failure in design.failures)
    assert any("mm" in failure.words for failure in design.failures)


def test_a_feasible_anchor_needs_no_remedy():
    assert find_remedies(solve_anchor(PROBLEM, 11.7)) == ()


def test_parallel_balances_are_refused():
    made = replace(MADE, tube_mass_per_length=PROBLEM.water_density * math.pi * PROBLEM.radius**2, tube_density=1026.02)
    with pytest.raises(ValueError, match="same ratio"):
        solve_anchor(replace(PROBLEM, construction=made), 10.0)
