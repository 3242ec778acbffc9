"""What the extended mission of tank data carries, and where."""

import numpy as np
import pytest
import yaml

from missionplan.datasets.tank import OscillationSettings
from missionplan.diagnosis.diagnose import diagnose
from missionplan.diagnosis.tank.forward import full_size_added_mass
from missionplan.errors import InputError
from missionplan.mission import Mission, load
from missionplan.montecarlo.distributions import mean_of, sd_of
from missionplan.report.render import render_report
from tests.learned import held, moments

PHASE = {"from": ["0 m", "0 m"], "to": ["1 km", "0 m"], "speed": "1 m/s", "d_max": "1 km", "arrival_radius": "50 m"}
MISSION = {
    "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "60 s"},
    "phases": [{"transit": PHASE}],
}
HULL = {"length": "1.2 m", "diameter": "0.4 m"}


def mission(tmp_path, **vehicle):
    path = tmp_path / "mission.yaml"
    path.write_text(yaml.safe_dump(MISSION | ({"vehicle": {"hull": HULL, **vehicle}} if vehicle else {})))
    return load(path)


def towed(folder, bias, exponent, scale=2.0):
    """A dozen runs of ½ρAC_D U² with C_D = 0.8 at the middle Reynolds number, 1 % of noise."""
    folder.mkdir()
    speed = np.geomspace(0.2, 1.2, 16)
    middle = float(np.exp(np.mean(np.log(speed))))
    force = 500.0 * 0.1 * 0.8 * (1.0 + bias) * speed**2 * (speed / middle) ** exponent
    sd = 0.01 * force
    rows = np.stack([speed, force + sd * np.random.default_rng(3).standard_normal(16), sd], axis=1)
    np.savetxt(folder / "drag.csv", rows, delimiter=",", header="speed_m_s,force_n,force_sd_n", comments="")
    settings = {"kind": "drag", "file": "drag.csv", "reference_area": "0.1 m^2", "reference_length": "0.3 m"}
    (folder / "dataset.yaml").write_text(yaml.safe_dump(settings | {"scale": scale}))
    return folder


def test_drag_goes_into_the_vehicle_at_full_size(tmp_path):
    base = mission(tmp_path, drag={"coefficient": 0.8, "area": "0.4 m^2"})
    found = diagnose(base, towed(tmp_path / "data", 0.4, 0.0))
    assert found.causes == ("drag-bias",)
    drag = Mission.from_data(found.extended).vehicle.drag
    assert drag.coefficient.mean == pytest.approx(0.8 * 1.4, rel=0.01)
    assert drag.area == 0.4
    assert held(found.extended) == ()


def test_reynolds_number_goes_with_it(tmp_path):
    base = mission(tmp_path, drag={"coefficient": 0.8, "area": "0.4 m^2"})
    found = diagnose(base, towed(tmp_path / "data", 0.0, -0.2))
    assert found.causes == ("reynolds-drag",)
    drag = Mission.from_data(found.extended).vehicle.drag
    assert drag.exponent.mean == pytest.approx(-0.2, abs=0.02)
    assert drag.length == pytest.approx(0.6)
    rendered = render_report(found)
    assert {"data", "residuals", "ranking"} <= {figure.removesuffix(".svg") for figure in rendered.figures}


@pytest.mark.parametrize(("bias", "exponent"), [(0.4, 0.0), (0.0, -0.2)])
def test_tank_data_diagnosed_again_are_adequate_and_nothing_grows(tmp_path, bias, exponent):
    """The key of the vehicle that the first diagnosis wrote is the prior of the second, and sharpened by it."""
    data = towed(tmp_path / "data", bias, exponent)
    first = diagnose(mission(tmp_path, drag={"coefficient": 0.8, "area": "0.4 m^2"}), data, plan=False)
    second = diagnose(Mission.from_data(first.extended), data, plan=False)
    assert second.verdict == "adequate"
    assert second.causes == ()
    assert [estimate.effect for estimate in second.confirmed] == list(first.causes)
    before, after = (Mission.from_data(each.extended).vehicle.drag for each in (first, second))
    for key in ("coefficient", "exponent"):
        old, new = getattr(before, key), getattr(after, key)
        assert mean_of(new) == pytest.approx(mean_of(old), abs=sd_of(old) + 1e-3)
        assert sd_of(new) <= sd_of(old)


