"""Effects that do to a log what the claimed one does, and something else on the mission that is planned."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from scipy.stats import multivariate_normal

from missionplan import diagnose
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.legs.designs import designs_for, short_trials, with_further_legs
from missionplan.diagnosis.legs.fit_checks import (
    OFF,
    _displacement,
    _likest,
    _log_evidence,
    _matters_from,
    one_step,
)
from missionplan.diagnosis.legs.kind import DRAWS, TransitKind, _expected_velocity
from missionplan.mission import load
from missionplan.report.render import render_report
from tests.fixtures import TRANSIT

CAUSES = ("compass-bias", "mean-current")
KIND = {"kind": "transit", "name": "legs", "noise": {"fix": "3 m"}}


def turned(t, heading):
    """Six degrees to starboard at 1.2 m/s."""
    actual = heading + np.radians(6.0)
    return 1.2 * np.stack([np.sin(actual) - np.sin(heading), np.cos(actual) - np.cos(heading)])


@pytest.fixture
def planned_at(tmp_path):
    def make(speed):
        (transit,) = (phase["transit"] for phase in TRANSIT["phases"])
        path = tmp_path / f"{speed}.yaml"
        path.write_text(yaml.safe_dump({**TRANSIT, "phases": [{"transit": {**transit, "speed": f"{speed} m/s"}}]}))
        return load(path)

    return make


@pytest.mark.usefixtures("among_few")
def test_what_legs_of_one_speed_cannot_tell_apart_matters_where_another_speed_is_planned(planned_at, folder, legs):
    """A sideslip falls as the square of the speed, a compass errs as much at any speed."""
    faster = diagnose(planned_at(2.4), folder(KIND, legs(24, sigma=0.02, error=turned)), plan=False)
    assert faster.causes == ("compass-bias",)
    (sideslip,) = (alias for alias in faster.readings.aliases if alias.other == "sideslip")
    assert sideslip.claimed == "compass-bias"
    assert "of the speed" in sideslip.trial
    assert 1 <= int(sideslip.trial.split()[0]) <= 12
    # three quarters of 6° of 2.4 m/s are far more than the errors of a leg
    assert sideslip.matters_from == pytest.approx(2.4 * np.mean(legs(24).eval("t_end_s - t_start_s")), rel=0.01)
    assert "Does the same on these legs" in render_report(faster).html


@pytest.mark.usefixtures("among_few")
def test_it_does_not_matter_where_the_speed_of_the_legs_is_planned(planned_at, folder, legs):
    as_sailed = diagnose(planned_at(1.2), folder(KIND, legs(24, sigma=0.02, error=turned)), plan=False)
    assert as_sailed.causes == ("compass-bias",)
    assert "sideslip" not in {alias.other for alias in as_sailed.readings.aliases}


def test_signals_are_told_apart_by_nats_of_what_no_other_column_does():
    """Two legs: 2 m/s less what the column takes leaves what is at right angles to it, in standard deviations."""
    column, noise = np.array([[[1.0], [1.0]], [[0.0], [0.0]]]), np.full((2, 2), 0.5)
    alike, nats = _likest(np.array([[2.0, 4.0], [0.0, 1.0]]), column, noise)
    assert (alike.tolist(), nats) == ([pytest.approx(3.0)], pytest.approx(0.5 * (1.0 + 1.0 + 1.0) / 0.5**2))


def test_effects_that_part_by_a_metre_a_leg_matter_when_errors_have_added_up_less():
    """A metre a leg of 100 s against 2 m on each axis: n is 2·√n·√8 after 32 legs, of 150 m."""
    model = SimpleNamespace(
        data=SimpleNamespace(under_way=np.full(3, 100.0)), leg=SimpleNamespace(speed=np.full(3, 1.5))
    )
    apart, noise = np.array([[0.01] * 3, [0.0] * 3]), np.full((2, 3), 0.02)
    assert _matters_from(model, apart, noise) == pytest.approx(32.0 * 150.0)
    assert _matters_from(model, 100.0 * apart, noise) == pytest.approx(150.0)  # one leg shows it
    assert _matters_from(model, 1e-4 * apart, noise) == np.inf


def test_an_unknown_displacement_has_the_evidence_and_the_mean_of_its_normal_law():
    rng = np.random.default_rng(3)
    root, columns, error = rng.normal(size=(4, 4)), rng.normal(size=(4, 2)), rng.normal(size=4)
    covariance = root @ root.T + np.eye(4)
    whole = covariance + columns @ columns.T
    expected = multivariate_normal.logpdf(error, cov=whole) - multivariate_normal.logpdf(error, cov=covariance)
    assert _log_evidence(error, covariance, columns) == pytest.approx(expected)
    assert _displacement(error, covariance, columns) == pytest.approx(OFF * columns.T @ np.linalg.solve(whole, error))


def test_errors_that_all_point_east_add_up_to_more_than_the_mission_expects():
    """Forty legs of 30 m too far: 32 in a row make 960 m, where 2 m of drift an axis and fixes of 3 m make √(32·44) m."""
    data = SimpleNamespace(n=40, under_way=np.full(40, 100.0))
    model = SimpleNamespace(
        data=data, axes=np.eye(2), y=np.tile([[0.3], [0.0]], 40), covariance=4e-4 * np.eye(2), fix_error=3.0
    )
    assert TransitKind.misfit(SimpleNamespace(model=model), None) == (
        f"Over 32 legs in a row the errors add up to {960.0 / np.sqrt(32.0 * 44.0):.1f} times what the mission expects "
        "(0.96 km against 0.04 km); a leg errs by 30.0 cm/s rms, 6.6 cm/s expected."
    )


def test_short_legs_count_by_how_far_they_err():
    """Of 0.3 m/s for 100 s and of 3 m/s for 1 s, each by turns, √((30² + 3²)/(100² + 1²)) is 0.301 m/s."""
    under_way = np.tile([100.0, 1.0], 20)
    data = SimpleNamespace(n=40, under_way=under_way)
    model = SimpleNamespace(
        data=data, axes=np.eye(2), y=np.stack([30.0 / under_way, 0.0 * under_way]), covariance=np.eye(2), fix_error=0.0
    )
    model.y[0, 1::2] = 3.0
    assert "a leg errs by 30.1 cm/s rms, 141.4 cm/s expected" in TransitKind.misfit(SimpleNamespace(model=model), None)
    weight = TransitData.weight.fget(SimpleNamespace(under_way=under_way))
    assert np.mean(weight**2) == pytest.approx(1.0)
    assert weight[0] / weight[1] == pytest.approx(100.0)


def test_the_next_leg_is_predicted_by_the_mean_so_far_the_last_leg_and_the_model():
    rng = np.random.default_rng(5)
    velocity, under_way, refits = rng.normal(size=(2, 24)), rng.uniform(50.0, 200.0, 24), []
    past = []

    def predicted(fit, legs, which):
        past.append((legs.tolist(), which.tolist()))
        return np.full((2, 1), 0.25), None

    model = SimpleNamespace(data=SimpleNamespace(n=24, velocity_error=velocity, under_way=under_way), y=velocity - 0.1,
                            refitted=lambda fit, legs: refits.append(len(legs)), predicted=predicted)  # fmt: skip
    found = one_step(model, None)
    errors = {"mean_so_far": [], "last_leg": [], "model": []}
    for k in range(10, 24):
        guesses = {"mean_so_far": velocity[:, :k].mean(axis=1), "last_leg": velocity[:, k - 1], "model": 0.1 + 0.25}
        for name, guess in guesses.items():
            errors[name].append(np.sum(((velocity[:, k] - guess) * under_way[k]) ** 2))
    for name, squares in errors.items():
        assert found[f"next_leg_{name}_rms_m"] == pytest.approx(np.sqrt(np.mean(squares))), name
    assert past == [(list(range(k)), [k]) for k in range(10, 24)]
    assert refits == [10, 15, 20]
    model.data.n = 19
    assert one_step(model, None) == {}


def a_log():
    """Three legs of 100, 200 and 300 s at 1, 1.2 and 1.6 m/s, to the east, north and east, at 10, 20 and 40 m."""
    under_way, surface = np.array([100.0, 200.0, 300.0]), np.array([30.0, 50.0, 40.0])
    path = np.array([[100.0, 0.0, 480.0], [0.0, 240.0, 0.0]])
    ends = np.cumsum(path, axis=1)
    return TransitData("a", "a", np.array(["1", "2", "3"]), np.array([0, 0, 1]), np.array([0.0, 200.0, 500.0]), under_way, surface,
                       ends - path, ends, ends, None, 3.0, True, (), None, np.array([1.0, 5.0, 2.0]), np.array([10.0, 20.0, 40.0]))  # fmt: skip


def test_further_legs_begin_where_and_when_the_last_one_ended():
    """At the median speed of 1.2 m/s, a minute after the surfacing, each of the median's 200 s and 40 s afloat."""
    data = a_log()
    trials = dict(short_trials(data))
    assert list(trials) == ["a quarter as long", "as usual", "at 0.7 of the speed", "half as deep", "six hours later"]
    turned = 2.0 * np.pi * 0.38 * np.arange(12)
    lasting = {"a quarter as long": 50.0}
    for words, found in trials.items():
        time, wait = lasting.get(words, 200.0), 21_600.0 if words == "six hours later" else 60.0
        new = slice(3, None)
        assert found.n == 15
        np.testing.assert_allclose(
            found.t_start[new], 500.0 + 300.0 + 40.0 + wait + (time + 40.0 + 60.0) * np.arange(12)
        )
        path = found.dead_reckoned[:, new] - found.start[:, new]
        speed = 1.2 * (0.7 if words == "at 0.7 of the speed" else 1.0)
        np.testing.assert_allclose(path, speed * time * np.stack([np.sin(turned), np.cos(turned)]), atol=1e-9)
        np.testing.assert_allclose(found.start[:, 3], [580.0, 240.0])
        np.testing.assert_allclose(found.start[:, 4:], found.dead_reckoned[:, 3:-1])
        assert found.depth[new].tolist() == [20.0 * (0.5 if words == "half as deep" else 1.0)] * 12
        assert (found.leg_fix_sd[new].tolist(), found.surface[new].tolist(), found.run[new].tolist()) == (
            [2.0] * 12,
            [40.0] * 12,
            [1] * 12,
        )


