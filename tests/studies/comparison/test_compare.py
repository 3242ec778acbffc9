"""Two reports side by side: what changed, and what is noise."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

import missionplan
from missionplan.errors import InputError
from missionplan.report.render import render_report, terminal_view
from missionplan.results import to_yaml
from missionplan.studies.comparison import compare
from missionplan.studies.comparison.two_reports import holm, summary_numbers

FIG8 = Path(__file__).parents[3] / "missions" / "fig8.yaml"

MISSION = {
    "name": "Bay",
    "site": {"depth": "40 ft"},
    "phases": [
        {"transit": {"name": "ingress", "speed": "1.5 m/s", "d_max": "350 m"}},
        {"moor": {"radius": "75 ft", "release_time": {"mean": "10 s", "sd": "3 s"}}},
    ],
}


def statistic(mean, error):
    return {"mean": mean, "sd": 1.0, "p05": 0.0, "p50": 0.0, "p95": 0.0, "standard_error": error}


def share(value, half=0.01):
    return {"value": value, "low": value - half, "high": value + half}


def simulated(*, offset=10.0, success=0.9, met=True, trials=10_000, seed=1):
    return {
        "command": "simulate",
        "mission": "Bay",
        "seed": seed,
        "trials": trials,
        "version": "0.1",
        "options": {"precision": None},
        "phases": [
            {
                "name": "moor",
                "kind": "moor",
                "quantities": {"offset_m": statistic(offset, 0.1), "duration_s": statistic(1200.0, 0.0)},
                "events": {"within_radius": share(0.97)},
            }
        ],
        "total": {"quantities": {"energy_wh": statistic(30.0, 0.02)}, "events": {"success": share(success)}},
        "requirements": [
            {"quantity": "moor.offset", "at_most": 20.0, "required": 0.9, "probability": share(success), "met": met}
        ],
    }


@pytest.fixture
def report(tmp_path):
    """Write report folders."""
    count = iter(range(10))

    def write(summary, mission=MISSION) -> Path:
        folder = tmp_path / f"report-{next(count)}"
        folder.mkdir()
        (folder / "summary.json").write_text(summary if isinstance(summary, str) else json.dumps(summary))
        (folder / "mission.yaml").write_text(to_yaml(mission))
        return folder

    return write


def verdicts(comparison):
    return {(item.group, item.key): item.verdict for item in comparison.differences}


def test_a_report_is_the_same_as_itself(report):
    folder = report(simulated())
    comparison = compare(folder, folder)
    assert set(verdicts(comparison).values()) == {"same"}
    assert comparison.mission_changes == comparison.option_changes == comparison.requirement_changes == ()
    assert terminal_view(comparison).sentence == "The results are the same."


def test_a_difference_beyond_noise_is_distinguished_from_noise(report):
    comparison = compare(report(simulated(seed=1)), report(simulated(offset=11.0, success=0.903, seed=2)))
    found = verdicts(comparison)
    assert found["moor", "offset_m"] == "changed"
    assert found["total", "success"] == "within noise"
    assert found["total", "energy_wh"] == "same"
    assert (
        "most clearly the offset of the anchor (moor) (+3.3\u00a0±\u00a00.5\u00a0ft)"
        in terminal_view(comparison).sentence
    )
    (offset,) = comparison.changed
    assert offset.standard_error == pytest.approx(0.1 * math.sqrt(2.0))
    assert offset.p_value == pytest.approx(2.0 * norm.sf(1.0 / (0.1 * math.sqrt(2.0))))


def test_two_shares_are_tested_as_pooled(report):
    first, second = simulated(success=0.9, trials=1000, seed=1), simulated(success=0.93, trials=2000, seed=2)
    (found,) = (item for item in compare(report(first), report(second)).differences if item.key == "success")
    pooled = (900 + 1860) / 3000
    score = 0.03 / math.sqrt(pooled * (1.0 - pooled) * (1 / 1000 + 1 / 2000))
    assert found.p_value == pytest.approx(2.0 * norm.sf(score))


def test_a_requirement_that_is_no_longer_met_is_reported(report):
    comparison = compare(report(simulated()), report(simulated(met=False, seed=2)))
    assert (
        "The requirement on the offset of the anchor (moor) was met and is now not met."
        in terminal_view(comparison).sentence
    )


def test_a_requirement_that_has_become_undecided_is_reported(report):
    unsure = simulated(seed=2)
    unsure["requirements"][0]["undecided"] = True
    comparison = compare(report(simulated()), report(unsure))
    assert (
        "The requirement on the offset of the anchor (moor) was met and is now undecided."
        in terminal_view(comparison).sentence
    )


def test_requirements_on_one_quantity_are_told_apart_by_their_limits(report):
    first, second = simulated(), simulated(seed=2)
    for summary, met in ((first, True), (second, False)):
        summary["requirements"].append({**summary["requirements"][0], "at_most": 15.0, "met": met})
    changes = compare(report(first), report(second)).requirement_changes
    assert [(change.path, change.first, change.second) for change in changes] == [
        ("moor.offset at most 15", "met", "not met")
    ]


def test_what_changed_in_the_mission_is_named_by_key(report):
    other = {**MISSION, "site": {"depth": "12.192 m"}, "phases": [dict(MISSION["phases"][0])]}
    other["phases"][0] = {"transit": {"name": "ingress", "speed": "1.4 m/s", "d_max": "0.35 km", "depth": "2 m"}}
    comparison = compare(report(simulated()), report(simulated(), other))
    changed = {change.path: (change.first, change.second) for change in comparison.mission_changes}
    assert changed == {
        "ingress.speed": ("1.5 m/s", "1.4 m/s"),
        "ingress.depth": ("", "2 m"),
        "moor.radius": ("75 ft", ""),
        "moor.release_time.mean": ("10 s", ""),
        "moor.release_time.sd": ("3 s", ""),
    }


def test_seeds_and_options_are_named_apart_from_the_mission(report):
    comparison = compare(report(simulated()), report({**simulated(seed=2), "options": {"precision": "0.5%"}}))
    assert [(change.path, change.second) for change in comparison.option_changes] == [
        ("seed", "2"),
        ("option precision", "0.5%"),
    ]
    assert comparison.provenance.notices == ()


def test_runs_of_one_seed_are_reported_to_share_draws(report):
    assert "share draws" in compare(report(simulated()), report(simulated())).provenance.notices[0]


def test_a_number_that_one_run_lacks_is_reported_as_missing(report):
    first = simulated()
    del first["total"]["quantities"]["energy_wh"]
    assert verdicts(compare(report(first), report(simulated())))["total", "energy_wh"] == "only second"


def test_noise_alone_seldom_changes_anything():
    random = np.random.default_rng(1)
    false = [min(holm(list(2.0 * norm.sf(np.abs(random.standard_normal(30)))))) < 0.05 for _ in range(2000)]
    assert np.mean(false) == pytest.approx(0.05, abs=0.015)


def test_holm_by_hand():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([]) == []


def swept(best, cost, seed):
    curve = [{"d_max_m": d, "cost": cost + d / 1e5, "standard_error": 0.001, "surfacings": 3.0} for d in (100.0, 200.0)]
    short = {"d_max_m": best, "d_max_over_distance": best / 1000.0, "cost": cost, "standard_error": 0.001}
    sweep = [{"sigma_m_s": 0.035, "curve": curve, "best": short, "one_leg": {"cost": 0.2, "standard_error": 0.001}}]
    return {"command": "sweep-dmax", "mission": "Bay", "seed": seed, "trials": 1000, "options": {}, "sweep": sweep}


def test_sweeps_are_compared_point_by_point_and_their_best_d_max_is_not_judged(report):
    found = verdicts(compare(report(swept(100.0, 0.05, 1)), report(swept(200.0, 0.08, 2))))
    assert found["sweep, 0.035, best", "d_max_m"] == "not judged"
    assert found["sweep, 0.035, best", "cost"] == "changed"
    assert found["sweep, 0.035, curve, 200", "cost"] == "changed"
    assert found["sweep, 0.035, one_leg", "cost"] == "same"


def sized(weight):
    anchor = {"wet_weight_n": weight, "drag_n": {"total": 11.0}, "feasible": True, "problems": []}
    return {"command": "size-anchor", "mission": "Bay", "seed": 1, "trials": 0, "options": {}, "anchor": anchor}


def test_anchors_are_compared_exactly(report):
    found = verdicts(compare(report(sized(11.8)), report(sized(12.0))))
    assert found == {("anchor", "wet_weight_n"): "changed", ("anchor, drag_n", "total"): "same"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "is not valid JSON"),
        ("[1]", "is not a summary"),
        ("1" * 5000, "is not valid JSON"),  # more digits than Python converts
        ("[" * 100_000, "is not valid JSON"),
        ('{"command": "identify"}', "cannot be compared"),
    ],
)
def test_what_is_no_report_is_refused(report, text, words):
    folder = report(text)
    with pytest.raises(InputError, match=words):
        compare(folder, folder)


def test_reports_of_two_commands_are_refused(report, tmp_path):
    with pytest.raises(InputError, match="two reports of one command were expected"):
        compare(report(simulated()), report(sized(1.0)))
    with pytest.raises(InputError, match="no such folder"):
        compare(report(simulated()), tmp_path / "nothing")


def test_a_summary_of_odd_shape_is_read_as_far_as_it_goes(report):
    odd = {**simulated(), "phases": [None, {"name": ["x"], "quantities": 3}, "x"], "requirements": [1], "total": []}
    assert compare(report(odd), report(simulated())).differences


def test_the_page_and_its_folder(report, tmp_path):
    comparison = compare(report(simulated()), report(simulated(offset=11.0, seed=2)))
    html = render_report(comparison).html
    assert "missionplan compare " in html
    assert "1 of 6 numbers changed" in html
    assert "requirement" in html
    comparison.save(tmp_path / "out")
    assert json.loads((tmp_path / "out/summary.json").read_text())["compared"] == "simulate"
    assert (tmp_path / "out/differences.csv").read_text().startswith("group,key,kind,first,second,change")


def test_missions_are_compared_in_python_by_their_names():
    mission = missionplan.load(FIG8)
    slow, fast = (mission.with_({"name": name, "ingress.speed": name}) for name in ("1.2 m/s", "1.3 m/s"))
    found = missionplan.compare(slow, fast, trials=40, seed=1)
    assert [each.name for each in found.alternatives] == ["1.2 m/s", "1.3 m/s"]
    assert [tick.get_text() for tick in found.plot().get_yticklabels()] == ["1.2 m/s", "1.3 m/s"]
    still, *_ = found.decision_for_crew().assumes  # of the better one
    assert (still.what, still.turns) == ("there is no current", True)
    assert "But this assumes that there is no current" in terminal_view(found).sentence


def with_identity(summary, **changed):
    parts = {"version": "0.1", "code": "a" * 64, "plugins": {}, "libraries": {"numpy": "2.0"}, **changed}
    return {**summary, "identity_parts": parts}


def test_other_code_is_named_as_what_a_difference_may_come_of(report):
    other = with_identity(simulated(seed=2), code="b" * 64, libraries={"numpy": "2.1"})
    (notice,) = compare(report(with_identity(simulated())), report(other)).provenance.notices
    assert "code of missionplan: was aaaaaaaaaaaa, now bbbbbbbbbbbb; library numpy: was 2.0, now 2.1" in notice


def test_one_identity_with_two_answers_is_told(report):
    same, other = with_identity(simulated()), with_identity(simulated(offset=10.001))
    assert not any("one identity" in each for each in compare(report(same), report(same)).provenance.notices)
    assert any("one identity" in each for each in compare(report(same), report(other)).provenance.notices)


@pytest.mark.parametrize("odd", [3, "x", [1], {"phases": 3}, [{"quantities": {"duration_s": 10**400}}], None])
def test_sections_of_a_summary_that_are_none_hold_no_results(odd):
    numbers = summary_numbers({"phases": odd, "total": odd, "requirements": odd}, "simulate")
    assert all(math.isfinite(each.value) for each in numbers.values())


def test_phases_may_be_called_as_the_keys_of_a_summary_are(report):
    """Names are labels: a phase called as a section, a kind of number or a sweep's part is a phase like any other."""
    names = ("events", "quantities", "phases", "requirement", "sweep, 0.035, recommended")

    def summary(offset):
        phases = [
            {"name": name, "quantities": {"duration_s": {"mean": 100.0 * k + offset, "standard_error": 0.1}}}
            for k, name in enumerate(names)
        ]
        return {**simulated(), "phases": phases}

    found = compare(report(summary(0.0)), report(summary(5.0)))
    changed = [each for each in found.changed if each.key == "duration_s"]
    assert [each.group for each in changed] == list(names)
    assert [each.first for each in changed] == [0.0, 100.0, 200.0, 300.0, 400.0]
    assert not set(changed) & set(found.deciding)


def test_what_has_no_known_noise_is_not_said_to_have_changed(report):
    def one_trial(offset, reached):
        quantities = {"offset_m": statistic(offset, None), "duration_s": statistic(1200.0, 0.0)}
        required = {"quantity": "moor.offset", "at_most": 20.0, "required": 0.9, "reached": reached}
        phases = [{"name": "moor", "kind": "moor", "quantities": quantities, "events": {}}]
        return {**simulated(trials=1), "phases": phases, "requirements": [required]}

    found = compare(report(one_trial(6.8, 7.7)), report(one_trial(1.2, 8.0)))
    verdicts = {(item.group, item.key): item.verdict for item in found.differences if item.change}
    assert set(verdicts.values()) == {"not judged"}
    assert len(verdicts) == 2
    assert terminal_view(found).sentence.endswith("No number is known to have changed by more than Monte-Carlo noise.")
