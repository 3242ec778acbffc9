"""Parameters from mission to mission: read from reports, in the order of time, with changes."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from matplotlib.figure import Figure

import missionplan
from missionplan.mission.includes import hash_of
from missionplan.montecarlo.levels import Seen
from missionplan.montecarlo.posterior import FILE, PosteriorFile, WeightedDraws
from missionplan.report.render import terminal_view
from missionplan.studies.history import parameter_levels
from missionplan.studies.history.page import _moved, answer, page, parameter


def report(
    root: Path,
    name: str,
    created: str,
    *,
    found: dict[str, tuple[float, float]] | None = None,
    confirmed: dict[str, tuple[float, float]] | None = None,
    changed: tuple[str, ...] = (),
    start: str = "",
    probability: float | None = None,
) -> None:
    """Write what `diagnose` writes of a compass and other effects of one parameter in degrees."""

    def numbers(value: float, sd: float) -> dict[str, object]:
        return {"value": value, "sd": sd, "low": value - 1.645 * sd, "high": value + 1.645 * sd, "unit": "rad"}

    folder = root / name
    folder.mkdir(parents=True)
    parameters = [{"effect": key, "name": "angle", **numbers(*value)} for key, value in (found or {}).items()]
    summary = {
        "mission": "made",
        "dataset": name,
        "created_utc": created,
        "causes": list(found or {}),
        "ranking": [{"parameters": parameters}],
        "confirmed": [
            {"effect": key, "name": "angle", "prior": {}, "posterior": numbers(*value)}
            for key, value in (confirmed or {}).items()
        ],
        "changed": bool(changed),
        "changed_effects": list(changed),
    }
    if probability is not None:
        held = [{"causes": list(found or {}), "probability": probability}]
        summary["explanations"] = [*held, {"causes": ["mean-current"], "probability": 1.0 - probability}]
    (folder / "summary.json").write_text(json.dumps(summary))
    (folder / "diagnosis.json").write_text("{}")
    (folder / "mission.yaml").write_text(yaml.safe_dump({"name": "made", **({"start": start} if start else {})}))


def test_parameters_are_followed_in_the_order_of_time(tmp_path: Path) -> None:
    report(tmp_path, "c", "2026-05-03T00:00:00+00:00", found={"compass-bias": (0.10, 0.01)}, changed=("compass-bias",))
    report(tmp_path, "a", "2026-05-01T00:00:00+00:00", found={"compass-bias": (0.05, 0.01)})
    report(tmp_path, "deep/b", "2026-05-02T00:00:00+00:00", confirmed={"compass-bias": (0.049, 0.006)})
    found = missionplan.history(tmp_path)
    assert found.reports == ("a", "deep/b", "c")
    (entries,) = found.parameters.values()
    assert [each.state for each in entries] == ["found", "confirmed", "changed"]
    assert [each.value for each in entries] == [0.05, 0.049, 0.10]
    assert [each.report for each in found.changes] == ["c"]


@pytest.mark.parametrize(
    ("last", "probability", "said"),
    [(0.052, 1.0, "None changed"), (0.052, 0.4, "tells"), (0.09, 1.0, "from 2.9 ± 0.6° to 5.2 ± 0.3°")],
)
def test_what_moved_or_is_in_doubt_is_not_said_to_be_unchanged(
    last: float, probability: float, said: str, tmp_path: Path
) -> None:
    report(tmp_path, "a", "2026-05-01T00:00:00+00:00", found={"compass-bias": (0.05, 0.01)})
    report(tmp_path, "b", "2026-05-02T00:00:00+00:00", confirmed={"compass-bias": (last, 0.006)})
    file = tmp_path / "b" / "summary.json"
    summary = json.loads(file.read_text())
    summary["confirmed"][0]["probability"] = probability
    file.write_text(json.dumps(summary))
    found = missionplan.history(tmp_path)
    assert found.parameters["compass-bias", "angle"][1].probability == probability
    assert said.replace("tells", "tell of 1 parameter.") in answer(found).replace("\u00a0", " ")
    assert ("None changed" in answer(found)) == (said == "None changed")


def test_starts_of_the_missions_go_before_the_times_of_the_reports(tmp_path: Path) -> None:
    """Old missions may be diagnosed late."""
    report(tmp_path, "a", "2026-05-09T00:00:00Z", found={"compass-bias": (0.05, 0.01)}, start="2026-01-01T00:00:00Z")
    report(tmp_path, "b", "2026-05-01T00:00:00Z", found={"compass-bias": (0.05, 0.01)}, start="2026-02-01T00:00:00Z")
    assert missionplan.history(tmp_path).reports == ("a", "b")


def told_afresh(root: Path, name: str, day: int, value: float, sd: float, of: int | None = None) -> None:
    """A report that found a compass bias [rad] afresh, with the draws that say what its record tells of the level."""
    report(root, name, f"2026-05-{day:02d}T00:00:00Z", found={"compass-bias": (value, sd)})
    record, file = f"{day:016x}", root / name / "summary.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "learned_from": [record]}))
    normals = np.random.default_rng(day).standard_normal((500, 1))
    draws = WeightedDraws(
        (("compass-bias",),), np.zeros(500, int), (("compass-bias", "angle"),), value + sd * normals, np.full(500, 2e-3)
    )
    seen = Seen(("compass-bias", "angle", "strength"), hash_of([record]), 1.78e9 + (of or day) * 86400.0, value, sd)
    content = PosteriorFile.of(draws, hash_of([record]), {}, seen=[seen]).content
    (root / name / FILE).write_bytes(content)


def test_reports_are_in_the_order_of_their_data_whatever_their_names_and_when_they_were_made(tmp_path: Path) -> None:
    """An extended mission keeps its `start`, so that it tells of no order."""
    for day, (name, of) in enumerate([("summer", 30), ("spring", 20), ("autumn", 40)], 1):
        told_afresh(tmp_path, name, day, 0.05 + 0.001 * of, 0.002, of)
        (tmp_path / name / "mission.yaml").write_text(yaml.safe_dump({"name": "made", "start": "2026-01-01T00:00:00Z"}))
    found = missionplan.history(tmp_path)
    assert (found.ordered_by, found.reports) == ("data", ("spring", "summer", "autumn"))
    assert [each.report for each in found.entries] == [each.record for each in found.levels[0].missions]
    assert [each.time[:10] for each in found.entries] == ["2026-06-17", "2026-06-27", "2026-07-07"]
    report(tmp_path, "other", "2026-05-02T12:00:00Z", found={"fix-error": (0.05, 0.01)}, start="2026-01-01T00:00:00Z")
    assert missionplan.history(tmp_path).reports == ("summer", "spring", "other", "autumn")


def test_values_found_afresh_are_followed_by_their_level(tmp_path: Path) -> None:
    """0.05, 0.05 and then 0.13 rad with 0.005 each, 11 standard deviations apart, or 0.055, less than one."""
    for last, jumps in ((0.13, ["c"]), (0.055, [])):
        root = tmp_path / str(last)
        for day, (name, value) in enumerate([("a", 0.05), ("b", 0.05), ("c", last), ("d", last)], 1):
            told_afresh(root, name, day, value, 0.005)
        found = missionplan.history(root)
        (level,) = found.levels
        assert [each.record for each in level.jumps] == jumps
        assert [each.value for each in level.missions] == pytest.approx([0.05, 0.05, last, last], abs=0.004)
        assert [each.report for each in found.changes] == jumps
        assert ("jumped before c" in answer(found)) == bool(jumps)


@pytest.mark.parametrize(("other", "agree"), [(0.055, True), (0.13, False)])
def test_two_vehicles_of_one_day_are_not_taken_for_one_that_held_still(
    other: float, agree: bool, tmp_path: Path
) -> None:
    for day, (name, value) in enumerate([("a", 0.05), ("b", other)], 1):
        told_afresh(tmp_path, name, day, value, 0.005, of=1)
    found = missionplan.history(tmp_path)
    assert ("None changed" in answer(found)) == agree
    assert ("do not agree on the angle of compass bias: are they of one vehicle?" in answer(found)) != agree
    squared = (other - 0.05) ** 2 / (2.0 * 0.005**2)  # χ² of one degree of freedom
    assert found.levels[0].agreement == pytest.approx(math.erfc(math.sqrt(squared / 2.0)))


def test_what_is_new_beside_a_change_is_not_a_change(tmp_path: Path) -> None:
    found = {"compass-bias": (0.10, 0.01), "speed-scale": (0.02, 0.01)}
    report(tmp_path, "a", "2026-05-01T00:00:00Z", found=found, changed=("compass-bias",))
    assert [each.effect for each in missionplan.history(tmp_path).changes] == ["compass-bias"]


def test_the_report_names_the_change(tmp_path: Path) -> None:
    report(tmp_path / "in", "a", "2026-05-01T00:00:00Z", found={"compass-bias": (0.05, 0.01)})
    report(
        tmp_path / "in", "b", "2026-05-02T00:00:00Z", found={"compass-bias": (0.10, 0.01)}, changed=("compass-bias",)
    )
    folder = missionplan.history(tmp_path / "in").save(tmp_path / "out")
    assert "Not as before: angle of compass bias in b" in (folder / "report.html").read_text()
    assert (folder / "history.csv").read_text().count("\n") == 3
    assert (folder / "figures" / "history.svg").is_file()


@pytest.mark.parametrize(
    ("units", "told"), [(("nautical",) * 2, "0.78 to 1.16 kn"), (("nautical", ""), "0.40 to 0.60 m/s")]
)
def test_speeds_are_told_in_the_units_that_all_missions_have(units: tuple[str, str], told: str, tmp_path: Path) -> None:
    for name, system in zip("ab", units, strict=True):
        report(tmp_path, name, f"2026-05-0{1 + (name == 'b')}T00:00:00+00:00", found={"mean-current": (0.5, 0.06)})
        file = tmp_path / name / "summary.json"
        file.write_text(file.read_text().replace('"rad"', '"m/s"'))
        (tmp_path / name / "mission.yaml").write_text(f"name: made\nunits: {system}\n" if system else "name: made\n")
    rows = terminal_view(missionplan.history(tmp_path)).rows
    assert {row[3].replace("\u00a0", " ") for row in rows} == {told}


def test_a_folder_without_reports_is_refused(tmp_path: Path) -> None:
    with pytest.raises(missionplan.InputError, match="holds no report of diagnose"):
        missionplan.history(tmp_path)
    with pytest.raises(missionplan.InputError, match="no such folder"):
        missionplan.history(tmp_path / "none")
    (tmp_path / "summary.json").write_text("[")
    (tmp_path / "diagnosis.json").write_text("{}")
    with pytest.raises(missionplan.InputError, match="is not valid JSON"):
        missionplan.history(tmp_path)


def test_what_was_found_in_doubt_is_said_to_be(tmp_path: Path) -> None:
    report(tmp_path, "a", "2026-05-01T00:00:00+00:00", found={"compass-bias": (0.05, 0.01)}, probability=0.45)
    report(tmp_path, "b", "2026-05-02T00:00:00+00:00", found={"compass-bias": (0.05, 0.01)})
    history = missionplan.history(tmp_path)
    assert history.to_frame()["probability"].tolist() == [0.45, 1.0]
    states = [row[-1] for row in page(history).table()[1]]
    assert states == ["found, if it is that (45 %)", "found"]


def test_data_that_reports_share_are_named_and_the_same_data_count_once(tmp_path: Path) -> None:
    for day, (name, learned) in enumerate({"a": "123", "b": "321", "c": "346", "d": "7", "e": ""}.items(), 1):
        report(tmp_path, name, f"2026-05-{day:02d}T00:00:00Z", found={"compass-bias": (0.05, 0.01)})
        file = tmp_path / name / "summary.json"
        file.write_text(json.dumps({**json.loads(file.read_text()), "learned_from": list(learned)}))
    found = missionplan.history(tmp_path)
    assert found.reports == ("b", "c", "d")
    assert sorted(found.provenance.notices) == [
        "a learned from the same data as b, which was made later, and is left out",
        "b and c learned from 1 legs, dives or runs in common, which count twice",
        "e learned from nothing new, and is left out",
    ]


def test_a_report_of_other_code_is_named(tmp_path: Path) -> None:
    for name, code in (("a", "1" * 64), ("b", "2" * 64), ("c", "2" * 64)):
        report(tmp_path, name, f"2026-05-0{'abc'.index(name) + 1}T00:00:00Z", found={"compass-bias": (0.05, 0.01)})
        file = tmp_path / name / "summary.json"
        parts = {"version": "0.1", "code": code, "plugins": {}, "libraries": {}}
        file.write_text(json.dumps({**json.loads(file.read_text()), "identity_parts": parts}))
    (notice,) = missionplan.history(tmp_path).provenance.notices
    assert (
        notice == "the report a was made by other code than c: code of missionplan: was 111111111111, now 222222222222"
    )


def test_what_is_no_report_is_named_and_the_rest_is_told(tmp_path: Path) -> None:
    """Each has the files of a report: of another tool, of another kind, broken, with numbers that are none."""
    for name in ("good", "other", "broken", "utf-16", "names", "huge"):
        report(tmp_path, name, "2026-05-01T00:00:00+00:00", found={"compass-bias": (0.05, 0.01)})
    whole = (tmp_path / "good" / "summary.json").read_text()
    (tmp_path / "other" / "summary.json").write_text("[1]")
    (tmp_path / "broken" / "mission.yaml").write_text("a: [")
    (tmp_path / "utf-16" / "summary.json").write_bytes(whole.encode("utf-16"))
    (tmp_path / "names" / "summary.json").write_text(whole.replace('"compass-bias", "name"', '3, "name"'))
    (tmp_path / "huge" / "summary.json").write_text(whole.replace('"sd": 0.01', f'"sd": 1{"0" * 400}'))
    found = missionplan.history(tmp_path)
    assert found.reports == ("good",)
    assert len(found.provenance.notices) == 5
    assert all(notice.startswith("left out: ") for notice in found.provenance.notices)


def test_every_number_of_an_entry_is_its_report_s(tmp_path: Path) -> None:
    """And where all missions have a start, their times are those; the order of what has none is that of the reports."""
    both = {"compass-bias": (0.05, 0.01), "speed-scale": (-0.02, 0.003)}
    report(tmp_path, "a", "2026-05-09T00:00:00Z", found=both, start="2026-01-01T00:00:00Z", probability=0.8)
    report(
        tmp_path, "b", "2026-05-01T00:00:00Z", confirmed={"compass-bias": (0.06, 0.02)}, start="2026-02-01T00:00:00Z"
    )
    found = missionplan.history(tmp_path)
    assert found.ordered_by == "start"
    rows = [
        (e.report, e.mission, e.dataset, e.time[:10], e.effect, e.name, e.value, e.sd, e.unit, e.state, e.probability)
        for e in found.entries
    ]
    assert rows == [
        ("a", "made", "a", "2026-01-01", "compass-bias", "angle", 0.05, 0.01, "rad", "found", 0.8),
        ("a", "made", "a", "2026-01-01", "speed-scale", "angle", -0.02, 0.003, "rad", "found", 0.8),
        ("b", "made", "b", "2026-02-01", "compass-bias", "angle", 0.06, 0.02, "rad", "confirmed", 1.0),
    ]
    for each in found.entries:
        assert (each.low, each.high) == pytest.approx((each.value - 1.645 * each.sd, each.value + 1.645 * each.sd))
    assert [parameter.effect for parameter in found.values] == ["compass-bias", "speed-scale"]
    (tmp_path / "b" / "mission.yaml").write_text("name: made")
    later = missionplan.history(tmp_path)
    assert (later.ordered_by, later.reports) == ("created", ("b", "a"))
    assert [each.time[:10] for each in later.entries] == ["2026-05-01", "2026-05-09", "2026-05-09"]


def test_a_level_that_holds_still_is_the_weighted_mean_of_its_measurements(tmp_path: Path) -> None:
    values, sds = (0.050, 0.056, 0.047, 0.052), (0.004, 0.008, 0.005, 0.002)
    for day, (name, value, sd) in enumerate(zip("abcd", values, sds, strict=True), 1):
        told_afresh(tmp_path, name, day, value, sd)
    (level,) = missionplan.history(tmp_path).levels
    weights = np.array(sds) ** -2.0
    mean = float(weights @ values / weights.sum())
    assert (level.effect, level.name, level.unit) == ("compass-bias", "angle", "rad")
    assert [each.record for each in level.missions] == list("abcd")
    assert [each.date for each in level.missions] == [1.78e9 + day * 86400.0 for day in range(1, 5)]
    assert level.agreement == 1.0  # one measurement a day tells nothing of it
    assert level.next_value == pytest.approx(mean, abs=0.004)
    assert [each.value for each in level.missions] == pytest.approx([mean] * 4, abs=0.004)


def test_two_records_of_a_day_agree_as_their_difference_over_its_error_tells(tmp_path: Path) -> None:
    """0.01 apart with 0.005 each: χ² is 2 with one degree of freedom, whatever other days there are."""
    for day, (name, value, of) in enumerate([("a", 0.05, 1), ("b", 0.06, 1), ("c", 0.055, 3)], 1):
        told_afresh(tmp_path, name, day, value, 0.005, of)
    (level,) = missionplan.history(tmp_path).levels
    assert level.agreement == pytest.approx(math.erfc(1.0), abs=1e-9)


def test_what_was_learned_is_drawn_report_by_report_and_has_moved_beyond_three_errors(tmp_path: Path) -> None:
    """In degrees, with the reports' own intervals; a dashed line before the change. 3.1 errors apart is a move, 2.9 none."""
    report(tmp_path, "a", "2026-05-01T00:00:00Z", found={"compass-bias": (0.05, 0.01)})
    report(tmp_path, "b", "2026-05-02T00:00:00Z", found={"compass-bias": (0.10, 0.02)}, changed=("compass-bias",))
    found, axes = missionplan.history(tmp_path), Figure().add_subplot()
    parameter(axes, found)
    points = [np.ravel(line.get_data()) for line in axes.get_lines() if line.get_marker() == "o"]
    assert np.array(points) == pytest.approx(np.array([[1.0, math.degrees(0.05)], [2.0, math.degrees(0.10)]]))
    spans = [bar.get_segments()[0][:, 1] for bar in axes.collections]
    assert np.array(spans) == pytest.approx(np.degrees([[0.03355, 0.06645], [0.0671, 0.1329]]))
    assert [line.get_xdata()[0] for line in axes.get_lines() if line.get_linestyle() == "--"] == [1.5]
    first = found.entries[0]
    for away, moved in ((3.1, True), (2.9, False)):
        assert _moved([first, replace(first, value=first.value + away * math.hypot(0.01, 0.02), sd=0.02)]) == moved


def test_levels_of_a_strength_alone_are_told() -> None:
    """A deviation's two parts have levels too, whose sign and size say nothing by themselves."""
    keys = (
        ("compass-deviation", "amplitude", "cosine"),
        ("compass-bias", "angle", "strength"),
        ("compass-deviation", "amplitude", "sine"),
    )
    seen = [Seen(key, f"{day:064x}", 1e5 * day, 0.05, 0.01) for day in (1, 2) for key in keys]
    assert [(each.effect, each.name, len(each.missions)) for each in parameter_levels(seen)] == [
        ("compass-bias", "angle", 2)
    ]
