"""Numbers of `identify` against closed forms: weighted means, springs, a model's scale, the table it is compared with."""

import math

import numpy as np
import pytest
import yaml
from scipy import stats

from missionplan.studies.identification import identify


def folder(tmp_path, settings, **tables):
    for name, columns in tables.items():
        rows = zip(*columns.values(), strict=True)
        (tmp_path / f"{name}.csv").write_text("\n".join([",".join(columns), *(",".join(map(str, r)) for r in rows)]))
    (tmp_path / "dataset.yaml").write_text(yaml.safe_dump({"file": "data.csv", **settings}))
    return tmp_path


AREA, LENGTH, DENSITY, VISCOSITY = 0.08, 0.5, 1020.0, 1.25e-6
TOWED = {
    "kind": "drag",
    "reference_area": f"{AREA} m^2",
    "reference_length": f"{LENGTH} m",
    "scale": 3.0,
    "water": {"density": f"{DENSITY} kg/m^3", "viscosity": f"{VISCOSITY} m^2/s"},
}
SPEED = np.array([0.2, 0.3, 0.4, 0.5, 0.6, 0.8])
SCATTER = np.array([1.0, -1.0, -0.5, 0.75, 1.0, -1.0])
PER_COEFFICIENT = 0.5 * DENSITY * AREA * SPEED**2


@pytest.mark.parametrize(("stated", "by_row"), [(None, False), (0.05, False), (0.02, False), (0.05, True)])
def test_a_drag_coefficient_is_a_weighted_mean_with_students_interval(stated, by_row, tmp_path):
    """C = Σ w F g/Σ w g² with g the force of C = 1; errors only ever widen to the scatter."""
    force = 1.5 * PER_COEFFICIENT + 0.03 * SCATTER
    sd = np.full(6, stated or 1.0) * (np.linspace(0.7, 1.3, 6) if by_row else 1.0)
    columns = {"speed_m_s": SPEED, "force_n": force} | ({"force_sd_n": sd} if by_row else {})
    noise = {"noise": {"force": f"{stated} N"}} if stated and not by_row else {}
    found = identify(folder(tmp_path, {**TOWED, **noise}, data=columns))
    weight = 1.0 / sd**2
    information = np.sum(weight * PER_COEFFICIENT**2)
    value = np.sum(weight * force * PER_COEFFICIENT) / information
    chi_squared = np.sum(weight * (force - value * PER_COEFFICIENT) ** 2)
    error = math.sqrt((chi_squared / 5 if stated is None else max(chi_squared / 5, 1.0)) / information)
    (best, _), half = found.fits, stats.t.ppf(0.95, 5) * error
    got = found["drag_coefficient"]
    assert best.name == "constant drag coefficient"
    assert (got.value, got.sd, got.low, got.high) == pytest.approx((value, error, value - half, value + half), rel=1e-6)
    assert best.chi_squared == pytest.approx(chi_squared if stated else math.nan, rel=1e-6, nan_ok=True)
    assert best.residual_sd == pytest.approx(np.sqrt(np.sum((force - value * PER_COEFFICIENT) ** 2) / 5), rel=1e-6)
    assert found.fragment["drag"]["coefficient"] == {"mean": round(value, 4), "sd": round(error, 4)}
    assert found.fragment["drag"]["area"] == f"{9 * AREA:g} m^2"  # of the vehicle, nine times the model's
    assert set(found.fragment["drag"]) == {"coefficient", "area"}


def test_a_drag_that_falls_with_the_reynolds_number_at_full_size(tmp_path):
    reynolds = SPEED * LENGTH / VISCOSITY
    middle = float(f"{np.exp(np.log(reynolds).mean()):.1e}")
    force = PER_COEFFICIENT * 1.5 * (reynolds / middle) ** -0.3 * (1.0 + 1e-3 * SCATTER)
    found = identify(folder(tmp_path, TOWED, data={"speed_m_s": SPEED, "force_n": force}))
    drag = found.fragment["drag"]
    assert (drag["coefficient"]["mean"], drag["exponent"]["mean"]) == pytest.approx((1.5, -0.3), abs=0.003)
    assert (drag["at_reynolds"], drag["length"]) == (middle, f"{3 * LENGTH:g} m")
    assert found.answer.startswith(f"The drag coefficient at Re {middle:.2g} is 1.50")
    panel = found.panels[0]
    np.testing.assert_allclose(panel.x, reynolds, rtol=1e-12)
    np.testing.assert_allclose(panel.y, force / PER_COEFFICIENT, rtol=1e-12)
    np.testing.assert_allclose(panel.fitted, 1.5 * (reynolds / middle) ** -0.3, rtol=5e-3)
    for curve, exponent in zip(panel.curves, (-0.3, 0.0), strict=True):
        low, high = np.log(curve.x[[0, -1]])
        assert (low, high) == pytest.approx(tuple(np.log(reynolds[[0, -1]])))
        assert np.log(curve.y[-1] / curve.y[0]) / (high - low) == pytest.approx(exponent, abs=0.003)


