"""Slow modulation of an oscillating current: its functions, its inference, and its draws."""

from dataclasses import replace

import numpy as np
import pytest

from missionplan import diagnose, load
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.legs.kind import transit_model
from missionplan.diagnosis.legs.likelihood.modulation import (
    LENGTH_OF_TIME,
    modulated_columns,
    smooth_functions,
    variance_of_mean,
)
from missionplan.effects import CATALOGUE
from missionplan.phases.hooks import Leg
from missionplan.physics.water import angular_frequencies
from tests.hidden_effects.legs import random_records
from tests.learned import likeliest, moments

DAY = 86400.0
T = np.linspace(0.0, 20.0 * DAY, 90)
M2 = 2.0 * np.pi / (12.4206012 * 3600.0)
KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}


def test_functions_have_the_squared_exponential_covariance_less_the_mean_over_the_record():
    modulation, functions = smooth_functions("tidal-current", T)
    time = 6.0 * DAY
    sd = modulation.sd(0.4, time)[: functions.shape[1]]
    kernel = 0.16 * np.exp(-0.5 * ((T[:, None] - T) / (LENGTH_OF_TIME * time)) ** 2)
    centred = np.eye(len(T)) - 1.0 / len(T)
    np.testing.assert_allclose((functions * sd) @ (functions * sd).T, centred @ kernel @ centred, atol=0.016)
    np.testing.assert_allclose(functions.mean(axis=0), 0.0, atol=1e-12)


def test_a_short_record_needs_few_functions():
    assert smooth_functions("", T[:5])[1].shape[1] < smooth_functions("", T)[1].shape[1]


def test_columns_are_the_real_part_of_the_product():
    """Re(ε·w) with w the complex oscillation whose real part is in phase."""
    phase = 2.0 * np.pi * T / 45000.0
    w = 0.1 * np.exp(1j * phase) * np.array([[1.0], [1j]])
    later = w * np.exp(-0.5j * np.pi)
    functions = smooth_functions("", T)[1]
    rng = np.random.default_rng(4)
    real, imaginary = rng.normal(size=(2, functions.shape[1]))
    epsilon = functions @ real - 1j * (functions @ imaginary)
    found = modulated_columns(functions, w.real, later.real) @ np.concatenate([real, imaginary])
    np.testing.assert_allclose(found, (epsilon * w).real, atol=1e-12)


def test_variance_of_the_mean_over_the_record():
    assert variance_of_mean(T, 0.3, 1e6 * DAY) == pytest.approx(0.09)
    assert variance_of_mean(T, 0.3, 0.001 * DAY) == pytest.approx(0.09 / len(T))


def leg_at(t, trials):
    ones = np.ones(trials)
    return Leg(t * ones, 600.0 * ones, np.zeros((2, trials)), np.array([[0.0], [1.0]]) * ones, 1.0, np.radians(40.0))


@pytest.mark.parametrize("name", ["tidal-current", "inertial-current"])
def test_draws_have_the_stated_size_and_time(name):
    """Over many trials: variance of what is added, and its correlation after a coherence time in the same phase."""
    trials, time = 40_000, 3.0 * DAY
    sizes = (
        {"m2_east": 0.5, "m2_north": 0.5, "m2_north_phase": 0.5 * np.pi}
        if name == "tidal-current"
        else {"amplitude": 0.5}
    )
    effect = CATALOGUE[name].make({**sizes, "modulation": 0.4, "coherence_time": time})
    assert effect.is_random
    rng = np.random.default_rng(1)
    elapsed = np.full(trials, time)
    memory, first = effect.step(None, 0.0 * elapsed, rng.normal(size=(2, trials)), leg_at(0.0, trials))
    _, second = effect.step(memory, elapsed, rng.normal(size=(2, trials)), leg_at(0.0, trials))
    size = np.hypot(*effect.velocity(leg_at(0.0, 1))[:, 0])
    expected = 0.16 * (size**2 + np.hypot(*effect.later().velocity(leg_at(0.0, 1))[:, 0]) ** 2)
    assert np.mean(np.sum(first**2, axis=0)) == pytest.approx(expected, rel=0.02)
    assert np.mean(np.sum(second**2, axis=0)) == pytest.approx(expected, rel=0.02)
    assert np.mean(np.sum(first * second, axis=0)) / expected == pytest.approx(np.exp(-1.0), abs=0.02)


