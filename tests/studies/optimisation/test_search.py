"""The search on made-up surfaces whose best choice is known, without a mission behind them."""

from types import SimpleNamespace

import numpy as np
import pytest

from missionplan.results.decision import Axis
from missionplan.studies.optimisation import Lattice
from missionplan.studies.optimisation.evaluations import Demand, Evaluation, Evaluations, demands_of, is_feasible
from missionplan.studies.optimisation.optimise import _Problem
from missionplan.studies.optimisation.search import COARSE, FINE, Search

MARGIN = Demand("ok", "ok", None, float("nan"), 0.95)


def _bowl(x):
    return 30.0 + 20.0 * np.sum((x - 0.37) ** 2)


def _valley(x):
    return 30.0 + 40.0 * (x[1] - 0.2 - 0.6 * x[0] ** 2) ** 2 + 2.0 * (x[0] - 0.7) ** 2


def _two_holes(x):
    """Flat ground with two narrow holes, the deeper one far from the other."""
    return 32.0 - 6.0 * np.exp(-np.sum((x - 0.2) ** 2) / 0.02) - 7.0 * np.exp(-np.sum((x - 0.8) ** 2) / 0.02)


class Surface(Evaluations):
    """Trials drawn about a surface, on common random numbers and with a noise of each choice's own."""

    def __init__(self, cost, keys, size):
        axis = (tuple(range(size)), tuple(map(str, range(size))), tuple(map(float, range(size))))
        lattice = Lattice(tuple(Axis((f"key{number}",), *axis) for number in range(keys)))
        super().__init__(None, lattice, None, 1)
        rng = np.random.default_rng(7)
        self.cost, self.common, self.normals = cost, rng.normal(size=(2, FINE)), rng.normal(size=FINE)

    def choice(self, point):
        x = np.array(point) / (np.array(self.lattice.shape) - 1.0)
        own = np.random.default_rng(self.lattice.number(point)).normal(size=FINE)
        energy = self.cost(x) + 3.0 * self.common[0] + 2.0 * x[0] * self.common[1] + 0.6 * own
        inside = 6.0 * (x.sum() - 0.5 * len(x) + 0.1)
        return {"total.energy_wh": energy, "ok": self.normals + 0.2 * own < 1.645 + inside}

    def of(self, points, trials):
        for point in dict.fromkeys(points):
            if (point, trials) not in self.kept:
                columns = {name: values[:trials] for name, values in self.choice(point).items()}
                self.kept[point, trials] = Evaluation(point, columns)
                self.spent += trials
        return [self.kept[point, trials] for point in points]


@pytest.mark.parametrize(
    ("cost", "keys", "size", "demands"),
    [
        (_bowl, 2, 21, (MARGIN,)),
        (_valley, 2, 21, ()),
        (_two_holes, 2, 21, ()),
        (_two_holes, 3, 15, (MARGIN,)),
    ],
)
@pytest.mark.parametrize("seed", [11, pytest.param(12, marks=pytest.mark.slow)])
def test_the_best_is_found_with_a_few_of_the_grids_trials(cost, keys, size, demands, seed):
    surface = Surface(cost, keys, size)
    search = Search(surface, demands, "energy", seed)
    search.widely()
    found = search.closely()[0]
    every = [Evaluation(point, surface.choice(point)) for point in np.ndindex(surface.lattice.shape)]
    best = min(each.cost("energy") for each in every if is_feasible(demands, each))
    assert is_feasible(demands, found)
    assert found.cost("energy") <= 1.01 * best
    assert surface.spent <= 0.05 * len(surface.lattice) * FINE


def test_a_point_is_known_by_its_most_trials_in_whichever_order_they_came():
    for sizes in ((64, 256), (256, 64)):
        found = Surface(_bowl, 1, 3)
        found.kept.update({((1,), n): Evaluation((1,), {"ok": np.ones(n)}) for n in sizes})
        assert [each.trials for each in found.best_known()] == [256]


