"""The tide that is hidden in made records, whose tides come from the astronomy of another derivation."""

import json
import math
from datetime import UTC, datetime

import numpy as np
import pandas as pd
import pytest
import scipy

import missionplan
from missionplan.errors import InputError
from missionplan.studies.tide.harmonic_analysis import Samples, ellipse_errors, fit_residual, fit_tide, tidal_velocity

DAY = 86400.0
# Doodson numbers (lunar time, s, h, p) and the constant in degrees: Schureman (1958), table 2.
DOODSON = {
    "M2": (2, 0, 0, 0, 0.0),
    "S2": (2, 2, -2, 0, 0.0),
    "N2": (2, -1, 0, 1, 0.0),
    "K2": (2, 2, 0, 0, 0.0),
    "K1": (1, 1, 0, 0, -90.0),
    "O1": (1, -1, 0, 0, 90.0),
    "P1": (1, 1, -2, 0, 90.0),
    "Q1": (1, -2, 0, 1, 90.0),
}
MOON = ("M2", "N2")


def node_of(names, days):
    """Schureman's node factors and angles by his series in the node's longitude, of the constituents used here."""
    node = math.radians(125.04452 - 0.0529537648 * days)
    factors = {
        "M2": (1.0004 - 0.0373 * math.cos(node) + 0.0002 * math.cos(2 * node), -2.14 * math.sin(node)),
        "N2": (1.0004 - 0.0373 * math.cos(node) + 0.0002 * math.cos(2 * node), -2.14 * math.sin(node)),
        "O1": (1.0089 + 0.1871 * math.cos(node) - 0.0147 * math.cos(2 * node), 10.80 * math.sin(node)),
        "Q1": (1.0089 + 0.1871 * math.cos(node) - 0.0147 * math.cos(2 * node), 10.80 * math.sin(node)),
        "K1": (1.0060 + 0.1150 * math.cos(node) - 0.0088 * math.cos(2 * node), -8.86 * math.sin(node)),
        "K2": (1.0241 + 0.2863 * math.cos(node) + 0.0083 * math.cos(2 * node), -17.74 * math.sin(node)),
        "S2": (1.0, 0.0),
        "P1": (1.0, 0.0),
    }
    return {name: factors[name] for name in names}


def argument(name, seconds):
    """Equilibrium argument at Greenwich [rad], by the mean longitudes of Meeus for the epoch J2000."""
    days = seconds / DAY + 2440587.5 - 2451545.0
    moon, sun, perigee = 218.3164477 + 13.17639648 * days, 280.46646 + 0.98564736 * days, 83.3532465 + 0.11140353 * days
    lunar_time = 360.0 * ((seconds / DAY) % 1.0) + 180.0 + sun - moon  # τ, from lower transit
    turns, s, h, p, constant = DOODSON[name]
    return np.radians(turns * lunar_time + s * moon + h * sun + p * perigee + constant)


def made_tide(ellipses, seconds):
    """East and north of ellipses (major, minor, direction from east, Greenwich lag) [m/s]."""
    total = np.zeros((2, len(seconds)))
    nodes = node_of(ellipses, float(np.mean(seconds)) / DAY + 2440587.5 - 2451545.0)
    for name, (major, minor, inclination, lag) in ellipses.items():
        factor, angle = nodes[name]
        turned = argument(name, seconds) + math.radians(angle) - lag
        spin = factor * (major * np.cos(turned) + 1j * minor * np.sin(turned)) * np.exp(1j * inclination)
        total += np.stack((spin.real, spin.imag))
    return total


def drawn_ellipses(rng):
    """Eight constituents of a shelf sea; K2 and P1 near what the equilibrium tide makes them."""
    sizes = {"M2": 0.4, "S2": 0.13, "N2": 0.08, "K1": 0.07, "O1": 0.05, "Q1": 0.012}
    found = {
        name: (
            size * rng.uniform(0.6, 1.4),
            size * rng.uniform(-0.4, 0.4),
            rng.uniform(0.0, math.pi),
            rng.uniform(0.0, 2.0 * math.pi),
        )
        for name, size in sizes.items()
    }
    for name, reference, ratio in (("K2", "S2", 0.272), ("P1", "K1", 0.331)):
        major, minor, inclination, lag = found[reference]
        share = ratio * rng.uniform(0.9, 1.1)
        found[name] = (share * major, share * minor, inclination, lag + rng.normal(0.0, 0.1))
    return found