def test_a_steady_oscillation_draws_nothing():
    effect = CATALOGUE["tidal-current"].make({"m2_east": 0.5})
    assert not effect.is_random
    assert effect.step(None, np.zeros(1), np.zeros((2, 1)), leg_at(0.0, 1)) == (None, 0.0)


def test_later_is_a_quarter_of_a_period_later():
    for name, sizes, omega in (
        ("tidal-current", {"m2_east": 0.3, "m2_east_phase": 0.4}, M2),
        ("inertial-current", {"amplitude": 0.3, "phase": 0.4}, 2.0 * 7.2921159e-5 * np.sin(np.radians(40.0))),
    ):
        effect = CATALOGUE[name].make(sizes)
        quarter = 0.5 * np.pi / omega
        np.testing.assert_allclose(
            effect.later().velocity(leg_at(quarter, 1)), effect.velocity(leg_at(0.0, 1)), atol=1e-12
        )


def tide(amplitude, change=None):
    def error(t, heading):
        factor = 1.0 if change is None else change(t)
        return np.stack([amplitude * np.cos(M2 * t - 0.7), 0.5 * amplitude * np.cos(M2 * t - 2.0)]) * factor

    return error


@pytest.mark.slow
@pytest.mark.parametrize("amplitude", [0.04, 0.2, 1.0])
def test_a_steady_tide_comes_out_steady(amplitude, folder, transit_mission, legs):
    """From a third of the usual size to eight times: to within its interval and 5 %, and without modulation."""
    table = legs(240, error=tide(amplitude), lasting=3.0)
    found = diagnose(transit_mission, folder(KIND, table), plan=False)
    assert found.causes == ("tidal-current",)
    estimates = {p.name: p for p in found.best.parameters}
    assert "modulation" not in estimates
    for name, truth in (("m2_east", amplitude), ("m2_north", 0.5 * amplitude)):
        assert abs(estimates[name].value - truth) < max(0.05 * truth, 2.5 * estimates[name].sd)
        assert estimates[name].sd < 0.01


def test_a_steady_tide_is_measured_and_not_modulated(folder, transit_mission, legs):
    bound = transit_model(
        read_transit(folder(KIND, legs(120, error=tide(0.2), lasting=3.0)), transit_mission), transit_mission, 1
    )
    found = bound.fit(("tidal-current",))
    estimates = {each.name: each for each in found.estimates}
    assert "modulation" not in estimates
    for name, truth in (("m2_east", 0.2), ("m2_north", 0.1)):
        assert abs(estimates[name].value - truth) < max(0.05 * truth, 2.5 * estimates[name].sd)
    assert found.log_evidence > bound.fit(()).log_evidence + 50.0


