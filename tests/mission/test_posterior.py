"""A mission that names draws: read and drawn from as they are, and refused when they are not its own."""

import zipfile
from dataclasses import replace

import numpy as np
import pytest
import yaml
from scipy.stats import norm

import missionplan
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.includes import SIGMA, hash_of
from missionplan.montecarlo.posterior import DamagedPosteriorError, PosteriorFile, WeightedDraws
from missionplan.montecarlo.streams import stream
from missionplan.scenario.scenario import Scenario

BASE = {
    "navigation": {"velocity_error": {"sigma": {"median": "0.04 m/s", "factor": 1.2}}, "surfacing_time": "10 min"},
    "phases": [
        {
            "transit": {
                "name": "ingress",
                "from": ["0 m", "0 m"],
                "to": ["4 km", "0 m"],
                "speed": "1.5 m/s",
                "d_max": "1 km",
                "arrival_radius": "100 m",
            }
        }
    ],
}
ANGLE, EAST, NORTH = ("compass-bias", "angle"), ("mean-current", "east"), ("mean-current", "north")


def draws(seed=4, counts=(300, 500, 200)):
    """Nothing, a compass, or a compass with a current: sizes that no written distribution has."""
    rng = np.random.default_rng(seed)
    n = sum(counts)
    which = np.repeat([0, 1, 2], counts)
    values = np.full((n, 4), np.nan)
    compass, both = which >= 1, which == 2
    values[compass, 0] = rng.choice([-1.0, 1.0], compass.sum()) * rng.uniform(0.02, 0.05, compass.sum())
    values[both, 1] = rng.normal(0.1, 0.02, both.sum())
    values[both, 2] = values[both, 1] ** 2 - 0.5 * values[both, 0]
    values[:, 3] = np.exp(rng.normal(np.log(0.04), 0.1, n) - 0.3 * which)
    weights = rng.uniform(0.5, 1.5, n)
    return WeightedDraws(
        ((), ("compass-bias",), ("compass-bias", "mean-current")),
        which,
        (ANGLE, EAST, NORTH, SIGMA),
        values,
        weights / weights.sum(),
    )


def file_of(found=None, learned_from=()):
    return PosteriorFile.of(found or draws(), hash_of(learned_from), {"compass-bias": {"probability": 0.7}})


def written(folder, content, **changes):
    (folder / "posterior.npz").write_bytes(content.content)
    section = dict(content) | changes
    (folder / "mission.yaml").write_text(yaml.safe_dump(BASE | {"posterior": section}))
    return folder / "mission.yaml"


def test_trials_draw_whole_rows_with_their_weights(tmp_path):
    own = file_of()
    mission = missionplan.load(written(tmp_path, own))
    found = [Scenario.at_means(mission).sampled(seed=3, block=b).draws for b in range(8)]
    which = np.concatenate([each["posterior"] for each in found])
    assert np.bincount(which.astype(int)) / len(which) == pytest.approx(own.draws.probabilities, abs=0.01)
    drawn = {n: np.concatenate([each[f"effects.{n}"] for each in found]) for n in
             ("compass-bias.angle", "mean-current.east", "mean-current.north")}  # fmt: skip
    both = which == 2
    table = {tuple(row[:3]) for row in own.draws.values[own.draws.which == 2]}
    rows = np.stack(list(drawn.values()), axis=1)[both]
    assert {tuple(row) for row in rows} <= table  # joint: every trial has a row as it is
    picked = own.draws.values[own.draws.which == 2, 1]
    share = own.draws.weights[own.draws.which == 2]
    assert drawn["mean-current.east"][both].mean() == pytest.approx(np.average(picked, weights=share), abs=0.001)


def test_a_size_that_was_measured_is_not_asked_about(tmp_path):
    """A compass up to 0.75 rad off: of draws a fact, as a number of somebody's own unusual."""
    found = draws()
    far = replace(found, values=found.values * [15.0, 1.0, 1.0, 1.0])
    path = written(tmp_path, file_of(far))
    assert missionplan.load(path).notices() == ()
    path.write_text(yaml.safe_dump(BASE | {"effects": [{"compass-bias": {"angle": "0.6 rad"}}]}))
    assert "is unusual" in missionplan.load(path).notices()[0]


def test_the_draw_of_a_trial_is_of_its_own_stream_and_of_no_other_choice(tmp_path):
    mission = missionplan.load(written(tmp_path, file_of()))
    ends = np.cumsum(draws().weights)
    expected = np.searchsorted(ends, norm.cdf(stream(7, "posterior", 2).standard_normal(4096)), side="right")
    found = Scenario.at_means(mission).sampled(seed=7, block=2, size=900).draws
    np.testing.assert_array_equal(found["posterior"], draws().which[expected[:900]])
    faster = mission.with_({"ingress.speed": "2 m/s", "trials": 50})
    np.testing.assert_array_equal(Scenario.at_means(faster).sampled(seed=7, block=2).draws["effects.compass-bias.angle"][:900],
                                  found["effects.compass-bias.angle"])  # fmt: skip