def weather(rng, seconds, sd, lasting):
    """An Ornstein–Uhlenbeck process in both components, by its exact recursion."""
    values = np.zeros((2, len(seconds)))
    values[:, 0] = rng.normal(0.0, sd, 2)
    steps = np.exp(-np.diff(seconds) / lasting)
    for k, share in enumerate(steps):
        values[:, k + 1] = share * values[:, k] + rng.normal(0.0, sd * math.sqrt(1.0 - share**2), 2)
    return values


def made_record(seed, *, step=1800.0, days=60.0):
    rng = np.random.default_rng(seed)
    begins = datetime(2026, 1, 1, tzinfo=UTC).timestamp() + rng.uniform(0.0, 700.0) * DAY
    seconds = begins + np.arange(0.0, days * DAY, step)
    tide = made_tide(drawn_ellipses(rng), seconds)
    sd = math.sqrt(0.1 / 0.9 * np.mean(np.var(tide, axis=1)))
    mean = rng.normal(0.0, 0.04, (2, 1))
    return seconds, tide + mean, weather(rng, seconds, sd, rng.uniform(1.0, 8.0) * 3600.0), rng


def with_gaps(rng, seconds):
    kept = np.ones(len(seconds), dtype=bool)
    for _ in range(4):
        begins = seconds[0] + rng.uniform(0.0, 28.0) * DAY
        kept &= ~((seconds > begins) & (seconds < begins + rng.uniform(0.2, 1.5) * DAY))
    return kept


@pytest.mark.parametrize("records", [2, pytest.param(5, marks=pytest.mark.slow)])
def test_a_month_forecasts_the_next(records):
    lost, inside, latitude = [], [], math.radians(37.2)
    for seed in range(601, 601 + records):
        seconds, known, noise, rng = made_record(seed)
        first = seconds < seconds[0] + 30.0 * DAY
        taken = first & with_gaps(rng, seconds)
        fit = fit_tide(Samples(seconds[taken], (known + noise)[:, taken], latitude))
        forecast = fit.mean[:, None] + tidal_velocity(fit.constituents, seconds[~first], latitude)
        truth = known[:, ~first]
        lost.append(np.mean((forecast - truth) ** 2) / np.mean(truth**2))
        inside.append(np.mean(np.abs(forecast - truth - noise[:, ~first]) < 1.645 * fit.spread))
    assert np.mean(lost) < 0.02
    assert np.max(lost) < 0.03
    assert 0.85 < np.mean(inside) < 0.95


def test_ellipses_come_out_as_they_went_in():
    seconds = datetime(2026, 2, 1, tzinfo=UTC).timestamp() + np.arange(0.0, 60.0 * DAY, 3600.0)
    given = {
        "M2": (0.4, -0.1, 0.6, 1.2),
        "S2": (0.15, 0.05, 2.5, 4.0),
        "K2": (0.2723 * 0.15, 0.2723 * 0.05, 2.5, 4.0),
        "K1": (0.1, 0.02, 1.0, 0.3),
        "P1": (0.3309 * 0.1, 0.3309 * 0.02, 1.0, 0.3),
        "O1": (0.06, 0.0, 0.2, 5.0),
    }
    noise = np.random.default_rng(7).normal(0.0, 0.01, (2, len(seconds)))
    fit = fit_tide(Samples(seconds, made_tide(given, seconds) + noise, 0.8))
    found = {wave.name: wave for wave in fit.constituents}
    for name, (major, minor, inclination, lag) in given.items():
        wave = found[name]
        # node factors by Schureman's series differ from UTide's satellites by up to 1.5 %
        assert wave.major == pytest.approx(major, rel=0.02, abs=0.002)
        assert wave.minor == pytest.approx(minor, rel=0.02, abs=0.003)
        turned = math.remainder(wave.toward - (0.5 * math.pi - inclination), math.pi)
        assert turned == pytest.approx(0.0, abs=0.05)
        behind = 2.0 * math.remainder(wave.phase - lag, math.pi)  # either end of the major axis
        assert behind == pytest.approx(0.0, abs=0.12)