def test_columns_of_a_modulation_are_of_the_tide_and_of_the_tide_a_quarter_of_its_period_later(
    folder, transit_mission, legs
):
    data = read_transit(folder(KIND, legs(30, error=tide(0.2), lasting=3.0)), transit_mission)
    bound = transit_model(data, transit_mission, 1)
    sizes = {"m2_east": (0.3, 0.4), "m2_north": (0.2, 2.0)}
    about = np.zeros(len(bound.coordinates))
    for place in bound.by_effect["tidal-current"]:
        coordinate = bound.coordinates[place]
        amplitude, phase = sizes.get(coordinate.name, (0.0, 0.0))
        about[place] = amplitude * {"cosine": np.cos, "sine": np.sin}[coordinate.kind](phase)
    phases = {f"{name}_phase": phase for name, (_, phase) in sizes.items()}
    effect = CATALOGUE["tidal-current"].make({name: size for name, (size, _) in sizes.items()} | phases)
    errors = (bound.axes.T @ bound.velocity_error([each]) for each in (effect, effect.later()))
    expected = modulated_columns(smooth_functions("tidal-current", data.middle)[1], *errors)
    _, found = bound._modulation_columns("tidal-current", about)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_month_tells_n2_from_m2(folder, transit_mission, legs):
    """A perigean constituent of a fifth of M2, which a fortnight cannot resolve, comes out beside it."""
    n2 = float(angular_frequencies(["N2"])[0])

    def error(t, heading):
        wave = 0.04 * np.cos(n2 * t - 1.1)
        return tide(0.2)(t, heading) + np.stack([wave, np.zeros_like(wave)])

    table = legs(520, error=error, lasting=6.0)
    data = read_transit(folder(KIND, table), transit_mission)
    fit = transit_model(data, transit_mission, 1).fit(("tidal-current",))
    estimates = {p.name: p for p in fit.estimates}
    assert "modulation" not in estimates
    for name, truth in (("m2_east", 0.2), ("m2_north", 0.1), ("n2_east", 0.04), ("n2_east_phase", 1.1)):
        assert abs(estimates[name].value - truth) < 3.0 * estimates[name].sd + 0.02 * truth  # a leg's middle, not mean
    assert estimates["n2_east"].sd < 0.005
    assert estimates["n2_north"].low == pytest.approx(0.0, abs=0.002)


@pytest.mark.slow
def test_a_tide_that_changes_over_days_is_modulated(folder, transit_mission, legs):
    """Springs and neaps unresolved: the extended mission carries the modulation, and simulates it."""

    def change(t):
        return 1.0 + 0.5 * np.cos(2.0 * np.pi * t / (9.0 * DAY))

    table = legs(300, error=tide(0.4, change), lasting=3.0)
    found = diagnose(transit_mission, folder(KIND, table), plan=False)
    assert found.causes == ("tidal-current",)
    assert ("tidal-current", "coherence_time") in likeliest(found.extended).columns
    assert 0.15 < moments(found.extended, "tidal-current", "modulation")[0] < 0.8


def test_modulation_of_zero_is_neutral():
    still, moving = (CATALOGUE["tidal-current"].make({"m2_east": 0.5, "modulation": m}) for m in (0.0, 0.3))
    assert still == replace(moving, modulation=0.0)


def test_an_oscillation_that_wanders_has_the_covariance_of_the_process():
    """Mean over the record and functions about it, together: the kernel, but for the covariance of the two."""
    modulation, functions = smooth_functions("", T)
    wandering = replace(modulation, wanders_over=T)
    time = 6.0 * DAY
    assert wandering.keys == (("", "slab scale"), ("", "coherence_time"))
    assert wandering.mean_sd(time) == pytest.approx(np.sqrt(variance_of_mean(T, 1.0, time)))
    assert modulation.mean_sd(time) == 1.0
    sd = wandering.sd(1.0, time)[: functions.shape[1]]
    total = (functions * sd) @ (functions * sd).T + wandering.mean_sd(time) ** 2
    assert np.mean(np.diag(total)) == pytest.approx(1.0, abs=0.05)


def test_an_inertial_current_that_wanders_is_found_beside_persistent_errors(tmp_path):
    """3 cm/s whose amplitude wanders within ten days, of which its own law has 10.7 nats."""
    case = random_records.wandering(6007)
    mission, folder = case.write(tmp_path / "case", tmp_path / "truth")
    loaded = load(mission)
    model = transit_model(read_transit(folder, loaded), loaded, 1)
    alone, both = model.fit(("persistent-error",)), model.fit(("inertial-current", "persistent-error"))
    assert both.state.forms.wandering == ("inertial-current",)
    assert both.log_evidence - alone.log_evidence > 4.0
    estimates = {p.name: p for p in both.estimates}
    assert 0.0 < estimates["amplitude"].value * np.hypot(1.0, estimates["modulation"].value) < 0.08
    assert estimates["coherence_time"].low < 10.0 * DAY
    assert both.possible