def test_a_drag_that_is_not_as_the_vehicle_has_it_has_changed(tmp_path):
    base = mission(tmp_path, drag={"coefficient": {"mean": 0.8, "sd": 0.016}, "area": "0.4 m^2"})
    found = diagnose(base, towed(tmp_path / "data", 0.4, 0.0), plan=False)
    assert found.causes == ("drag-bias",)
    assert found.changed == ("drag-bias",)
    assert Mission.from_data(found.extended).vehicle.drag.coefficient.mean == pytest.approx(0.8 * 1.4, rel=0.01)


def test_an_effect_that_the_mission_carries_is_confirmed_where_it_stands(tmp_path):
    """Dives have shown two fifths more drag, as an effect: the tank's data sharpen it there, not in the vehicle too."""
    dives = {"site": {"depth": "24 m"}, "phases": [{"moor": {"radius": "20 m", "anchor_wet_weight": "12 N"}}]}
    base = mission(tmp_path, drag={"coefficient": 0.8, "area": "0.4 m^2"})
    carrying = {**base.raw, **dives, "effects": [{"drag-bias": {"fraction": {"mean": 0.4, "sd": 0.05}}}]}
    carrying["phases"][0]["moor"]["line_length"] = "5 m"
    carrying["vehicle"] = {
        **carrying["vehicle"],
        "mass": "120 kg",
        "anchor": {"diameter": "0.1 m", "flooded_mass": "3 kg"},
    }
    found = diagnose(Mission.from_data(carrying), towed(tmp_path / "data", 0.4, 0.0), plan=False)
    assert found.verdict == "adequate"
    assert found.extended["vehicle"]["drag"] == carrying["vehicle"]["drag"]
    mean, sd = moments(found.extended, "drag-bias", "fraction")
    assert mean == pytest.approx(0.4, abs=0.02)
    assert sd < 0.03


def test_a_drag_within_its_spike_is_no_bias(tmp_path):
    """4 % of drag are two of a tank's standard deviations."""
    base = mission(tmp_path, drag={"coefficient": 0.8, "area": "0.4 m^2"})
    found = diagnose(base, towed(tmp_path / "data", 0.04, 0.0), plan=False)
    assert found.verdict == "adequate"


def test_without_a_drag_to_compare_with_there_is_no_bias(tmp_path):
    found = diagnose(mission(tmp_path), towed(tmp_path / "data", 0.4, 0.0))
    assert found.verdict == "adequate"
    assert "drag-bias" in found.untestable
    assert found.calibration["drag_coefficient"] == pytest.approx(0.8 * 1.4, rel=0.01)


def test_frequencies_alone_are_refused(tmp_path):
    folder = tmp_path / "data"
    folder.mkdir()
    (folder / "modes.csv").write_text("mode,frequency_hz\nsurge,1.77\n")
    settings = {"kind": "free-oscillation", "file": "modes.csv", "stiffness": "4000 N/m", "mass": "24 kg"}
    (folder / "dataset.yaml").write_text(yaml.safe_dump(settings))
    with pytest.raises(InputError, match="nothing is left to test"):
        diagnose(mission(tmp_path), folder)


def test_added_mass_at_full_size_holds_what_the_vehicle_file_has_and_not_the_mass_in_air(tmp_path):
    """10 kg at half scale, of which 16 kg at full size add 2: a tenth more is 13.2, of which 3.2 are water."""
    settings = OscillationSettings.model_construct(mass=10.0, scale=2.0)
    vehicle = mission(tmp_path, added_mass={"surge": "16 kg"}).vehicle
    assert full_size_added_mass(settings, vehicle, 0.1, 0.02) == pytest.approx((25.6, 12.0 * 0.02 * 8.0))
    assert full_size_added_mass(settings, None, 0.1, 0.02) == pytest.approx((8.0, 10.0 * 0.02 * 8.0))
