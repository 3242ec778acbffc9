"""Missions in the fields of ocean models: patterns of files, what is refused, and what validate says."""

from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from model_files import fvcom, roms, ugrid

from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.scenario.currents.area import in_degrees
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation.simulate import simulate
from missionplan.studies.validate import validate


def mission(folder, depth="4 m", to=("1200 m", "300 m"), **current):
    data = {
        "name": "Along a coast",
        "start": "2026-05-01T12:00:00Z",
        "site": {"origin": {"latitude": "45 deg", "longitude": "-124 deg"}, "depth": "20 m", "current": current},
        "navigation": {"velocity_error": {"sigma": "0.01 m/s"}, "surfacing_time": "60 s", "fix_error": "3 m"},
        "phases": [
            {
                "transit": {
                    "name": "out",
                    "from": ["-600 m", "0 m"],
                    "to": list(to),
                    "depth": depth,
                    "speed": "1.5 m/s",
                    "d_max": "600 m",
                    "arrival_radius": "50 m",
                }
            }
        ],
    }
    (folder / "mission.yaml").write_text(yaml.safe_dump(data))
    return load(folder / "mission.yaml")


def test_a_mission_sails_in_a_roms_field_of_several_files(tmp_path):
    calm = {"u": np.full((5, 5, 9, 10), 0.3), "v": np.zeros((5, 5, 8, 11)), "angle": None}
    calm.pop("angle")
    (tmp_path / "cache").mkdir()
    roms(tmp_path / "cache" / "a.nc", 2, **calm)
    roms(tmp_path / "cache" / "b.nc", 2, **calm)
    found = simulate(mission(tmp_path, file="cache/*.nc"), trials=50, sheet=False)
    assert found.total.events["success"].value == 1.0
    assert len(mission(tmp_path, file="cache/*.nc").sources) == 3
    both = mission(tmp_path, file="cache/*.nc").identified()["site"]["current"]["file"]
    (tmp_path / "cache" / "b.nc").unlink()
    one = mission(tmp_path, file="cache/*.nc").identified()["site"]["current"]["file"]
    assert both != one
    assert both.startswith("*.nc (SHA-256 ")


@pytest.mark.parametrize(
    ("write", "changes", "message"),
    [
        (ugrid, {"projection": "local"}, "the nominal out leaves the record, which .* is good down to 1 m"),
        (ugrid, {}, "in metres of a projection that the file lacks"),
        (ugrid, {"projection": "EPSG:0"}, "site.current.projection"),
        (fvcom, {"start": "2026-05-01T12:00:00Z"}, "has dates of its own"),
        (fvcom, {"file": "model-*.nc"}, "no file is named like that"),
        (fvcom, {"file": "../elsewhere/*.nc"}, "lies outside the mission file's folder"),
    ],
)
def test_what_a_field_cannot_serve_is_refused(tmp_path, write, changes, message):
    write(tmp_path / "field.nc", "node" if write is ugrid else True)
    with pytest.raises(InputError, match=message):
        simulate(mission(tmp_path, **({"file": "field.nc"} | changes)), trials=10, sheet=False)


def test_a_goal_on_land_is_refused_before_the_run(tmp_path):
    mask = np.ones((9, 11))
    mask[:, 7:] = 0.0
    roms(tmp_path / "field.nc", 1, mask=mask)
    with pytest.raises(InputError, match=r"out.to: lies on land, or in a gap of the grid"):
        simulate(mission(tmp_path, file="field.nc", to=("2600 m", "1000 m")), trials=10, sheet=False)


def test_trials_on_land_fail_with_the_reason(tmp_path):
    """A field with an island in the middle: the record's gap is never read as still water."""
    mask = np.ones((9, 11))
    mask[3:6, 4:7] = 0.0
    roms(tmp_path / "field.nc", 2, mask=mask, u=np.full((5, 5, 9, 10), 0.2), v=np.zeros((5, 5, 8, 11)))
    with pytest.raises(InputError, match=r"lies on land|leave.* the record"):
        simulate(mission(tmp_path, file="field.nc"), trials=50, sheet=False)
    held = mission(tmp_path, file="field.nc", outside="hold")
    here = np.zeros((2, 1))
    assert np.hypot(*recorded_current(held).velocity(0.0, 4.0, here))[0] > 0.05


def test_validate_says_what_the_field_covers(tmp_path):
    fvcom(tmp_path / "field.nc", False)
    mission(tmp_path, file="field.nc")
    (found,) = validate(tmp_path / "mission.yaml")
    assert not found.problems
    assert "Current: from 2026-05-01 12:00 to 2026-05-01 15:00 UTC, " in found.summary
    assert "km east and " in found.summary
    assert found.summary.endswith("down to 28.47 m.")


@pytest.mark.parametrize(
    ("x", "y", "units", "are"),
    [
        *[
            (360.0, -90.0, ("", ""), True),
            (-123.0, 48.0, ("", ""), True),
            (10.0, 90.1, ("", ""), False),
            (360.1, 45.0, ("", ""), False),
        ],
        *[
            (5e5, 5e6, ("", ""), False),
            (1.0, 2.0, ("m", "km"), False),
            (5e5, 5e6, ("degrees_east", "degrees_north"), True),
        ],
        *[
            (1.0, 2.0, ("", "m"), False),
            (5e5, 2.0, ("degrees_east", ""), True),
            (1.0, 2.0, ("degrees_east", "m"), None),
        ],
    ],
)
def test_degrees_are_told_by_their_units_and_else_by_their_sizes(x, y, units, are):
    variables = {
        name: SimpleNamespace(name=name, attrs={"units": unit} if unit else {})
        for name, unit in zip("xy", units, strict=True)
    }
    files = SimpleNamespace(variable=variables.__getitem__, problem=ValueError)
    if are is None:
        with pytest.raises(ValueError, match="one is in degrees, the other is not"):
            in_degrees(files, ("x", "y"), np.array([x]), np.array([y]))
    else:
        assert in_degrees(files, ("x", "y"), np.array([0.0, x, np.nan]), np.array([0.0, y, np.nan])) == are