@pytest.mark.parametrize(("other", "area", "words"), [
    (2.0, None, "25.0 % below that of CFD at the same speeds (CFD lies 33.3 % above"),
    (1.2, None, "25.0 % above that of CFD at the same speeds (CFD lies 20.0 % below"),
    (2.0, 2 * AREA, "50.0 % above that of CFD at the same speeds (CFD lies 33.3 % below"),
])  # fmt: skip
def test_a_table_is_compared_at_the_speeds_that_both_have(other, area, words, tmp_path):
    """Coefficients of 1.5 here, and of `other` there on its own area; what both lack in common does not count."""
    speed = np.array([0.3, 0.4, 0.6, 0.7, 0.9])
    factor = np.array([other, other, other, 9.0, 9.0])
    compare = {"name": "CFD", "file": "cfd.csv"} | ({"reference_area": f"{area} m^2"} if area else {})
    data = {"speed_m_s": SPEED, "force_n": 1.5 * PER_COEFFICIENT * (1.0 + 1e-9 * SCATTER)}
    there = {"speed_m_s": speed, "force_n": factor * 0.5 * DENSITY * AREA * speed**2}
    found = identify(folder(tmp_path, {**TOWED, "compare": compare}, data=data, cfd=there))
    assert words in found.remarks[-1]
    curve = found.panels[0].curves[-1]
    np.testing.assert_allclose(curve.x, speed * LENGTH / VISCOSITY)
    np.testing.assert_allclose(curve.y, factor * AREA / (area or AREA))
    found = identify(
        folder(tmp_path, {**TOWED, "compare": compare}, data=data, cfd={k: v[3:] for k, v in there.items()})
    )
    assert found.remarks[-1] == "CFD has no speed in common with the measurement."


def test_added_masses_of_a_model_on_springs(tmp_path):
    """m_ad = k/(2πf)² - m; its error is twice that of f of the whole mass; of the vehicle, scale³ as much."""
    stiffness, mass, scale = 4000.0, 20.0, 2.0
    frequency, error = np.array([1.8, 1.5]), np.array([0.01, 0.02])
    settings = {"kind": "free-oscillation", "stiffness": f"{stiffness} N/m", "mass": f"{mass} kg", "scale": scale}
    data = {"mode": ["surge", "heave"], "frequency_hz": frequency, "frequency_sd_hz": error}
    found = identify(folder(tmp_path, settings, data=data))
    whole = stiffness / (2.0 * np.pi * frequency) ** 2
    for k, mode in enumerate(data["mode"]):
        sd = 2.0 * whole[k] * error[k] / frequency[k]
        got, full = found[f"added_mass_{mode}"], found[f"added_mass_{mode}_full_size"]
        half = stats.norm.ppf(0.95) * sd
        expected = np.array([whole[k] - mass, sd, whole[k] - mass - half, whole[k] - mass + half])
        assert (got.value, got.sd, got.low, got.high) == pytest.approx(tuple(expected), rel=1e-9)
        assert (full.value, full.sd, full.low, full.high) == pytest.approx(tuple(8.0 * expected), rel=1e-9)
        written = found.fragment["added_mass"][mode]
        assert written == {"mean": f"{8.0 * expected[0]:.5g} kg", "sd": f"{8.0 * sd:.3g} kg"}
    one_percent = 0.01 * stiffness / (2.0 * np.pi * frequency.mean()) ** 2
    assert f"one of {one_percent:.2f} kg in the added mass" in found.remarks[0]


@pytest.mark.parametrize(("column", "unit", "per"), [("voltage_v", "N/V^2", 1.0), ("rpm", "N*s^2", 1.0 / 60.0)])
def test_thrust_of_either_direction(column, unit, per, tmp_path):
    """T = c V|V| by weights V⁴; astern is told as a share of ahead, in standard errors of both."""
    command = np.array([-6.0, -4.0, -2.0, 2.0, 4.0, 6.0]) / per
    squared = np.sign(command) * (command * per) ** 2
    thrust = np.where(command > 0.0, 2.0, 1.5) * squared + 0.1 * np.array([1.0, -1.0, -0.5, 0.75, 1.0, -1.0])
    found = identify(folder(tmp_path, {"kind": "thruster"}, data={column: command, "thrust_n": thrust}))
    sides = {"ahead": command > 0.0, "astern": command < 0.0}
    value = {side: np.sum(thrust[m] * squared[m]) / np.sum(squared[m] ** 2) for side, m in sides.items()}
    misfit = thrust - np.where(sides["ahead"], value["ahead"], value["astern"]) * squared
    sd = {side: math.sqrt(np.sum(misfit**2) / 4 / np.sum(squared[m] ** 2)) for side, m in sides.items()}
    for side in sides:
        assert (found[side].value, found[side].sd) == pytest.approx((value[side], sd[side]), rel=1e-5)
        assert found[side].unit == unit
    apart = (value["ahead"] - value["astern"]) / math.hypot(*sd.values())
    share = 100.0 * value["astern"] / value["ahead"]
    assert f"{share:.0f} % of its thrust ahead ({apart:.1f} standard errors)" in found.remarks[0]
    written = {side: {"mean": f"{value[side]:.5g} N/V^2", "sd": f"{sd[side]:.2g} N/V^2"} for side in sides}
    assert found.fragment == ({"thrusters": [{"name": "thruster", **written}]} if per == 1.0 else {})
    curve = found.panels[0].curves[0]
    expected = np.where(curve.x > 0.0, value["ahead"], -value["astern"]) * curve.x**2
    np.testing.assert_allclose(curve.y, expected, rtol=1e-5, atol=1e-9)
    assert (curve.x[0], curve.x[-1]) == pytest.approx((-6.0, 6.0))
