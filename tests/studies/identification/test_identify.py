"""`identify` on data made by other means than its own models, and its refusals."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
import yaml

from missionplan.errors import InputError, RunError
from missionplan.report.render import render_report, terminal_view
from missionplan.studies.identification import identify
from tests.physics import propeller_example as example


def write(folder, settings, columns, name="data.csv"):
    folder.mkdir(exist_ok=True)
    (folder / "dataset.yaml").write_text(yaml.safe_dump({"file": name, **settings}))
    header = ",".join(columns)
    rows = zip(*columns.values(), strict=True)
    (folder / name).write_text("\n".join([header, *(",".join(map(str, row)) for row in rows)]) + "\n")
    return folder


DRAG = {"kind": "drag", "reference_area": "0.1 m^2", "reference_length": "0.3 m"}


def towing(rng, exponent=0.0, points=20):
    speed = np.linspace(0.2, 1.5, points)
    reynolds = speed * 0.3 / 1.01e-6
    force = 0.5 * 1000 * 0.1 * speed**2 * 1.8 * (reynolds / 1e5) ** exponent
    sd = 0.02 * force
    return {"speed_m_s": speed, "force_n": force + sd * rng.standard_normal(points), "force_sd_n": sd}


@pytest.mark.parametrize(("tanks", "least"), [(20, 14), pytest.param(60, 48, marks=pytest.mark.slow)])
def test_drag_intervals_cover(tmp_path, tanks, least):
    """The 90 % intervals hold the truth in about 90 % of the tanks: fewer than the least in 2 and 6 of a thousand sets."""
    covered = 0
    for seed in range(tanks):
        found = identify(write(tmp_path / "drag", DRAG, towing(np.random.default_rng(seed))))["drag_coefficient"]
        covered += found.low < 1.8 < found.high
    assert covered >= least


def test_reynolds_dependence_is_found_where_it_is(tmp_path):
    result = identify(write(tmp_path / "drag", DRAG, towing(np.random.default_rng(1), exponent=-0.15)))
    assert "reynolds_exponent" in result.fits[0]
    assert result["reynolds_exponent"].low < -0.15 < result["reynolds_exponent"].high
    assert result.fragment["drag"]["exponent"]["mean"] == pytest.approx(-0.15, abs=0.03)


def oscillation(rng, quadratic, noise=2e-4, seconds=8.0, rate=50.0):
    """A mass on springs by Verlet with tiny steps: not the Runge-Kutta of the model."""
    mass, stiffness, linear, h = 24.0 + 9.6, 4165.9, 8.0, 4e-4
    x, v, out = 0.05, 0.0, []
    for step in range(int(seconds / h)):
        if step % round(1 / rate / h) == 0:
            out.append((step * h, x))
        a = (-stiffness * x - linear * v - quadratic * v * abs(v)) / mass
        half = v + a * h / 2
        x += half * h
        v = half + (-stiffness * x - linear * half - quadratic * half * abs(half)) / mass * h / 2
    time, record = np.array(out).T
    return {"t_s": time, "displacement_m": record + noise * rng.standard_normal(len(time))}


SPRINGS = {"kind": "free-oscillation", "stiffness": "4165.9 N/m", "mass": "24 kg"}


def test_added_mass_and_damping_from_a_record(tmp_path):
    result = identify(write(tmp_path / "osc", SPRINGS, oscillation(np.random.default_rng(2), 60.0)))
    assert result.fits[0].name == "linear and quadratic damping"
    for name, truth in (("added_mass", 9.6), ("linear_damping", 8.0), ("quadratic_damping", 60.0)):
        assert abs(result[name].value - truth) < 3.0 * result[name].sd, name
    assert result["added_mass"].sd < 0.05
    assert result["quadratic_damping"].sd < 10.0


def test_times_of_a_record_may_be_iso_8601(tmp_path):
    record = oscillation(np.random.default_rng(2), 60.0)
    begin = datetime(2026, 5, 1, 12, tzinfo=UTC)
    dated = record | {"t_s": [(begin + timedelta(seconds=float(t))).isoformat() for t in record["t_s"]]}
    plain, dated = (identify(write(tmp_path / name, SPRINGS, data)) for name, data in (("s", record), ("iso", dated)))
    assert dated["added_mass"].value == pytest.approx(plain["added_mass"].value, abs=1e-3)


def test_linear_damping_needs_no_quadratic_term(tmp_path):
    result = identify(write(tmp_path / "osc", SPRINGS, oscillation(np.random.default_rng(3), 0.0)))
    assert result.fits[0].name == "linear damping"


@pytest.mark.parametrize("given", [{"mass": "24 kg"}, {"stiffness": "4000 N/m"}, {}])
def test_stiffness_mass_and_added_mass_together_are_refused(tmp_path, given):
    folder = write(tmp_path / "osc", {"kind": "free-oscillation", **given}, {"mode": ["surge"], "frequency_hz": [1.77]})
    with pytest.raises(InputError, match="cannot be found together"):
        identify(folder)


def test_a_model_at_rest_is_refused(tmp_path):
    settings = {"kind": "drag", "reference_area": "0.01 m^2", "reference_length": "1 m"}
    rows = {"speed_m_s": [0.0, 0.4, -0.6, 0.8], "force_n": [0.2, 1.6, 3.4, 5.9]}
    with pytest.raises(InputError) as refused:
        identify(write(tmp_path / "tow", settings, {name: np.array(values) for name, values in rows.items()}))
    assert [(problem.line, problem.key) for problem in refused.value.problems] == [(2, "speed_m_s"), (4, "speed_m_s")]


def bollard(rng, deadband):
    voltage = np.concatenate([np.linspace(-6, -0.5, 15), np.linspace(0.5, 6, 15)])
    beyond = np.maximum(np.abs(voltage) - deadband, 0.0)
    thrust = np.where(voltage > 0, 9.423, -6.551) * beyond**2
    return {"voltage_v": voltage, "thrust_n": thrust + 2.0 * rng.standard_normal(30)}


@pytest.mark.parametrize("deadband", [0.0, 0.6])
def test_thruster_constants_and_deadband(tmp_path, deadband):
    result = identify(write(tmp_path / "thruster", {"kind": "thruster"}, bollard(np.random.default_rng(4), deadband)))
    assert abs(result["ahead"].value - 9.423) < 3 * result["ahead"].sd
    assert abs(result["astern"].value - 6.551) < 3 * result["astern"].sd
    assert ("deadband" in result.fits[0]) == (deadband > 0)


def test_a_thruster_that_stands_still_is_refused(tmp_path):
    rows = {"voltage_v": np.zeros(5), "thrust_n": np.linspace(-2.0, 2.0, 5)}
    with pytest.raises(InputError, match=r"voltage_v: is 0 on every row"):
        identify(write(tmp_path / "still", {"kind": "thruster"}, rows))


def tunnel(rng, decay, position, centre):
    """Force and moment by the paper's Eqs. 1 to 4, written out."""
    rpm, speed = (grid.ravel() for grid in np.meshgrid([1200.0, 1800.0, 2400.0], [0.0, 0.4, 0.6, 0.8, 1.0]))
    static = 0.02 * (rpm / 60) ** 2
    ratio = speed / np.sqrt(static / (1000 * np.pi / 4 * 0.07**2))
    force = static * np.exp(-decay * ratio**2)
    moment = static * position - (static - force) * centre(ratio)
    return {
        "run": ["a"] * len(rpm),
        "rpm": rpm,
        "speed_m_s": speed,
        "thrust_n": force + 0.1 * rng.standard_normal(len(rpm)),
        "moment_n_m": moment + 0.1 * rng.standard_normal(len(rpm)),
    }