@pytest.mark.parametrize(("side", "would_do", "relaxed"), [("at_most", 96.0, 20.2), ("at_least", 5.0, 19.8)])
def test_a_bound_that_would_do_is_met_by_so_many_of_a_hundred_that_nine_in_ten_are_certain(side, would_do, relaxed):
    """90 + 1.96·3 of 100 are more than nine in ten, 96 therefore, of the numbers 1 to 100."""
    demand = Demand("x", "x", side, 20.0, 0.9)
    values = np.random.default_rng(1).permutation(np.arange(1.0, 101.0))
    assert demand.would_do(Evaluation((0,), {"x": values})) == would_do
    assert demand.relaxed().limit == pytest.approx(relaxed)


def test_the_limit_of_an_energy_is_in_watt_hours_as_the_trials_are():
    def required(name, most):
        return SimpleNamespace(quantity=f"total.{name}", at_most=most, at_least=None, probability=0.9)

    mission = SimpleNamespace(phases=(), requirements=[required("energy", 7200.0), required("duration", 120.0)])
    found = [(each.column, each.side, each.limit) for each in demands_of(mission)]
    assert found == [("total.energy_wh", "at_most", 2.0), ("total.duration_s", "at_most", 120.0)]


def test_costs_of_few_trials_are_moved_by_what_more_trials_changed_of_others():
    """Of two choices with both the mean rose by 2 and by 4, of a third by no number."""
    search = Search(Surface(_bowl, 1, 5), (), "energy", 1)
    for point, coarse, fine in ((0, 10.0, 12.0), (1, 20.0, 24.0), (2, np.nan, 30.0), (3, 40.0, None)):
        for trials, cost in ((COARSE, coarse), (FINE, fine)):
            if cost is not None:
                search.evaluations.kept[(point,), trials] = Evaluation(
                    (point,), {"total.energy_wh": np.full(trials, cost)}
                )
    known = search.evaluations.best_known()
    assert [each.trials for each in known] == [FINE, FINE, FINE, COARSE]
    np.testing.assert_allclose(search._with_common_noise(known), [12.0, 24.0, 30.0, 40.0 + 3.0])


def known(number, energies, met):
    """Trials of a choice, that succeed where they meet what is demanded."""
    met, energies = np.array(met), np.array(energies, dtype=float)
    columns = {"ok": met, "total.success": met, "total.energy_wh": energies, "total.duration_s": energies}
    return Evaluation((number,), columns)


def problem(*evaluations):
    surface = Surface(_bowl, 1, 5)
    surface.kept.update({(each.point, each.trials): each for each in evaluations})
    return _Problem(surface, (MARGIN,), "energy", None)


def test_a_choice_that_does_what_is_demanded_is_no_obstacle():
    """As where it failed on fresh draws alone."""
    assert problem(known(0, [9.0] * 4, [True] * 4))._obstacles() == ()
    (found,) = problem(known(0, [9.0] * 4, [True, True, True, False]))._obstacles()
    assert (found.quantity, found.reached.value, found.alone) == ("ok", 0.75, True)


def test_choices_with_few_trials_are_not_on_the_front():
    tried = problem(known(0, [1.0] * 2, [True] * 2), known(1, [9.0] * 4, [True] * 4))._tried()
    assert [(each.energy, each.on_front) for each in tried] == [(1.0, False), (9.0, True)]


@pytest.mark.parametrize(("relaxed", "saved"), [([2.0, np.nan], 0.0), ([0.5, 5.0], 2.25)])
def test_a_relaxed_requirement_saves_what_pairs_of_trials_do_and_never_less_than_nothing(relaxed, saved):
    """Of energies of 1 and 9 W h: the trial that never ends is in no pair."""
    choice, other = known(0, [1.0, 9.0], [True, True]), known(1, relaxed, [True, True])
    search = SimpleNamespace(closely=lambda demands=None: [choice] if demands is None else [choice, other])
    (found,) = problem(choice, other)._relaxations(search, choice)
    assert (found.saved, list(found.values.values())) == (saved, ["1"])
