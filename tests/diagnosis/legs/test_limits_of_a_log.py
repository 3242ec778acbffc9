"""What a log cannot show, however well it fits: few legs, one heading, a cause that changes."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from missionplan import diagnose
from missionplan.datasets.legs import read_transit
from missionplan.diagnosis.diagnose import taken_as_exact
from missionplan.diagnosis.inference.model import fitted
from missionplan.diagnosis.legs.fit_checks import not_constant
from missionplan.diagnosis.legs.kind import TransitKind, transit_model, widened
from missionplan.mission import Mission
from missionplan.report.diagnosis.page import answer
from missionplan.report.render import render_report
from missionplan.results.learned.evidence import Coverage
from tests.fixtures import TRANSIT, make_legs


def words_of(found):
    """Return the report with plain spaces."""
    return re.sub("[\u00a0\u202f]", " ", render_report(found).html)


CAUSES = ("speed-scale", "mean-current", "persistent-error")
KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}


def drifting(sigma, time):
    def error(t, heading):
        rng = np.random.default_rng(3)
        covariance = sigma**2 * np.exp(-np.abs(t[:, None] - t[None, :]) / time)
        return (np.linalg.cholesky(covariance + 1e-12 * np.eye(len(t))) @ rng.normal(size=(len(t), 2))).T

    return error


def slow(fraction):
    return lambda t, heading: 1.2 * fraction * np.stack([np.sin(heading), np.cos(heading)])


def turned(angle):
    def error(t, heading):
        actual = heading + angle(t)
        return 1.2 * np.stack([np.sin(actual) - np.sin(heading), np.cos(actual) - np.cos(heading)])

    return error


@pytest.mark.parametrize(("change", "expected"), [(0.0, ()), (0.06, ("mean-current",))])
def test_a_current_that_changes_halfway_is_not_constant(change, expected, folder, transit_mission, legs):
    def error(t, heading):
        return np.stack([0.1 + np.where(t > np.median(t), change, 0.0), 0.0 * t])

    model = transit_model(read_transit(folder(KIND, legs(error=error)), transit_mission), transit_mission, 1)
    assert not_constant(model, model.fit(("mean-current",))) == expected


@pytest.mark.parametrize(("reckoned_speed", "is_order"), [(0.13, False), (0.02, True)])
@pytest.mark.usefixtures("among_few")
def test_a_speed_that_the_log_lacks_is_no_fault_of_the_vehicle(reckoned_speed, is_order, folder, transit_mission, legs):
    """A dead reckoning made from pitch and depth rate knows no angle of attack: no speed is calibrated by it."""
    log = folder({**KIND, "noise": {"fix": "3 m", "reckoned_speed": reckoned_speed}}, legs(n=12, error=slow(-0.1)))
    found = diagnose(transit_mission, log, plan=False)
    assert found.causes == ("speed-scale",)
    assert ("measured mile" in answer(found)) == is_order
    assert ("made without a logged speed: correct nothing yet" in answer(found)) != is_order


def put_off(mission, log, cause):
    """The ledger of a log of which one cause is claimed, by what was put off."""
    bound = TransitKind.bind("transit", log, mission, 1)
    none, alone = fitted(bound.model, [((), ()), ((cause,), ())])
    claimed = SimpleNamespace(causes=(cause,), score=alone.log_evidence - none.log_evidence)
    rows = taken_as_exact(bound, SimpleNamespace(best=claimed, selection=SimpleNamespace(ranking=(claimed,))))
    return {(row.what, row.otherwise): row for row in rows}


def test_what_a_log_takes_as_exact_moves_the_answer_by_as_much(folder, transit_mission, legs):
    """Headings off by 1° are a compass off by 1°; where it was no more, no compass is likelier."""
    declination = "the log's headings have the right declination", "1° more"
    for angle, turns in ((3.0, False), (1.0, True)):
        log = folder(KIND, legs(sigma=0.01, error=turned(lambda t, angle=angle: np.radians(angle))))
        found = put_off(transit_mission, log, "compass-bias")[declination]
        assert np.degrees(found.moves.value) == pytest.approx(-1.0, abs=0.01)
        assert (found.turns, found.likeliest) == (turns, () if turns else ("compass-bias",))
    assert "twice as much" in {otherwise for _, otherwise in put_off(transit_mission, log, "compass-bias")}


def test_a_current_taken_as_exact_moves_that_found_beside_it(folder, transit_mission, legs):
    """The legs show the sum of both."""
    layer = {"down_to": "30 m", "speed": "0.2 m/s", "toward": "90 deg"}
    mission = transit_mission.with_({"site.current": [layer]})
    log = folder(KIND, legs(error=lambda t, heading: np.stack([0.4 + 0.0 * t, 0.3 + 0.0 * t])))
    for name in ("east", "north"):
        found = put_off(mission, log, "mean-current")[
            "the current is as the mission has it", f"0.1 m/s more to the {name}"
        ]
        assert (found.moves.name, found.moves.value) == (name, pytest.approx(-0.1, abs=0.005))
    assert not any("current" in what for what, _ in put_off(transit_mission, log, "mean-current"))


@pytest.mark.parametrize("count", [8, *(pytest.param(n, marks=pytest.mark.slow) for n in (14, 19))])
@pytest.mark.usefixtures("among_few")
def test_few_legs_leave_it_possible_that_errors_merely_persist(count, folder, transit_mission, legs):
    found = diagnose(transit_mission, folder(KIND, legs(count, error=drifting(0.2, 9000.0))), plan=False)
    assert "persistent-error" not in found.untestable
    assert any("persistent-error" in causes for causes in found.credible_set)
    assert found.verdict != "explained"


@pytest.mark.slow
def test_eight_legs_of_a_compass_swing_are_enough(folder, transit_mission, legs):
    found = diagnose(
        transit_mission, folder(KIND, legs(8, sigma=0.01, error=turned(lambda t: np.radians(8.0)))), plan=False
    )
    assert found.causes == ("compass-bias",)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_headings_that_separate_nothing_leave_a_current_its_chance(seed, folder, transit_mission, legs):
    """A vehicle that is 6 % slow with headings within ±10°, or a current that happens to run along its course.

    The data tell them apart by less than a nat; that a current of any direction runs along the course to a twentieth
    of its usual size is as improbable as that.
    """
    table = legs(48, seed=seed, error=slow(-0.06), about=(1.0, np.radians(10.0)))
    found = diagnose(transit_mission, folder(KIND, table), plan=False)
    assert found.causes == ("speed-scale",)
    evidence = {entry.causes: entry.log_bayes_factor for entry in found.ranking}
    assert evidence["speed-scale",] - evidence["mean-current",] < 5.0
    assert "100.0 %" not in words_of(found)


@pytest.fixture(scope="module")
def all_round(tmp_path_factory, causes):
    """The diagnosis of a vehicle that is 6 % slow with headings all round."""
    place = tmp_path_factory.mktemp("legs")
    (place / "dataset.yaml").write_text(yaml.safe_dump({"file": "rows.csv", **KIND}))
    make_legs(48, error=slow(-0.06)).to_csv(place / "rows.csv", index=False)
    with causes():
        return diagnose(Mission.from_data(TRANSIT), place, plan=False)


@pytest.fixture(scope="module")
def words(all_round):
    """Those of its report."""
    return words_of(all_round)


def test_headings_all_round_separate_them(all_round, words):
    found = all_round
    assert (found.verdict, found.causes) == ("explained", ("speed-scale",))
    assert found.credible_set == (("speed-scale",),)
    assert found.not_constant == ()
    assert "100.0 %" not in words
    assert "measured mile" in answer(found)  # its speed is logged
    assert "made without a logged speed" not in answer(found)


@pytest.mark.slow
def test_a_cause_that_changes_within_the_record_is_not_constant(folder, transit_mission, legs):
    """A compass that is 2° off and 10° off, by turns of five legs."""
    table = legs(40, error=turned(lambda t: np.radians(np.where(np.arange(len(t)) // 5 % 2 < 1, 2.0, 10.0))))
    found = diagnose(transit_mission, folder(KIND, table), plan=False)
    assert "compass-bias" in found.not_constant
    assert found.verdict == "partly-explained"
    assert found.diagnosis()["not_constant"] == list(found.not_constant)
    assert "is not constant over the record" in words_of(found)


@pytest.mark.slow
def test_a_compass_that_jumps_is_told_so(folder, transit_mission, legs):
    """Three degrees off in the first half and eight in the second: an offset, and a jump when it happened."""
    table = legs(80, error=turned(lambda t: np.radians(np.where(t < 32000.0, 3.0, 8.0))))
    found = diagnose(transit_mission, folder(KIND, table), plan=False)
    assert found.causes == ("compass-bias", "compass-jump")
    sizes = {(each.effect, each.name): each for each in found.best.parameters}
    jump, moment = sizes["compass-jump", "angle"], sizes["compass-jump", "moment"]
    assert jump.low < np.radians(5.0) < jump.high
    assert abs(moment.value - 32000.0) < 3000.0
    assert "the compass jumped" in words_of(found).lower()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_constant_cause_is_constant(seed, folder, transit_mission, legs):
    table = legs(60, seed=seed, error=turned(lambda t: np.radians(4.0)))
    found = diagnose(transit_mission, folder(KIND, table), plan=False)
    assert found.causes == ("compass-bias",)
    assert found.not_constant == ()


def test_a_cause_that_is_not_constant_is_said(all_round, words):
    assert "is not constant over the record" not in words
    changing = replace(all_round, not_constant=("speed-scale",))
    assert "is not constant over the record" in words_of(changing)
    assert changing.diagnosis()["not_constant"] == ["speed-scale"]


def test_intervals_that_are_too_narrow_are_said(all_round, words):
    found = all_round
    assert not found.coverage.is_off
    assert found.diagnosis()["coverage_scale"] == 1.0
    assert "intervals are too" not in words
    narrow = replace(found, coverage=Coverage(85, 120, 1.6, 107))
    assert "Its 90 % intervals are too narrow: they hold 71 % of what was held out." in answer(narrow)
    assert "With random errors 1.60 times as large, as in the extended mission, they hold 89 %" in words_of(narrow)
    assert narrow.diagnosis()["coverage_scale"] == 1.6


def test_random_errors_are_scaled_and_nothing_else(folder, transit_mission, legs):
    def error(t, heading):
        return drifting(0.15, 7200.0)(t, heading) + slow(-0.08)(t, heading)

    data = folder(KIND, legs(80, error=error))
    model = transit_model(read_transit(data, transit_mission), transit_mission, seed=1)
    fit = model.fit(("speed-scale", "persistent-error"))
    wide = widened(fit, 1.5)
    before, after = (each.posterior.drawn(200, np.random.default_rng(1)) for each in (fit, wide))
    assert wide.calibration["sigma_v_m_s"] == pytest.approx(1.5 * fit.calibration["sigma_v_m_s"])
    assert wide.calibration["fix_sd_m"] == fit.calibration["fix_sd_m"]
    sigma = ("persistent-error", "sigma")
    assert after[sigma] == pytest.approx(1.5 * before[sigma])
    for key in (("speed-scale", "fraction"), ("persistent-error", "time")):
        assert after[key] == pytest.approx(before[key])
