import numpy as np
import pytest

from missionplan.errors import InputError
from missionplan.montecarlo.distributions import Normal, Uniform
from missionplan.montecarlo.streams import BLOCK, Correlation, JointDistribution

QUANTITIES = {"a.speed": Normal(1.0, 0.1), "b.time": Uniform(0.0, 1.0), "c.depth": 4.0, "d.mass": Normal(0.0, 2.0)}


def draw(quantities, correlations, seed, block, **size):
    return JointDistribution.of(quantities, correlations).draw(seed, block, **size)


def test_distributions_are_drawn_and_constants_are_not():
    drawn = draw(QUANTITIES, (), seed=1, block=0, size=10)
    assert list(drawn) == ["a.speed", "b.time", "d.mass"]
    assert np.shape(drawn["a.speed"]) == (10,)


def test_adding_a_quantity_or_a_correlation_leaves_the_others_unchanged():
    before = draw(QUANTITIES, (), 1, 0)
    more = {"0.first": Normal(0.0, 1.0), **QUANTITIES, "e.last": Normal(0.0, 1.0)}
    after = draw(more, [Correlation(("e.last", "d.mass"), 0.7)], 1, 0)
    assert np.array_equal(after["a.speed"], before["a.speed"])
    assert np.array_equal(after["b.time"], before["b.time"])
    assert np.array_equal(after["d.mass"], before["d.mass"]), "the first of a pair keeps its draws"


def test_fewer_trials_are_the_first_of_more():
    whole, part = draw(QUANTITIES, (), 1, 2), draw(QUANTITIES, (), 1, 2, size=100)
    assert np.array_equal(whole["b.time"][:100], part["b.time"])


def test_correlations_come_out_as_asked():
    pairs = [Correlation(("a.speed", "b.time"), 0.6), Correlation(("b.time", "d.mass"), -0.5)]
    blocks = [draw(QUANTITIES, pairs, 3, block) for block in range(12)]
    speed, time, mass = (np.concatenate([b[name] for b in blocks]) for name in ("a.speed", "b.time", "d.mass"))
    assert np.corrcoef(speed, time)[0, 1] == pytest.approx(0.6 * np.sqrt(3.0 / np.pi), abs=0.02)
    assert np.corrcoef(speed, mass)[0, 1] == pytest.approx(0.0, abs=4 / np.sqrt(12 * BLOCK))
    assert speed.std() == pytest.approx(0.1, rel=0.02)


@pytest.mark.parametrize(
    ("pairs", "words"),
    [
        ([Correlation(("a.speed", "nowhere"), 0.1)], "no quantity is named 'nowhere'"),
        ([Correlation(("a.speed", "c.depth"), 0.1)], "fixed value"),
        ([Correlation(("a.speed", "a.speed"), 0.1)], "itself"),
        ([Correlation(("a.speed", "b.time"), 1.0)], "between -1 and 1"),
        ([Correlation(("a.speed", "b.time"), 0.1), Correlation(("b.time", "a.speed"), 0.2)], "twice"),
        (
            [
                Correlation(("a.speed", "b.time"), 0.9),
                Correlation(("b.time", "d.mass"), 0.9),
                Correlation(("a.speed", "d.mass"), -0.9),
            ],
            "no quantities can have these correlations together",
        ),
    ],
)
def test_impossible_correlations_are_refused(pairs, words):
    with pytest.raises(InputError, match=words):
        draw(QUANTITIES, pairs, 1, 0)
