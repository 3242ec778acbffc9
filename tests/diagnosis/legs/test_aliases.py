"""Effects that do to a log what the claimed one does, and something else on the mission that is planned."""

from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from scipy.stats import multivariate_normal

from missionplan import diagnose
from missionplan.diagnosis.legs.fit_checks import (
    OFF,
    _displacement,
    _likest,
    _log_evidence,
    _matters_from,
    one_step,
    transit_misfit,
)
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
    assert transit_misfit(model) == (
        f"Over 32 legs in a row the errors add up to {960.0 / np.sqrt(32.0 * 44.0):.1f} times what the mission expects "
        "(0.96 km against 0.04 km); a leg errs by 30.0 cm/s rms."
    )


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
        assert getattr(found, name) == pytest.approx(np.sqrt(np.mean(squares))), name
    assert past == [(list(range(k)), [k]) for k in range(10, 24)]
    assert refits == [10, 15, 20]
    model.data.n = 19
    assert one_step(model, None) is None
