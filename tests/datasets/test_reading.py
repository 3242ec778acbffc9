"""`dataset.yaml` of all kinds: one schema a kind, with every problem of the folder at once."""

import pytest
import yaml

import missionplan
from missionplan.datasets import dataset_kind, read_dataset
from missionplan.datasets.legs import read_transit
from missionplan.datasets.summaries import SUMMARY, read_summary
from missionplan.datasets.tank import DRAG, FREE_OSCILLATION, TANK_FORMATS, read_tank_data
from missionplan.errors import InputError

TOWING = {"kind": "drag", "reference_area": "0.1 m^2", "reference_length": "0.3 m"}
ROWS = "speed_m_s,force_n\n0.5,3\n1,10\n"
TESTS = "run,quantity,value,sd\na,descent_time_s,12,1\nb,descent_time_s,13,\nb,terminal_velocity_m_s,,\n"


def words(excinfo):
    return "\n".join(str(problem) for problem in excinfo.value.problems)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"kind": "drags"}, "given 'drags', expected one of drag, free-oscillation, .*did you mean drag"),
        ({"kind": None}, "kind: missing; expected one of"),
        ({"kind": ["drag"]}, "kind: given .'drag'., expected one of"),
    ],
)
def test_a_kind_that_is_none_is_told_the_known(folder, keys, expected):
    with pytest.raises(InputError, match=expected):
        dataset_kind(folder(keys, ROWS), TANK_FORMATS)


def test_problems_of_both_files_come_together(folder):
    place = folder(TOWING | {"reference_area": "1 kg", "sorce": "here", "noise": 3}, "speed_m_s,force_n\nx,1\n")
    with pytest.raises(InputError) as excinfo:
        read_dataset(place, DRAG).checked()
    for part in (
        "did you mean source?",
        "given 1 kg",
        "given 3, expected a mapping",
        "rows.csv:2: speed_m_s: given 'x'",
    ):
        assert part in words(excinfo)


@pytest.mark.parametrize("missing", ["stiffness", "mass"])
def test_springs_and_model_of_an_oscillation_must_be_known(folder, missing):
    keys = {"kind": "free-oscillation", "stiffness": "4000 N/m", "mass": "24 kg"}
    place = folder(keys | {missing: None}, "mode,frequency_hz\nsurge,1.8\n")
    with pytest.raises(InputError, match=f"{missing}: missing; .*cannot be found together"):
        read_dataset(place, FREE_OSCILLATION).checked()
    del keys[missing]
    with pytest.raises(InputError, match=f"{missing}: missing; .*cannot be found together"):
        read_dataset(folder(keys, "mode,frequency_hz\nsurge,1.8\n"), FREE_OSCILLATION).checked()


def test_the_water_of_a_tank_follows_from_its_temperature_and_salinity(folder):
    data = read_tank_data(folder(TOWING | {"water": {"temperature": "15 degC", "salinity": 35}}, ROWS))
    assert (data.density, data.viscosity) == (pytest.approx(1026.0, rel=1e-3), pytest.approx(1.19e-6, rel=0.01))


@pytest.mark.parametrize("command", ["voltage_v", "rpm"])
def test_a_thruster_that_is_never_told_to_turn_is_named(command, folder):
    thrusts = f"{command},thrust_n\n"
    assert read_tank_data(folder({"kind": "thruster"}, thrusts + "0,0\n-3,-1\n")).columns[command].tolist() == [
        0.0,
        -3.0,
    ]
    with pytest.raises(InputError, match=f"{command}: is 0 on every row: the thruster stands still"):
        read_tank_data(folder({"kind": "thruster"}, thrusts + "0,1\n0,2\n"))


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"file": None}, "file: missing"),
        ({"file": "  "}, "expected the name of a CSV file"),
        ({"file": 3}, "given 3, expected text"),
        ({"file": "../data/../../rows.csv"}, "outside the data set's folder"),
        ({"file": "/etc/passwd"}, "outside the data set's folder"),
        ({"file": "other.csv"}, "no such file"),
        ({"compare": {"name": "CFD", "file": "other.csv"}}, "no such file"),
        ({"compare": {"name": "CFD"}}, "compare.file: missing"),
    ],
)
def test_files_are_named_and_lie_in_the_folder(folder, keys, expected):
    with pytest.raises(InputError, match=expected):
        read_tank_data(folder(TOWING | keys, ROWS))


