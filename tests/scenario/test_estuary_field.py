"""The field of ``missions/estuary.yaml`` is what its script computes, and that conserves water."""

import functools
import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray
from scipy.integrate import trapezoid

FOLDER = Path(__file__).parents[2] / "missions" / "currents"
HOUR = 3600.0


@pytest.fixture(scope="module")
def estuary():
    spec = importlib.util.spec_from_file_location("estuary_script", FOLDER / "estuary.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    module.wave = functools.cache(module.wave)
    yield module
    del sys.modules[spec.name]


def level(estuary, t, x):
    """Of the water, from the waves' own levels between the sections."""
    total = np.zeros((t.size, x.size))
    for numbers in estuary.CONSTITUENTS.values():
        wave = estuary.wave(*numbers)
        middle = 0.5 * (wave.x[1:] + wave.x[:-1])
        at = np.interp(x, middle, wave.level.real) + 1j * np.interp(x, middle, wave.level.imag)
        total += (np.exp(1j * wave.omega * t)[:, None] * at).real
    return total


def test_what_flows_in_raises_the_level(estuary):
    t, x, y = 600.0 * np.arange(150), np.arange(4000.0, 8000.0, 25.0), np.linspace(-250.0, 250.0, 41)
    east, north = estuary.velocity(t, x, y)
    gained = -estuary.DEPTH * (np.gradient(east, x, axis=2) + np.gradient(north, y, axis=1))
    rising = np.gradient(level(estuary, t, x), t, axis=0)
    inner = (slice(2, -2), slice(2, -2), slice(4, -4))
    errors = gained[inner] - rising[inner[0], None, inner[2]]
    assert np.abs(errors).max() < 0.05 * np.abs(rising).max()


def test_no_water_crosses_the_banks(estuary):
    t, x = HOUR * np.arange(13), np.array([4500.0, 5600.0, 6400.0, 8000.0])
    for each in x:
        bank = 0.5 * estuary.width(np.array([each - 1.0, each, each + 1.0]))
        east, north = (
            part[:, 0, 0] for part in estuary.velocity(t, np.array([each]), np.array([bank[1] * (1 - 1e-9)]))
        )
        np.testing.assert_allclose(north, east * (bank[2] - bank[0]) / 2.0, atol=1e-6)


def test_a_section_carries_the_wave_and_the_river(estuary):
    t, x = HOUR * np.arange(25), np.array([6000.0])
    half = 0.5 * estuary.width(x)[0]
    y = np.linspace(-half, half, 2001) * (1 - 1e-12)
    east, _ = estuary.velocity(t, x, y)
    carried = trapezoid(east[:, :, 0], y, axis=1) * estuary.DEPTH
    expected = np.full(t.size, -estuary.RIVER)
    for numbers in estuary.CONSTITUENTS.values():
        wave = estuary.wave(*numbers)
        flow = wave.flow[np.argmin(np.abs(wave.x - 6000.0))]
        expected += (np.exp(1j * wave.omega * t) * flow).real
    np.testing.assert_allclose(carried, expected, rtol=1e-5, atol=1e-2)


def test_the_phase_lags_up_the_estuary_and_the_narrows_are_fastest(estuary):
    wave = estuary.wave(*estuary.CONSTITUENTS["M2"])
    lag = -np.angle(wave.level)
    assert np.all(np.diff(lag) > 0.0)
    speed = np.abs(wave.flow) / estuary.width(wave.x)
    about = (wave.x > 3000.0) & (wave.x < 9000.0)
    assert abs(wave.x[about][np.argmax(speed[about])] - 6000.0) < 200.0


def test_the_profile_has_the_mean_of_the_column(estuary):
    depth = np.linspace(0.0, estuary.DEPTH, 100_001)
    assert trapezoid(estuary.profile(depth), depth) / estuary.DEPTH == pytest.approx(1.0, abs=3e-3)


def test_the_file_is_what_the_script_writes(estuary):
    expected = estuary.field()
    with xarray.open_dataset(FOLDER / "estuary.nc") as found:
        for name in ("u", "v"):
            np.testing.assert_allclose(found[name].values, expected[name].values, atol=6e-5)
        assert (found["time"].values == expected["time"].values).all()