def test_further_records_go_back_all_round_there_and_back_and_on():
    data = a_log()
    back, every, short, late, twice = (with_further_legs(data, design) for design in range(5))

    def courses(found):
        return np.degrees(np.arctan2(*(found.dead_reckoned - found.start)[:, 3:])) % 360.0

    assert courses(back) == pytest.approx([270.0, 180.0, 270.0])  # the last one first
    assert courses(every) == pytest.approx(np.arange(20) * 0.38 * 360.0 % 360.0)
    for there_and_back in (short, late):
        assert np.cos(np.radians(courses(there_and_back))) == pytest.approx([1.0, -1.0] * 10)
    assert (short.under_way[3:].tolist(), late.surface[3:].tolist()) == ([50.0] * 20, [40.0, 940.0] * 10)
    assert courses(twice) == pytest.approx([90.0, 0.0, 90.0])
    assert (twice.under_way[3:].tolist(), twice.surface[3:].tolist()) == ([100.0, 200.0, 300.0], [30.0, 50.0, 40.0])
    assert designs_for(data) == (0, 1, 2, 3, 4)
    assert designs_for(replace(data, has_surface_time=False)) == (0, 1, 2, 4)


def test_what_legs_are_expected_to_err_by_is_the_current_below_and_that_at_the_surface_over_the_time_below():
    """Of 0.1 and 0.2 m/s below, and eastward at the surface by the leg's end as many 0.1 m/s as it is long in 100 s."""
    data = a_log()

    def afloat(t, depth, place):
        assert depth == 0.0
        np.testing.assert_array_equal(t, data.t_start + data.under_way)
        np.testing.assert_array_equal(place, data.end)
        return np.stack([1e-3 * data.under_way, np.zeros(3)])

    def below(t, lasting, depth, start, through):
        assert depth == 9.0
        np.testing.assert_array_equal(through, data.dead_reckoned - data.start)
        return np.array([[0.1], [0.2]]) + 0.0 * t

    spread = np.random.default_rng(1).normal(size=(2, DRAWS)) * [[0.05], [0.02]]
    means = SimpleNamespace(
        current=SimpleNamespace(velocity=afloat, mean_velocity=below), transit=lambda: SimpleNamespace(depth=9.0)
    )
    drawn = SimpleNamespace(current=SimpleNamespace(velocity=lambda t, depth, place: spread))
    under_way, whole, sd = _expected_velocity(data, means, drawn)
    np.testing.assert_allclose(under_way, [[0.1] * 3, [0.2] * 3])
    np.testing.assert_allclose(
        whole, [0.1 + 1e-3 * data.surface, [0.2] * 3]
    )  # 0.1 m/s of 30 s are 3 m, of 100 s 3 cm/s
    np.testing.assert_allclose(sd, spread.std(axis=1))
    still = _expected_velocity(data, SimpleNamespace(current=None), drawn)
    assert not any(np.any(each) for each in still)
