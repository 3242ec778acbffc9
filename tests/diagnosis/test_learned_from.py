"""No measurement counts twice: copies, repetitions, and the extended mission laid against its own data."""

import json

import numpy as np
import pandas as pd
import pytest
import yaml

import missionplan
from missionplan.datasets.dives import read_descent
from missionplan.datasets.legs import read_transit
from missionplan.datasets.records import is_learned
from missionplan.datasets.summaries import read_summary
from missionplan.datasets.tank import read_tank_data
from missionplan.diagnosis.extended_mission import having_learned
from missionplan.diagnosis.learned_data import unlearned
from missionplan.errors import InputError
from missionplan.mission import Mission, load
from missionplan.mission.schema.place import to_geographic
from missionplan.mission.sections import MOST_LEARNED
from missionplan.report.diagnosis.page import answer
from missionplan.report.diagnosis.scoring import answer as told_of_score
from missionplan.studies.comparison.two_reports import changed_values
from tests.fixtures import TRANSIT, make_legs

CAUSES = ("compass-bias", "mean-current")
DOUBT = {"one-of": [{"probability": 0.4, "effects": [{"mean-current": {"east": {"mean": "2 cm/s", "sd": "1 cm/s"}}}]}]}
TOWING = {"kind": "drag", "reference_area": "0.1 m^2", "reference_length": "1 m"}


def turned(t, heading):
    """A compass that is off by 3.4 degrees."""
    return 0.06 * 1.2 * np.stack([np.cos(heading), -np.sin(heading)])


@pytest.fixture
def written(tmp_path):
    """Write data sets, each in a folder of its name."""

    def write(name, table, **keys):
        place = tmp_path / name
        place.mkdir()
        written = {"kind": "transit", "name": name, "file": "rows.csv", **keys}
        (place / "dataset.yaml").write_text(yaml.safe_dump(written))
        (place / "rows.csv").write_text(table if isinstance(table, str) else table.to_csv(index=False))
        return place

    return write


def log(legs=24, seed=1):
    return make_legs(legs, seed, error=turned)


def angle(found):
    """Mean and standard deviation of the compass bias after a diagnosis."""
    known = (*found.confirmed, *(found.best.parameters if found.best and found.causes else ()))
    return next((each.value, each.sd) for each in known if each.effect == "compass-bias")


@pytest.fixture(scope="module")
def learned(tmp_path_factory, causes):
    """A mission that has learned of its compass from a log."""
    place = tmp_path_factory.mktemp("first")
    (place / "dataset.yaml").write_text(yaml.safe_dump({"kind": "transit", "name": "first", "file": "rows.csv"}))
    log().to_csv(place / "rows.csv", index=False)
    with causes():
        found = missionplan.diagnose(Mission.from_data(TRANSIT), place, plan=False)
    assert found.causes == ("compass-bias",)
    return found


def as_written(diagnosis, tmp_path):
    """The extended mission, read from the file of the report."""
    for name in ("mission.yaml", "posterior.npz"):
        content = diagnosis.files()[name]
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return load(tmp_path / "mission.yaml")


def written_otherwise(table):
    """The same legs: other names, order, columns, digits, zero of time, and positions by latitude and longitude."""
    origin = Mission.from_data(TRANSIT).site.origin
    found = pd.DataFrame({"t_end_s": table["t_end_s"] + 1.7e9, "t_start_s": table["t_start_s"] + 1.7e9})
    for name, ending in (("end", "end"), ("dr", "dr_end"), ("start", "start")):
        latitude, longitude = to_geographic(table[f"x_{name}_m"].to_numpy(), table[f"y_{name}_m"].to_numpy(), origin)
        found[f"lon_{ending}"], found[f"lat_{ending}"] = np.degrees(longitude), np.degrees(latitude)
    return found.assign(leg=[f"L{k}" for k in range(len(found))]).sample(frac=1.0, random_state=3)


@pytest.mark.parametrize("change", [lambda table: table, written_otherwise], ids=["as it was", "written otherwise"])
def test_a_mission_learns_nothing_from_its_own_data(learned, written, tmp_path, change):
    mission = as_written(learned, tmp_path)
    assert len(mission.learned_from) == 24
    again = missionplan.diagnose(mission, written("a copy", change(log())), next_trial=True)
    assert angle(again) == pytest.approx(angle(learned), rel=1e-4)
    assert again.extended == mission.raw
    assert again.learned_from == ()
    assert again.next_trial is None
    assert "Nothing new: the mission has learned from all of these data" in answer(again)
    assert any("has learned from all 24 legs already" in notice for notice in again.summary()["notices"])
    again.save(tmp_path / "report")