def test_tunnel_thruster_forward(tmp_path):
    data = tunnel(np.random.default_rng(5), 7.0, 0.8, lambda ratio: 0.8 - 9.0 * 0.07 * ratio)
    settings = {"kind": "thruster", "geometry": {"diameter": "70 mm", "position": "0.8 m"}}
    result = identify(write(tmp_path / "tunnel", settings, data))
    assert result.fits[0].name == "centre of suction moves aft with speed"
    for name, truth in (("decay", 7.0), ("thrust_constant", 0.02), ("suction_gradient", 9.0)):
        assert abs(result[name].value - truth) < 3.0 * result[name].sd, name
    assert_on_their_curves(result.panels)


def assert_on_their_curves(panels):
    """Force and moment over those at rest, 8 N or more at 0.8 m, of which 0.1 N is noise."""
    assert [panel.name for panel in panels] == ["force-factor", "moment-factor"]
    for panel in panels:
        curve = np.interp(panel.x, panel.curves[0].x, panel.curves[0].y)
        np.testing.assert_allclose(panel.y, curve, atol=0.05)
        np.testing.assert_allclose(panel.fitted, curve, atol=0.01)


def test_tunnel_thruster_aft(tmp_path):
    data = tunnel(np.random.default_rng(6), 3.0, -0.8, lambda ratio: -1.52 + 0 * ratio)
    settings = {"kind": "thruster", "geometry": {"diameter": "70 mm", "position": "-0.8 m"}}
    result = identify(write(tmp_path / "tunnel", settings, data))
    assert result.fits[0].name == "centre of suction stays"
    assert abs(result["suction_offset"].value - 0.72) < 3.0 * result["suction_offset"].sd
    assert abs(result["decay"].value - 3.0) < 3.0 * result["decay"].sd
    assert_on_their_curves(result.panels)