def test_effects_act_only_in_trials_whose_draw_has_them(tmp_path):
    drawn = Scenario.at_means(missionplan.load(written(tmp_path, file_of()))).sampled(seed=1, block=0)
    compass, current = drawn.transit_effects
    which = drawn.draws["posterior"]
    assert np.all((compass.angle != 0.0) == (which >= 1))
    assert np.all((current.east != 0.0) == (which == 2))


def test_the_noise_keeps_the_missions_law_and_the_ranks_of_the_draws(tmp_path):
    drawn = Scenario.at_means(missionplan.load(written(tmp_path, file_of()))).sampled(seed=1, block=0)
    sigma, which = drawn.draws["navigation.velocity_error.sigma"], drawn.draws["posterior"]
    assert np.median(sigma) == pytest.approx(0.04, rel=0.02)
    assert np.std(np.log(sigma)) == pytest.approx(np.log(1.2), rel=0.05)
    assert np.median(sigma[which == 2]) < np.median(sigma[which == 0])


def test_what_a_person_states_of_an_effect_goes_before_the_draws(tmp_path):
    mission = missionplan.load(written(tmp_path, file_of()))
    stated = mission.with_({"effects": [{"compass-bias": {"angle": "3 deg"}}]})
    compass, current = Scenario.at_means(stated).sampled(seed=1, block=0).transit_effects
    assert np.all(compass.angle == pytest.approx(np.radians(3.0)))
    assert np.any(current.east != 0.0)


def test_a_mission_is_written_with_its_draws_beside_it(tmp_path):
    mission = missionplan.load(written(tmp_path, file_of()))
    other = tmp_path / "elsewhere"
    other.mkdir()
    again = missionplan.load(mission.save(other / "plan.yaml"))
    assert (other / "posterior.npz").read_bytes() == (tmp_path / "posterior.npz").read_bytes()
    assert again.identified() == mission.identified()
    (other / "posterior.npz").write_bytes(b"another mission's")
    with pytest.raises(InputError, match="is there already"):
        mission.save(other / "second.yaml")


def test_identity_has_the_hash_of_the_draws(tmp_path):
    one = Mission.from_data(BASE | {"posterior": file_of()}).identified()
    two = Mission.from_data(BASE | {"posterior": file_of(draws(seed=5))}).identified()
    assert one != two


def refusal(path):
    with pytest.raises(InputError) as caught:
        missionplan.load(path)
    return str(caught.value)


def test_draws_that_are_not_the_missions_are_refused(tmp_path):
    assert "another mission's" in refusal(written(tmp_path, file_of(), sha256=file_of(draws(seed=5))["sha256"]))
    assert "learned_from" in refusal(written(tmp_path, file_of(learned_from=["0123456789abcdef"])))
    assert "for reading alone" in refusal(written(tmp_path, file_of(), summary={"compass-bias": {"probability": 0.9}}))
    assert "no such file" in refusal(written(tmp_path, file_of(), file="posterior.npy"))
    assert "unknown key" in refusal(written(tmp_path, file_of(), shape=3))
    path = written(tmp_path, file_of())
    (tmp_path / "posterior.npz").write_bytes(file_of().content[:-40])
    assert "damaged" in refusal(path)


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [(0, 9.0, "out of its range"), (0, np.inf, "no numbers"), (3, -0.1, "out of its range")],
)
def test_values_out_of_bounds_are_refused(tmp_path, column, value, words):
    own = draws()
    own.values[-1, column] = value
    with pytest.raises((InputError, DamagedPosteriorError), match=words):
        missionplan.load(written(tmp_path, file_of(own)))


def test_no_bytes_but_those_of_a_posterior_are_read(tmp_path):
    bomb = tmp_path / "bomb.npz"
    with zipfile.ZipFile(file_of().content and bomb, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("values.npy", b"\0" * 100_000_000)
    objects = tmp_path / "objects.npz"
    np.savez(objects, **{name: np.array([{}], dtype=object) for name in ("format", "effects", "sets", "which", "columns",
                                                                         "values", "weights", "learned_from", "summary")})  # fmt: skip
    for content in (b"", b"PK\3\4", bomb.read_bytes(), objects.read_bytes(), file_of().content[50:]):
        with pytest.raises(DamagedPosteriorError):
            PosteriorFile(content)


def test_the_same_draws_give_the_same_bytes():
    assert file_of().content == file_of().content