def test_name_and_source_are_text_and_may_be_blank(folder):
    place = folder(TOWING | {"name": 2024, "source": None, "noise": None}, ROWS)
    raw = read_dataset(place, DRAG)
    assert (raw.name, raw.source) == ("2024", "")
    assert read_dataset(folder(TOWING, ROWS), DRAG).name == "data"


def test_a_folder_was_expected(folder):
    place = folder(TOWING, ROWS)
    with pytest.raises(InputError, match="is a file; a data set is a folder"):
        dataset_kind(place / "rows.csv", TANK_FORMATS)
    with pytest.raises(InputError, match="no such file"):
        dataset_kind(place / "nowhere", TANK_FORMATS)
    (place / "dataset.yaml").write_text(yaml.safe_dump(["kind"]))
    with pytest.raises(InputError, match="expected keys such as kind"):
        dataset_kind(place, TANK_FORMATS)


def test_runs_of_a_summary_are_the_missions_but_for_what_differed(folder, descent_mission):
    runs = {"a": {"depth": "30 m"}}
    data = read_summary(folder({"kind": "summary", "runs": runs}, TESTS), descent_mission)
    assert [test.site_depth for test in data.tests] == [30.0, 24.0]
    assert "b: descent_time_s states no sd; 5 % is assumed" in data.notices
    assert "rows.csv: 1 row left out without value" in data.notices


@pytest.mark.parametrize(
    ("runs", "expected"),
    [
        ({"a": {"depht": "30 m"}}, "runs.a.depht: unknown key .did you mean depth"),
        ({"a": {"line_length": "90 m"}}, "never pulled down"),
        ({"a": 3}, "runs.a: given 3, expected a mapping"),
        ([3], "expected a mapping"),
    ],
)
def test_runs_of_a_summary_are_checked(folder, descent_mission, runs, expected):
    with pytest.raises(InputError, match=expected):
        read_summary(folder({"kind": "summary", "runs": runs}, TESTS), descent_mission)


def test_a_mission_without_moorings_must_be_told_all(folder, transit_mission):
    with pytest.raises(InputError) as excinfo:
        read_summary(folder({"kind": "summary", "runs": {"a": {"depth": "30 m"}}}, TESTS), transit_mission)
    assert "runs.a: needs line_length: neither the run nor the mission has it" in words(excinfo)
    assert "runs.b: needs depth" in words(excinfo)


def test_unknown_quantities(folder, descent_mission):
    with pytest.raises(InputError, match=r"rows\.csv:2: quantity: given 'speed', expected one of descent_time_s"):
        read_summary(folder({"kind": SUMMARY.kind}, "run,quantity,value\na,speed,1\n"), descent_mission)


def test_a_link_out_of_the_folder_is_followed_on_request_alone(tmp_path, folder):
    place = folder({"kind": "drag", "reference_area": "1 m^2", "reference_length": "1 m"}, "")
    outside = tmp_path / "outside.csv"
    outside.write_text("speed_m_s,force_n\n" + "".join(f"{v},{v * v}\n" for v in (0.5, 1.0, 1.5, 2.0)))
    (place / "rows.csv").unlink()
    (place / "rows.csv").symlink_to(outside)
    with pytest.raises(InputError, match=r"lies outside the data set's folder \(allow_outside=True permits it\)"):
        missionplan.identify(place)
    assert missionplan.identify(place, allow_outside=True).summary()["command"] == "identify"


def test_links_that_lead_nowhere_are_said(tmp_path, transit_mission):
    (tmp_path / "dataset.yaml").write_text("kind: transit\nfile: rows.csv\n")
    for target, words in (
        ("gone.csv", "no such file .it is a link to what is not there"),
        ("rows.csv", "cannot be read"),
    ):
        (tmp_path / "rows.csv").unlink(missing_ok=True)
        (tmp_path / "rows.csv").symlink_to(target)
        with pytest.raises(InputError, match=words):
            read_transit(tmp_path, transit_mission)
