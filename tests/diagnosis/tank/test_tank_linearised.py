"""Groups of tank data predicted from the others: what they share and what they do not, by closed forms."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import yaml
from scipy.stats import multivariate_normal, norm

from missionplan.datasets.tank import DragSettings, OscillationSettings
from missionplan.diagnosis.diagnose import diagnose
from missionplan.diagnosis.tank.fitting import LinearData, fitted_root, marginal
from missionplan.diagnosis.tank.forward import drag_forward, noise_sd, row_blocks
from missionplan.diagnosis.tank.kind import TankKind, _uncertainty
from missionplan.diagnosis.tank.model import TankModel
from missionplan.mission import load
from missionplan.montecarlo.distributions import Normal
from missionplan.physics.tank import displacement, natural_frequency

GROUPS = np.repeat(["a", "b", "c"], 4)


def drawn(shared, seed=5):
    rng = np.random.default_rng(seed)
    y, columns, sd = rng.normal(0.0, 1.0, 12), rng.normal(0.0, 1.0, (12, 2)), rng.uniform(0.5, 1.0, 12)
    return LinearData(y, sd, columns, np.array([2.0, 0.7]), np.array(shared), GROUPS)


def joint(data, rows):
    """ln p of rows whose coordinates are all shared."""
    spread = data.columns * data.prior
    covariance = spread @ spread.T + np.diag(data.sd**2)
    return multivariate_normal.logpdf(data.y[rows], cov=covariance[np.ix_(rows, rows)])


def test_marginal_is_the_normal_density_of_the_data():
    data = drawn([True, True])
    found = marginal(data.y, data.columns, data.prior, data.sd)
    assert found.log_density == pytest.approx(joint(data, np.arange(12)))
    precision = np.diag(data.prior**-2.0) + data.columns.T / data.sd**2 @ data.columns
    assert found.covariance == pytest.approx(np.linalg.inv(precision))
    assert precision @ found.mean == pytest.approx(data.columns.T @ (data.y / data.sd**2))


def test_without_coordinates_the_data_are_independent_and_nothing_is_printed(capfd):
    data = drawn([True, True])
    found = marginal(data.y, data.columns[:, :0], data.prior[:0], data.sd)
    assert found.log_density == pytest.approx(norm.logpdf(data.y, scale=data.sd).sum())
    assert (found.mean.shape, found.covariance.shape) == ((0,), (0, 0))
    assert capfd.readouterr() == ("", "")  # LAPACK writes of an empty matrix by itself


def test_shared_coordinates_follow_the_chain_rule():
    data = drawn([True, True])
    for group in data.predicted():
        expected = joint(data, np.arange(12)) - joint(data, np.flatnonzero(~group.rows))
        assert group.log_score == pytest.approx(expected)


def test_random_effects_are_not_estimated_from_other_groups():
    data = drawn([False, False])
    for group in data.predicted():
        assert group.log_score == pytest.approx(joint(data, np.flatnonzero(group.rows)))
        assert group.estimated.shape == (0,)


def test_a_random_effect_of_each_group_widens_the_estimate_of_a_constant():
    """Groups of a constant each with a random effect of its own: the mean, weighted by 1/(τ² + σ²/n)."""
    level, effect_sd, sd = np.ones((12, 1)), 0.8, 0.3
    y = np.repeat([1.0, 2.0, 4.0], 4)
    columns, prior = np.hstack([level, level]), np.array([1e4, effect_sd])
    data = LinearData(y, np.full(12, sd), columns, prior, np.array([True, False]), GROUPS)
    last = data.predicted()[2]
    assert last.estimated == pytest.approx([1.5], rel=1e-6)
    variance = (effect_sd**2 + sd**2 / 4) / 2
    covariance = (effect_sd**2 + variance) * np.ones((4, 4)) + sd**2 * np.eye(4)
    assert last.log_score == pytest.approx(multivariate_normal.logpdf(np.full(4, 2.5), cov=covariance), rel=1e-5)


def gain(size):
    """Of a cause that shifts every datum, over its narrow spike: eight groups of five, noise of 1."""
    groups = np.repeat([f"g{k}" for k in range(8)], 5)
    y = size + np.random.default_rng(2).normal(0.0, 1.0, 40)
    base, cause = (
        LinearData(y, np.ones(40), np.ones((40, 1)), np.array([prior]), np.array([shared]), groups).predicted()
        for prior, shared in ((0.05, False), (5.0, True))
    )
    return sum(b.log_score - a.log_score for a, b in zip(base, cause, strict=True))


def test_a_cause_gains_where_its_spike_was_too_narrow_and_not_elsewhere():
    assert gain(0.0) < 0.0 < gain(1.0)


def test_what_one_group_alone_shows_is_no_gain():
    assert gain(np.where(np.arange(40) < 5, 5.0, 0.0)) < 0.0


@pytest.mark.parametrize(("heavier", "expected"), [(0.16, ("added-mass",)), (0.03, ())])
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_mass_beyond_its_spike_is_named_whatever_the_noise(heavier, expected, seed, tmp_path):
    """The record fixes the mass to 0.1 %, under its spike as well as as a cause: the Bayes factor alone must separate them."""
    time = np.arange(0.0, 2.5, 0.05)
    swing = displacement(time, 0.06, 0.0, natural_frequency(4000.0, 20.0 * (1.0 + heavier)), 0.2, 0.0)
    record = swing + np.random.default_rng(seed).normal(0.0, 0.001, len(time))
    table = np.stack([time, record], axis=1)
    np.savetxt(tmp_path / "swing.csv", table, delimiter=",", header="t_s,displacement_m", comments="")
    settings = {"kind": "free-oscillation", "file": "swing.csv", "stiffness": "4000 N/m", "mass": "20 kg"}
    (tmp_path / "dataset.yaml").write_text(yaml.safe_dump(settings))
    phase = {"from": ["0 m", "0 m"], "to": ["1 km", "0 m"], "speed": "1 m/s", "d_max": "1 km", "arrival_radius": "50 m"}
    mission = {"navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "60 s"}}
    (tmp_path / "mission.yaml").write_text(yaml.safe_dump(mission | {"phases": [{"transit": phase}]}))
    found = diagnose(load(tmp_path / "mission.yaml"), tmp_path, plan=False)
    assert found.causes == expected
    assert found.verdict == ("explained" if expected else "adequate")


def test_rows_blocks_and_misfits_of_tank_data_by_hand():
    assert row_blocks(3).tolist() == ["row 1", "row 2", "row 3"]
    assert row_blocks(12)[-1] == "row 12"
    twenty = row_blocks(20)  # eight blocks of two and a half
    assert list(dict.fromkeys(twenty.tolist()))[:3] == ["rows 1 to 2", "rows 3 to 5", "rows 6 to 7"]
    assert (twenty[4], twenty[5], twenty[-1]) == ("rows 3 to 5", "rows 6 to 7", "rows 18 to 20")
    size = np.sqrt(12.5)
    for stated, sd in ((None, 0.03 * size), (0.5, 0.5), (0.0, 1e-8 * size)):
        found, is_stated = noise_sd(np.array([3.0, -4.0]), stated)
        assert (found.tolist(), is_stated) == ([pytest.approx(sd)] * 2, stated is not None)
    table = pd.DataFrame({"residual_base": [3.0, 4.0]})
    forward = SimpleNamespace(y=np.array([30.0, 40.0]), sd=np.array([0.5, 0.5]), stated=True, quantity="force_n")
    words = TankKind.misfit(SimpleNamespace(model=SimpleNamespace(forward=forward)), table)
    assert words.endswith("misses the drag by 3.54 N rms, 10.0 % of it, 7.1 times the stated noise.")
    fits = [SimpleNamespace(state=SimpleNamespace(residuals=np.array(left))) for left in ([0.0, 3.0], [6.0, 0.0])]
    assert TankKind.shares_explained(None, None, fits, table) == [pytest.approx(1.0 - 9.0 / 25.0), 0.0]


def test_what_a_vehicle_file_is_unsure_of_is_unsure_in_the_tank_by_as_much_of_it():
    """A coefficient of 0.3 give or take 0.06; 16 kg of water give or take 2, of 96 that swing at full size."""
    drag = SimpleNamespace(coefficient=Normal(0.3, 0.06), exponent=Normal(-0.1, 0.02))
    vehicle = SimpleNamespace(drag=drag, added_mass=SimpleNamespace(surge=Normal(16.0, 2.0)))
    settings = {
        "drag": DragSettings.model_construct(),
        "swing": OscillationSettings.model_construct(mass=10.0, scale=2.0),
    }
    cases = (("drag.coefficient", "drag", 0.2), ("drag.exponent", "drag", 0.02), ("added_mass.surge", "swing", 2.0 / 96.0),
             ("added_mass.surge", "drag", 0.0))  # fmt: skip
    for key, kind, expected in cases:
        assert _uncertainty(key, SimpleNamespace(settings=settings[kind]), vehicle) == pytest.approx(expected)


def test_a_design_at_other_speeds_expects_the_coefficient_of_the_runs_so_far():
    """½ρA C_D U² with C_D = 0.8, each number by hand; Reynolds numbers over that of the middle speed, to two figures."""
    speed = np.array([0.5, 1.0, 2.0])
    data = SimpleNamespace(
        columns={"speed_m_s": speed, "force_n": 0.5 * 1000.0 * 0.1 * 0.8 * speed**2}, density=1000.0, viscosity=1e-6
    )
    noise = SimpleNamespace(force=0.2)
    settings = DragSettings.model_construct(reference_area=0.1, reference_length=0.32, scale=1.0, noise=noise)
    for factor in (1.0, 2.0):
        found = drag_forward(data, settings, None, factor)
        (constant,) = found.nuisances
        assert (constant.centre, constant.sd) == pytest.approx((0.8, 0.8))
        expected = 0.5 * 1000.0 * 0.1 * 0.8 * (factor * speed) ** 2
        assert found.predict(np.array([[0.8]]), ())[:, 0] == pytest.approx(expected)
        assert found.predict.args[1] == pytest.approx(factor * speed * 0.32e6 / 3.2e5)
        assert (found.sd.tolist(), found.stated) == ([0.2] * 3, True)


def test_what_is_fitted_has_the_covariance_of_the_columns_and_of_their_posterior():
    data = drawn([True, True])
    found, root = marginal(data.y, data.columns, data.prior, data.sd), fitted_root(data.columns, data.prior, data.sd)
    np.testing.assert_allclose(root @ root.T, data.columns @ found.covariance @ data.columns.T, atol=1e-12)


def test_rows_of_tank_data_lie_beside_both_models():
    forward = SimpleNamespace(
        y=np.array([3.0, 5.0]), axes={"speed": np.array([1.0, 2.0])}, groups=["a", "b"], quantity="force_n"
    )
    model = SimpleNamespace(forward=forward, plain_residuals=lambda: np.array([0.5, 1.0]))
    for causes, left in ((("drag-bias",), [0.1, -0.2]), ((), [0.5, 1.0])):
        best = SimpleNamespace(causes=causes, state=SimpleNamespace(residuals=np.array([0.1, -0.2])))
        found = TankKind("drag", None, None, model).residual_table(None, best)
        assert (found["at_speed"].tolist(), found["force_n"].tolist(), found["base"].tolist()) == (
            [1.0, 2.0],
            [3.0, 5.0],
            [2.5, 4.0],
        )
        assert found["residual_extended"].tolist() == left
        assert found["extended"].tolist() == pytest.approx((np.array([3.0, 5.0]) - left).tolist())


def test_what_a_linear_model_predicts_does_not_hang_on_where_it_was_linearised():
    rng = np.random.default_rng(3)
    columns, centre = rng.normal(size=(9, 1)), np.array([0.3])
    y = 1.2 * columns[:, 0] + 0.1 * rng.normal(size=9)
    model = SimpleNamespace(
        forward=SimpleNamespace(y=y, sd=np.full(9, 0.1), groups=np.repeat(["a", "b", "c"], 3)),
        fixed=0,
        is_of=lambda *_: True,
        prior=lambda _: SimpleNamespace(centre=centre),
        predict=lambda _, settings: columns @ settings,
    )

    def scores(at):
        state = SimpleNamespace(
            **{"active": np.array([0]), "at": np.array([at]), "residuals": y - columns[:, 0] * at, "columns": columns},
            **{"prior_sd": np.array([0.5]), "factor": 1.0},
        )
        return [
            (score.log_score, score.squared_error)
            for score in TankModel._scores(model, SimpleNamespace(causes=(), state=state))
        ]

    assert scores(1.1) == [pytest.approx(each) for each in scores(0.3)]