def test_noise_alone_gives_no_tide_and_its_own_spread():
    seconds = np.arange(0.0, 20.0 * DAY, 3600.0) + 1.78e9
    noise = weather(np.random.default_rng(11), seconds, 0.05, 3.0 * 3600.0)
    fit = fit_tide(Samples(seconds, noise, 0.7))
    assert sum(math.hypot(wave.major, wave.minor) for wave in fit.constituents if not wave.inferred_from) < 0.04
    assert fit.spread == pytest.approx(0.05, rel=0.2)


def test_the_residual_is_an_ornstein_uhlenbeck_process_at_any_times():
    rng = np.random.default_rng(3)
    seconds = np.cumsum(rng.exponential(900.0, 6000))
    found = fit_residual(seconds, *weather(rng, seconds, 0.07, 2.0 * 3600.0))
    assert found.sd == pytest.approx(0.07, rel=0.1)
    assert found.time == pytest.approx(7200.0, rel=0.25)
    # the spectral density integrates to the variance: ∫P dω/2π
    omega = np.linspace(-0.1, 0.1, 2_000_001)
    assert scipy.integrate.trapezoid(found.density(omega), omega) / (2.0 * math.pi) == pytest.approx(
        found.sd**2, rel=0.01
    )


@pytest.mark.parametrize("minor", [0.02, 0.15, 0.19])
def test_errors_of_an_ellipse_are_those_of_its_sampled_coefficients(minor):
    major, sd = 0.2, 0.001
    rng = np.random.default_rng(5)
    a, b, c, d = np.array([[major], [0.0], [0.0], [minor]]) + rng.normal(0.0, sd, (4, 20000))
    plus, minus = 0.5 * (a + d + 1j * (c - b)), 0.5 * (a - d + 1j * (c + b))
    axis, angle = ellipse_errors(major, minor, sd**2)
    assert np.std(np.abs(plus) + np.abs(minus)) == pytest.approx(axis, rel=0.03)
    assert np.std(np.abs(plus) - np.abs(minus)) == pytest.approx(axis, rel=0.03)
    assert np.std(0.5 * (np.angle(plus) + np.angle(minus))) == pytest.approx(angle, rel=0.03)


def test_a_circle_has_no_direction():
    assert ellipse_errors(0.2, 0.2, 1e-6)[1] == pytest.approx(math.pi / math.sqrt(3.0))


def write_record(path, *, days=4.0, **cells):
    seconds = np.arange(0.0, days * DAY, 1800.0)
    begins = datetime(2026, 4, 1, tzinfo=UTC).timestamp()
    wave = 0.3 * np.cos(2.0 * np.pi * seconds / 44714.0)
    noise = np.random.default_rng(1).normal(0.0, 0.01, (2, len(seconds)))
    frame = pd.DataFrame(
        {
            "t_s": [datetime.fromtimestamp(begins + t, UTC).isoformat() for t in seconds],
            "depth_m": 8.0,
            "east_m_s": wave + noise[0],
            "north_m_s": 0.5 * wave + noise[1],
        }
    )
    frame = frame.assign(**cells)
    frame.to_csv(path, index=False)
    return frame