def test_what_is_new_beside_known_legs_counts_alone(learned, written, tmp_path):
    mission, new = as_written(learned, tmp_path), log(20, seed=3)
    both = pd.concat([log().assign(run="first"), new.assign(run="second")])
    beside = unlearned(read_transit(written("both", both), mission), mission)
    alone = read_transit(written("new", new), mission)
    np.testing.assert_allclose(beside.velocity_error, alone.velocity_error)
    assert "24 legs of 44 from which the mission has learned already" in beside.notices[-1]
    with pytest.raises(InputError, match="4 legs that the mission has not learned from, too few: lay all of them"):
        missionplan.diagnose(
            mission, written("few", pd.concat([log().assign(run=1), log(28, 9).iloc[:4].assign(run=2)])), plan=False
        )


@pytest.mark.parametrize("digits", [6, 5])
def test_a_log_with_a_date_is_known_where_it_is_written_with_fewer_digits(written, digits):
    """A GPX file has six decimals of a degree, NMEA four of a minute: 0.1 to 0.2 m; five decimals are 1.1 m."""
    mission, exact = Mission.from_data(TRANSIT), written_otherwise(log(40, seed=5))
    degrees = [name for name in exact if name.startswith(("lat", "lon"))]
    seconds = ["t_start_s", "t_end_s"]
    rounded = exact.assign(**exact[degrees].round(digits), **exact[seconds].round())
    fine, coarse = (read_transit(written(name, table), mission) for name, table in (("a", exact), ("b", rounded)))
    later = read_transit(written("c", exact.assign(**exact[seconds] + 86_400.0)), mission)
    assert not {each[:16] for each in fine.identities} & {each[:16] for each in coarse.identities}
    for known, new in ((fine, coarse), (coarse, fine)):
        learned_mission = Mission.from_data({**TRANSIT, "learned_from": list(known.identities)})
        assert is_learned(new, learned_mission.learned_from).mean() >= 0.9
    others = read_transit(written("d", written_otherwise(log(40, seed=6))), mission)
    of_fine = Mission.from_data({**TRANSIT, "learned_from": list(fine.identities)})
    assert not is_learned(others, of_fine.learned_from).any()
    assert is_learned(later, of_fine.learned_from).all()  # the same shape, to a centimetre
    both = pd.concat([exact.assign(run="native"), rounded.assign(run="gpx", leg=[f"G{k}" for k in range(40)])])
    assert read_transit(written("both", both), mission).n <= 44


@pytest.mark.slow
def test_a_copy_in_a_campaign_counts_once(learned, written):
    copies = [written("copy", log()), written("its copy", written_otherwise(log()))]
    found = missionplan.diagnose_campaign(Mission.from_data(TRANSIT), copies, plan=False)
    assert angle(found.diagnoses[-1]) == pytest.approx(angle(learned), rel=1e-4)
    assert found.informed_by == {"compass-bias": ("copy",)}


def test_repeated_legs_of_a_log_are_named_and_count_once(learned, written):
    later = {column: log()[column] + 1e6 for column in ("t_start_s", "t_end_s")}
    renamed = log().assign(leg=[f"again {k}" for k in range(24)], **later)
    found = read_transit(written("thrice", pd.concat([log(), renamed, log()])), Mission.from_data(TRANSIT))
    assert found.identities == learned.learned_from
    assert found.notices[-1].startswith("48 legs of 72 stand in the log before, and count once: 1, 2, 3")
    again = read_transit(written("twice", pd.concat([log(), renamed])), Mission.from_data(TRANSIT))
    assert "again 0 (as 1), again 1 (as 2)" in again.notices[-1]


def test_explanations_in_doubt_stay_as_probable_as_they_were(written):
    plain = Mission.from_data({**TRANSIT, "effects": [DOUBT]})
    place = written("first", log())
    mission = Mission.from_data(having_learned(plain.raw, read_transit(place, plain).identities))
    again = missionplan.diagnose(mission, place, plan=False)
    assert [(each.prior, each.probability) for each in again.explanations] == [(0.6, 0.6), (0.4, 0.4)]


@pytest.mark.slow
def test_a_score_on_data_learned_from_says_so(learned, written, tmp_path):
    mission, place = as_written(learned, tmp_path), written("copy", log())
    found = missionplan.score(mission, place, written("new", log(20, seed=3)))
    assert [each["learned_from"] for each in found.score()["datasets"]] == [24, 0]
    assert told_of_score(found).count("learned from all 24 legs: that is no prediction") == 1
    with pytest.raises(InputError, match="holdout: the mission has learned from all of these data"):
        missionplan.diagnose(mission, place, plan=False, holdout=0.3)


@pytest.mark.slow
def test_a_part_held_out_is_not_learned_from(written):
    found = missionplan.diagnose(Mission.from_data(TRANSIT), written("held", log(40)), plan=False, holdout=0.25)
    assert len(found.learned_from) == 30
    assert found.last_part.learned == 0


def dives():
    """Three noisy dives, as they were logged."""
    rng, t = np.random.default_rng(2), np.arange(0.0, 16.0, 0.1)
    runs = [1.3 * np.maximum(t - 2.0, 0.0) + rng.normal(0.0, 0.03, t.size) for _ in range(3)]
    return pd.concat([pd.DataFrame({"run": f"d{k}", "t_s": t, "depth_m": depth}) for k, depth in enumerate(runs)])