def test_each_stated_noise_is_that_of_its_own_column(tmp_path):
    """Moments too noisy to tell anything leave the constants as forces alone have them."""
    data = tunnel(np.random.default_rng(7), 7.0, 0.8, lambda ratio: 0.8 - 9.0 * 0.07 * ratio)
    settings = {"kind": "thruster", "geometry": {"diameter": "70 mm", "position": "0.8 m"}}
    forces = {name: values for name, values in data.items() if name != "moment_n_m"}
    both = {**settings, "noise": {"thrust": "0.2 N", "moment": "10000 N*m"}}
    fitted = identify(write(tmp_path / "both", both, data))
    alone = identify(write(tmp_path / "alone", {**settings, "noise": {"thrust": "0.2 N"}}, forces))
    for name in ("thrust_constant", "decay"):
        assert fitted[name].value == pytest.approx(alone[name].value, rel=1e-4), name
        assert fitted[name].sd == pytest.approx(alone[name].sd, rel=1e-2), name


def transient(rng, measured):
    """Table 1's vehicle under a swinging torque, with the momentum damping of the flow; 0.2 N of noise."""
    step, every = 0.005, 5
    at = step * np.arange(2000)
    torque = 4.0 + 4.0 * np.sin(0.8 * at) - 3.0 * np.cos(2.3 * at)
    run = example.simulate_propulsion(example.table_1("momentum"), example.TABLE_1_RESISTANCE, torque, step)
    pick = slice(0, -1, every)
    columns = {
        "t_s": run.time[pick],
        "thrust_n": run.thrust[pick] + 0.2 * rng.standard_normal(len(torque) // every),
        "speed_m_s": run.speed[pick],
    }
    if measured == "rpm":
        return columns | {"rpm": run.shaft_rate[pick] * 60 / (2 * np.pi)}
    return columns | {"shaft_torque_n_m": torque[::every]}


@pytest.mark.parametrize("measured", ["rpm", "torque"])
def test_propeller_transient(tmp_path, measured):
    geometry = {"diameter": "0.3 m", "wake_fraction": 0.2, "axial_flow_factor": 0.25}
    geometry |= {"torque_coefficient": [0.0626, -0.1212], "shaft_inertia": "1 kg*m^2"}
    settings = {"kind": "propeller-transient", "geometry": geometry, "noise": {"thrust": "0.2 N"}}
    settings["water"] = {"density": "1025 kg/m^3", "viscosity": "1.19e-6 m^2/s"}
    result = identify(write(tmp_path / "prop", settings, transient(np.random.default_rng(7), measured)))
    assert result.fits[0].name == "axial-flow dynamics"
    truths = (("thrust_coefficient", 0.4243), ("thrust_coefficient_slope", -0.9435), ("flow_mass", 21.74))
    for name, truth in truths:
        assert abs(result[name].value - truth) < 3.0 * result[name].sd, name
        assert result[name].value == pytest.approx(truth, rel=0.1), name


def test_a_transient_without_shaft_rate_needs_the_shaft(tmp_path):
    settings = {"kind": "propeller-transient", "geometry": {"diameter": "0.3 m"}}
    columns = {"t_s": [0, 1], "shaft_torque_n_m": [1, 1], "thrust_n": [0, 1], "speed_m_s": [0, 0]}
    with pytest.raises(InputError, match="torque_coefficient") as caught:
        identify(write(tmp_path / "prop", settings, columns))
    assert "shaft_inertia" in str(caught.value)


def test_every_problem_at_once(tmp_path):
    folder = write(
        tmp_path / "bad",
        {**DRAG, "refernce_area": "0.1 m^2"} | {"reference_area": "0.1 kg"},
        {"speed_m_s": ["x"], "force": [1]},
    )
    with pytest.raises(InputError) as caught:
        identify(folder)
    words = str(caught.value)
    assert "refernce_area" in words
    assert "did you mean reference_area?" in words
    assert "given 0.1 kg" in words
    assert "is it force?" in words


def test_a_bad_cell_is_named_by_line(tmp_path):
    with pytest.raises(InputError, match=r"data.csv:3: force_n: given 'abc'"):
        identify(write(tmp_path / "bad", DRAG, {"speed_m_s": [0.1, 0.2], "force_n": [1, "abc"]}))


def test_an_unknown_kind_is_reported_with_the_known_ones(tmp_path):
    with pytest.raises(InputError, match="did you mean drag"):
        identify(write(tmp_path / "bad", {"kind": "drags"}, {"speed_m_s": [1]}))


def test_a_file_outside_the_folder_is_refused(tmp_path):
    folder = write(tmp_path / "bad", DRAG, {"speed_m_s": [1], "force_n": [1]})
    (folder / "dataset.yaml").write_text(yaml.safe_dump(DRAG | {"file": "../secret.csv"}))
    with pytest.raises(InputError, match="outside"):
        identify(folder)


def test_too_few_points(tmp_path):
    with pytest.raises(RunError, match="do not suffice"):
        identify(write(tmp_path / "few", DRAG, {"speed_m_s": [0.5], "force_n": [10.0]}))


def test_marked_rows_and_unknown_columns_are_reported(tmp_path):
    data = towing(np.random.default_rng(8)) | {"ok": [0] + [1] * 19, "note": ["n"] * 20}
    result = identify(write(tmp_path / "drag", DRAG, data))
    assert any("1 row left out" in note for note in result.provenance.notices)
    assert any("note" in note for note in result.provenance.notices)
    assert len(result.panels[0].x) == 19


def test_report_is_one_page_with_its_files(tmp_path):
    result = identify(write(tmp_path / "drag", DRAG, towing(np.random.default_rng(9))))
    rendered = render_report(result)
    assert rendered.html.count("<svg") == len(rendered.figures) == 2
    assert "drag coefficient" in terminal_view(result).sentence
    folder = result.save(tmp_path / "report")
    for name in (
        "report.html",
        "summary.json",
        "parameters.csv",
        "vehicle-fragment.yaml",
        "figures/drag-coefficient.svg",
    ):
        assert (folder / name).is_file(), name


def towing_with_a_crisis(rng, drop, sd=0.02):
    """Drag whose coefficient falls by a share beyond 0.8 m/s, as neither a constant nor a power of Re does."""
    data = towing(rng, points=40)
    speed = data["speed_m_s"]
    force = 0.5 * 1000 * 0.1 * speed**2 * 1.8 * (1.0 - drop / (1.0 + np.exp(-(speed - 0.8) / 0.02)))
    return {**data, "force_n": force * (1.0 + sd * rng.standard_normal(40)), "force_sd_n": 0.02 * force}


def test_a_model_that_does_not_fit_is_said_first_and_has_no_interval(tmp_path):
    result = identify(write(tmp_path / "drag", DRAG, towing_with_a_crisis(np.random.default_rng(7), 0.4)))
    best = result.fits[0]
    assert best.does_not_fit
    assert result.summary()["does_not_fit"] is True
    residuals = result.residuals().query("panel == 'drag-force'")["residual"].to_numpy()
    stated = 0.02 * towing_with_a_crisis(np.random.default_rng(7), 0.4)["force_sd_n"] / 0.02
    assert best.chi_squared == pytest.approx(np.sum((residuals / stated) ** 2), rel=1e-6)
    assert result.answer.startswith(f"The model does not fit ({best.name}): chi-squared is {best.chi_squared:.0f} on ")
    assert "90 % interval" not in result.answer
    for estimate in best.estimates:
        assert np.isnan([estimate.low, estimate.high]).all()
        assert estimate.sd > 0.0  # widened: what the fragment carries
    rows = terminal_view(result).rows
    assert {row[2] for row in rows} == {"not known"}
    assert {row[3] for row in rows} == {"none"}
    assert "±" not in render_report(result).html.split("<h2")[0]


@pytest.mark.parametrize(
    ("tanks", "stated_over_true"),
    [(10, 0.75), *(pytest.param(40, share, marks=pytest.mark.slow) for share in (1.0, 0.75))],
)
def test_scatter_that_stated_errors_may_have_is_no_misfit(tmp_path, tanks, stated_over_true):
    """Of all right models, with errors as stated or a third larger, none is called wrong; intervals are widened."""
    for seed in range(tanks):
        data = towing_with_a_crisis(np.random.default_rng(seed), 0.0, sd=0.02 / stated_over_true)
        best = identify(write(tmp_path / "drag", DRAG, data)).fits[0]
        assert not best.does_not_fit
        assert np.isfinite(best["drag_coefficient"].low)


def test_a_misfit_without_stated_errors_is_scatter(tmp_path):
    data = towing_with_a_crisis(np.random.default_rng(7), 0.4)
    del data["force_sd_n"]
    result = identify(write(tmp_path / "drag", DRAG, data))
    assert not result.fits[0].does_not_fit
    assert result["drag_coefficient"].low < result["drag_coefficient"].high


def test_a_force_that_does_not_fit_is_said_though_moments_are_fitted_with_it(tmp_path):
    data = tunnel(np.random.default_rng(5), 7.0, 0.8, lambda ratio: 0.8 - 9.0 * 0.07 * ratio)
    data["thrust_n"] = data["thrust_n"] + 5.0 * np.sin(9.0 * data["speed_m_s"])
    settings = {"kind": "thruster", "geometry": {"diameter": "70 mm", "position": "0.8 m"}}
    settings["noise"] = {"thrust": "0.1 N", "moment": "0.1 N*m"}
    result = identify(write(tmp_path / "tunnel", settings, data))
    assert result.fits[0].does_not_fit
    assert result.answer.startswith("The model does not fit")


def test_an_added_mass_without_an_error_or_below_nil_is_said(tmp_path):
    modes = {"mode": ["surge"], "frequency_hz": [1.77]}
    found = identify(write(tmp_path / "osc", SPRINGS, modes))
    assert "Without a frequency_sd_hz its error is not known: surge" in found.answer
    assert found.summary()["parameters"][0]["note"] == "the data state no error"
    with pytest.raises(
        RunError, match=r"the added mass of surge would be negative: without water the frequency is 2\.1"
    ):
        identify(write(tmp_path / "osc", SPRINGS, modes | {"frequency_hz": [1e9]}))
    with pytest.raises(
        RunError, match="the added mass of surge would be over 1000 masses: without water the frequency is"
    ):
        identify(write(tmp_path / "osc", SPRINGS, modes | {"frequency_hz": [0.00177]}))
    t = np.arange(0.0, 10.0, 0.05)
    for unit, what in ((1e3, "over 1000 masses"), (1.0 / 60.0, "negative")):
        swing = {"t_s": unit * t, "displacement_m": 0.05 * np.exp(-0.1 * t) * np.cos(2.0 * np.pi * 1.77 * t)}
        with pytest.raises(RunError, match=f"the added mass of surge would be {what}"):
            identify(write(tmp_path / "osc", SPRINGS, swing))
    with pytest.raises(InputError, match="frequency_hz: expected more than 0"):
        identify(write(tmp_path / "osc", SPRINGS, modes | {"frequency_hz": [-1.0]}))