def test_the_report_has_a_fragment_and_constituents(tmp_path):
    write_record(tmp_path / "mooring.csv")
    for _ in range(2):
        result = missionplan.tide(tmp_path / "mooring.csv", latitude=0.65)
    assert len(repr(result)) < 3000
    assert result.plot().get_xlabel() == "east (m/s)"
    assert result.plot.record(component="north").get_ylabel() == "north (m/s)"
    result.save(tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["depths"][0]["constituents"]["M2"]["major_m_s"] == pytest.approx(
        0.335 / 0.968, rel=0.02
    )  # the node's f in 2026
    assert summary["depths"][0]["held_out"] is None  # four days are too few to hold any out
    assert "M2" in (tmp_path / "out" / "tide.yaml").read_text()
    page = (tmp_path / "out" / "report.html").read_text()
    assert "the 14.8\u00a0days that tell M2" in page


def test_latitude_and_start_may_be_text_as_on_the_command_line(tmp_path):
    frame = write_record(tmp_path / "mooring.csv")
    seconds = frame.assign(t_s=np.arange(len(frame)) * 1800.0)
    seconds.to_csv(tmp_path / "since.csv", index=False)
    dated = missionplan.tide(tmp_path / "mooring.csv", latitude="0.65 rad")
    since = missionplan.tide(tmp_path / "since.csv", latitude=0.65, start="2026-04-01T00:00:00Z")
    assert since.depths[0].constituents == dated.depths[0].constituents


@pytest.mark.parametrize(
    ("cells", "options", "message"),
    [
        ({}, {}, "at which latitude"),
        ({"east_m_s": 99.0}, {"latitude": 0.6}, "impossible"),
        ({"t_s": 3.0}, {"latitude": 0.6}, "since when"),
        ({"t_s": "noon"}, {"latitude": 0.6}, "expected a time and a depth"),
        ({"north_m_s": "fast"}, {"latitude": 0.6}, "expected a number"),
        ({}, {"latitude": 37.2}, "between −90° and 90°"),
        ({"depth_m": 8e6}, {"latitude": 0.6}, "impossible"),
        ({"depth_m": -8.0}, {"latitude": 0.6}, "impossible; expected a depth of 0 to"),
        ({"east_m_s": math.nan}, {"latitude": 0.6}, "too short for a tide"),
        ({}, {"latitude": "37.2 furlong"}, "furlong"),
        ({}, {"latitude": 0.6, "start": "yesterday"}, "expected a time such as"),
    ],
)
def test_what_is_wrong_is_told(tmp_path, cells, options, message):
    write_record(tmp_path / "mooring.csv", **cells)
    with pytest.raises(InputError, match=message):
        missionplan.tide(tmp_path / "mooring.csv", **options)


def test_a_profiler_in_netcdf_brings_its_latitude(tmp_path):
    xarray = pytest.importorskip("xarray")
    frame = write_record(tmp_path / "mooring.csv")
    moments = pd.to_datetime(frame["t_s"]).dt.tz_localize(None).to_numpy().astype("datetime64[ns]")
    wave = frame["east_m_s"].to_numpy()
    gaps = np.where(np.arange(len(wave)) % 7, 0.8 * wave, math.nan)
    xarray.Dataset(
        {
            "u": (
                ("time", "depth"),
                np.stack((np.where(moments < moments[20], wave, math.nan), gaps, wave), axis=1),
                {"units": "m s-1"},
            ),
            "v": (("time", "depth"), np.stack((wave, 0.4 * wave, 0.5 * wave), axis=1), {"units": "m s-1"}),
        },
        coords={"time": moments, "depth": ("depth", [4.0, 12.0, 8.0], {"units": "m"}), "latitude": 37.2},
    ).to_netcdf(tmp_path / "adcp.nc")
    result = missionplan.tide(tmp_path / "adcp.nc")
    majors = {each.depth: each.constituents[0].major for each in result.depths}
    assert majors == {8.0: majors[8.0], 12.0: pytest.approx(0.8 * majors[8.0], rel=0.03)}
    assert result.provenance.notices == ("too few samples for a tide at 4 m",)
    assert result.shown_depth == 8.0  # that of most samples
    np.testing.assert_allclose(result.measured, np.stack((wave, 0.5 * wave)))
    assert np.std(result.fitted - result.measured) < 0.1 * np.std(wave)
    assert math.degrees(result.latitude) == pytest.approx(37.2)


def test_a_sample_counts_up_to_six_standard_deviations_of_what_the_tide_leaves():
    """The deviation is that of normal numbers, whatever measures it: spikes of 5.2 of them stay, of 7 go."""
    rng = np.random.default_rng(3)
    hours = np.arange(24 * 20)
    velocity = 0.05 * rng.standard_normal((2, hours.size))
    velocity[0, [100, 200, 300]] = 0.05 * np.array([5.2, -7.0, 7.0])
    fit = fit_tide(Samples(3600.0 * hours, velocity, 0.8))
    assert sorted(set(hours) - set(np.round(fit.samples.time / 3600.0).astype(int))) == [200, 300]