def test_a_dive_is_known_by_its_readings(written, descent_mission):
    run = {"anchor_wet_weight": "12 N", "line_length": "5 m", "depth": "40 m"}
    keys = {"kind": "descent", "runs": {f"d{k}": run for k in range(3)}}
    first = read_descent(written("dives", dives(), **keys), descent_mission)
    other = {"d0": "x", "d1": "y", "d2": "z"}
    table = pd.concat([dives().replace({"run": other}), dives().replace({"run": {"d0": "w"}}).iloc[:160]])
    again = read_descent(
        written("again", table, kind="descent", runs=dict.fromkeys("xyzw", run)),
        descent_mission,
    )
    assert {dive.identity for dive in again.dives} == {dive.identity for dive in first.dives}
    assert len(again.dives) == 3
    assert "w (as x)" in again.notices[-1]


def test_a_table_that_stands_twice_counts_once_but_single_rows_may_agree(written, descent_mission):
    rows = ["1.0,2.5", "2.0,9.9", "1.0,2.5"]
    plain = read_tank_data(written("plain", "\n".join(["speed_m_s,force_n", *rows]), **TOWING))
    twice = read_tank_data(
        written("twice", "\n".join(["force_n,speed_m_s", *["9.90,2", "2.50,1", "2.5,1e0"] * 2]), **TOWING)
    )
    assert len(plain.identities) == len(set(plain.identities)) == 3
    assert set(twice.identities) == set(plain.identities)
    assert "the rows stand 2 times over, and count once" in twice.notices
    tests = [
        f"{run},{quantity},{value}"
        for run, value in (("a", 1.2), ("b", 1.4))
        for quantity in ("terminal_velocity_m_s",)
    ]
    table = "\n".join(["run,quantity,value", *tests, *(test.replace("a,", "c,").replace("b,", "d,") for test in tests)])
    assert len(read_summary(written("tests", table, kind="summary"), descent_mission).tests) == 2


def test_tank_data_count_once(written):
    speeds = np.linspace(0.5, 2.0, 9)
    forces = 12.0 * speeds**2 * (1.0 + 0.01 * np.random.default_rng(3).standard_normal(9))
    place = written("tank", pd.DataFrame({"speed_m_s": speeds, "force_n": forces}), **TOWING)
    found = missionplan.diagnose(Mission.from_data(TRANSIT), place, plan=False)
    again = missionplan.diagnose(Mission.from_data(dict(found.extended)), place, plan=False)
    assert len(found.learned_from) == 9
    assert again.learned_from == ()
    assert again.extended == found.extended


def test_the_list_is_checked_kept_short_and_no_difference_of_plans(tmp_path):
    hashes = ["0123456789012345", "12345678901234e5", "ab" * 8]
    mission = Mission.from_data({**TRANSIT, "learned_from": hashes})
    path = tmp_path / "mission.yaml"
    mission.save(path)
    assert load(path).learned_from == tuple(hashes) == load(path).with_(trials=5).learned_from
    for wrong in (["xyz"], [12], "ab" * 8, ["AB" * 8]):
        with pytest.raises(InputError, match="learned_from"):
            Mission.from_data({**TRANSIT, "learned_from": wrong})
    more = having_learned(mission.raw, [f"{k:016x}" for k in range(MOST_LEARNED)])
    assert len(more["learned_from"]) == MOST_LEARNED
    assert more["learned_from"][-1] == f"{MOST_LEARNED - 1:016x}"
    (changed,) = changed_values(TRANSIT, mission.raw)
    assert (changed.path, changed.second) == ("learned_from", "3 legs, dives or runs")
    assert missionplan.schema("mission")["properties"]["learned_from"]["items"]["pattern"] == "^(?:[0-9a-f]{16}){1,2}$"


def test_a_history_counts_the_same_data_once(learned, tmp_path):
    whole = learned.summary()
    part = whole | {"learned_from": list(learned.learned_from[:3]), "created_utc": "2020-01-01T00:00:00+00:00"}
    written = {"a": whole, "b": whole, "known": whole | {"learned_from": []}, "part": part}
    for name, summary in (written | {"foreign": {"command": "other"}}).items():
        place = tmp_path / "in" / name
        place.mkdir(parents=True)
        (place / "summary.json").write_text(json.dumps(summary))
        (place / "diagnosis.json").write_text("{}")
    found = missionplan.history(tmp_path / "in")
    assert found.reports == ("part", "b")
    assert not found.changes
    said = "\n".join(found.provenance.notices)
    assert "a learned from the same data as b" in said
    assert "known learned from nothing new" in said
    assert "part and b learned from 3 legs" in said
    assert "foreign/summary.json: is not the summary of a diagnosis" in said
