"""Numbers of cells, ranges, best and front by hand; blocks joined in their order; what a chosen requirement rules out."""

import math
from dataclasses import replace
from datetime import UTC, datetime
from types import SimpleNamespace

import numpy as np
import pytest

from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.montecarlo.statistics import Probability, wilson
from missionplan.results.decision import (
    Assumption,
    Axis,
    CheckedRange,
    differ,
    label,
)
from missionplan.results.optimisation import Optimised, RuledOut, Tried
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.exploration import _times, cells, explore, first_start, steps
from missionplan.studies.exploration.cells import CellTrials, MissionTask, _joined, _numbered
from missionplan.studies.exploration.explore import _last, _misses, _to_run_after_all
from missionplan.studies.exploration.result import (
    NOT_RUN,
    Cell,
    Exploration,
    Window,
    cell_of,
    find_best,
    statistic_of,
)

NAN = math.nan
SPEED = Axis(
    ("out.speed",), tuple(f"{k} m/s" for k in range(1, 7)), tuple("123456"), tuple(map(float, range(1, 7))), "m/s"
)
MISSION = Mission.from_data(
    {
        "navigation": {"velocity_error": {"sigma": "0.02 m/s"}, "surfacing_time": "60 s"},
        "phases": [{"transit": {"name": "out", "from": ["0 m", "0 m"], "to": ["1 km", "0 m"], "speed": "1 m/s", "d_max": "300 m", "arrival_radius": "50 m"}}],
        "requirements": [
            {"quantity": "out.arrived", "probability": 0.6},
            {"quantity": "total.duration", "at_most": "20 min", "probability": 0.5},
        ],
    }
)  # fmt: skip


def required(met, undecided):
    return RequirementOutcome("out.arrived", None, None, "", 0.9, Probability(0.9, 0.8, 1.0), met, undecided)


def cell(index, *requirements, **given):
    return Cell((index,), requirements=tuple(required(*each) for each in requirements), **given)


def exploration(cells, axes=(SPEED,)):
    return Exploration(SimpleNamespace(), axes, tuple(cells), "success", 0, constrained=False)


def test_a_cell_s_status_is_its_worst_requirement_s():
    told = {
        "invalid": Cell((0,), "no"),
        "none": cell(0),
        "met": cell(0, (True, False), (True, False)),
        "undecided": cell(0, (True, False), (False, True)),
        "missed": cell(0, (False, True), (False, False)),
    }
    assert [each.status for each in told.values()] == list(told)
    assert [each.meets_all for each in told.values()] == [False, True, True, False, False]
    assert [_misses(each) for each in list(told.values())[1:]] == [False, False, False, True]
    assert cell(0, (True, True)).meets_all  # by the rule of simulate, undecided or not


def test_ranges_run_from_the_first_to_the_last_of_neighbours():
    met = [True, False, True, True, False, True]
    cells = [cell(k, (each, False), as_good=k in (0, 1, 4)) for k, each in enumerate(met)]
    found = exploration(cells)
    assert found.windows == (Window(0, 0), Window(2, 3), Window(5, 5))
    assert found.ranges_as_good == (Window(0, 1), Window(4, 4))
    assert found.exact_windows[1] == {"from": "3 m/s", "to": "4 m/s"}
    assert found.values_as_good == [{"out.speed": "1 m/s"}, {"out.speed": "2 m/s"}, {"out.speed": "5 m/s"}]
    assert found.any_meets_all
    assert not exploration([cell(k, (False, True)) for k in range(6)]).any_meets_all
    assert exploration([cell(k) for k in range(6)]).any_meets_all  # nothing is required
    assert exploration([cell(k) for k in range(6)]).windows == ()
    assert exploration([*cells[:5], cell(5, (True, False), dropped=True)]).windows == ()
    names = Axis(("vehicle",), tuple("abcdef"), tuple("abcdef"))
    assert exploration(cells, (names,)).windows == exploration(cells, (SPEED, SPEED)).windows == ()


def test_a_cell_counts_its_own_columns():
    n = 200
    rng = np.random.default_rng(1)
    success, arrived, in_time = (rng.random(n) < share for share in (0.7, 0.8, 0.3))
    energy = np.where(success, rng.normal(10.0, 2.0, n), NAN)
    columns = {
        "total.success": success,
        "requirement 0": arrived,
        "requirement 1": in_time,
        "out.arrived": arrived,
        "total.energy_wh": energy,
    }
    found = cell_of((3,), MISSION, columns, "")
    assert (found.place, found.trials, found.reason) == ((3,), n, "")
    assert found.success == wilson(int(success.sum()), n)
    assert found.events == {"out.arrived": wilson(int(arrived.sum()), n)}
    assert [item.probability for item in found.requirements] == [
        wilson(int(each.sum()), n) for each in (arrived, in_time)
    ]
    assert [item.met for item in found.requirements] == [True, False]
    (statistic,) = found.quantities.values()
    known = energy[success]
    assert (statistic.mean, statistic.sd) == pytest.approx((known.mean(), known.std(ddof=1)))
    assert (statistic.p05, statistic.p50, statistic.p95) == pytest.approx(tuple(np.quantile(known, (0.05, 0.5, 0.95))))
    assert statistic.standard_error == pytest.approx(known.std(ddof=1) / math.sqrt(known.size))
    assert (statistic.count, statistic.missing) == (known.size, n - known.size)
    row = exploration([found])._row(found)
    assert row["success_low"] < row["success"] < row["success_high"]
    assert (row["total.energy_wh p05"], row["total.energy_wh p95"]) == (statistic.p05, statistic.p95)
    assert (row["requirement 1"], row["requirement 2"]) == (arrived.mean(), in_time.mean())
    for left, words in ((2, ""), (3, "1.5 % of the trials leave the record of the current")):
        assert cell_of((0,), MISSION, {**columns, "left_record": np.arange(n) < left}, "").reason == words
    assert repr(cell_of((1,), MISSION, columns, "no water")) == repr(Cell((1,), "no water"))


def test_a_quantity_that_one_trial_or_none_has():
    one = statistic_of(np.array([NAN, 4.0]))
    assert (one.mean, one.p05, one.count, one.missing) == (4.0, 4.0, 1, 1)
    assert math.isnan(one.sd)
    assert math.isnan(one.standard_error)
    none = statistic_of(np.full(3, NAN))
    assert (none.count, none.missing) == (0, 3)
    assert math.isnan(none.mean)


def judged(aim, rows, requirements=True):
    """Cells of four trials: successes, energy, duration, and whether both requirements are met."""
    trials, cells = [], []
    for k, (success, energy, duration, meets) in enumerate(rows):
        columns = {
            "total.success": np.arange(4) < success,
            "total.energy_wh": np.full(4, energy) + 0.01 * np.arange(4),
            "total.duration_s": np.full(4, duration),
        }
        flags = {f"requirement {i}": np.full(4, meets) for i in range(2)}
        mission = MISSION if requirements else MISSION.model_copy(update={"requirements": ()})
        cells.append(cell_of((k,), mission, {**columns, **flags} if requirements else columns, ""))
        trials.append(columns)
    return find_best(cells, trials, aim)


ROWS = [(4, 9.0, 70.0, False), (3, 5.0, 60.0, True), (4, 8.0, 90.0, True), (4, 7.0, 80.0, True), (1, 1.0, 10.0, False)]


@pytest.mark.parametrize(
    ("aim", "best"),
    [("success", 3), ("energy", 1), ("duration", 1)],  # of those that succeed as often the one of less energy
)
def test_the_best_is_among_those_that_meet_all(aim, best):
    found = judged(aim, ROWS)
    assert (found.best, found.constrained) == (best, True)
    assert [math.isfinite(each.worse) for each in found.cells] == [row[3] for row in ROWS]
    index = {"success": 0, "energy": 1, "duration": 2}[aim]
    sign = -0.25 if aim == "success" else 1.0
    for each, row in zip(found.cells, ROWS, strict=True):
        if row[3]:
            assert each.worse == pytest.approx(sign * (row[index] - ROWS[best][index]))
    assert [each.on_front for each in found.cells] == [True, True, False, True, True]


@pytest.mark.parametrize("aim", ["success", "energy", "duration"])
def test_where_none_meets_all_it_is_the_one_that_succeeds_most_often(aim):
    found = judged(aim, [(*row[:3], False) for row in ROWS])
    assert (found.best, found.constrained) == (3, False)
    assert all(math.isfinite(each.worse) for each in found.cells)
    free = judged(aim, ROWS, requirements=False)  # nothing is required: what is asked for counts
    assert free.best == {"success": 3, "energy": 4, "duration": 4}[aim]


def test_without_energy_the_time_counts_and_what_never_ends_is_not_compared():
    rows = [(4, NAN, 70.0, True), (4, NAN, 60.0, True), (0, NAN, NAN, True)]
    assert judged("duration", rows).best == 1
    assert [each.on_front for each in judged("duration", rows).cells] == [False, True, False]
    assert judged("energy", rows).best is None


def test_of_cells_that_cost_the_same_the_surer_is_the_best_and_one_dropped_is_none():
    rows = [(3, 5.0, 60.0, True), (4, 5.0, 60.0, True)]
    assert [judged(aim, order).best for aim in ("energy", "duration") for order in (rows, rows[::-1])] == [1, 0, 1, 0]
    cheap, dear = judged("energy", [(4, 5.0, 60.0, True), (4, 9.0, 60.0, True)]).cells
    columns = {name: np.ones(4) for name in ("total.success", "total.energy_wh", "total.duration_s")}
    assert find_best([replace(cheap, dropped=True), dear], [columns] * 2, "energy").best == 1


def test_cells_that_were_dropped_for_one_that_fails_in_the_end_are_run_after_all():
    late = cell(0, (False, False), trials=100)
    waiting = [
        cell(1, (False, True), trials=25),
        cell(2, (True, False), trials=25),
        cell(3, (False, False), trials=25),
        Cell((4,), "no"),
    ]
    assert _to_run_after_all([late, *waiting], [0]) == [1, 2]
    assert _to_run_after_all([cell(0, (True, False), trials=100), *waiting], [0]) == []


def test_each_member_counts_the_trials_that_sail_in_it(monkeypatch):
    monkeypatch.setattr(explore, "members_of", lambda recorded: (("calm", 0.7), ("rough", 0.2), ("unmet", 0.1)))
    monkeypatch.setattr(explore, "members_drawn", lambda recorded, seed, trials: np.array([0, 0, 1, 0, 1]))
    task = SimpleNamespace(current=SimpleNamespace(current=None), seed=1)
    found = [CellTrials({"total.success": np.array(flags, dtype=float)}) for flags in ([0] * 5, [1, 1, 0, 1, 1])]
    members = explore._members(task, (SPEED,), found, 1, 5)
    assert [(each.name, each.probability, each.good.value) for each in members] == [
        ("calm", 0.7, 1.0),
        ("rough", 0.2, 0.5),
    ]


@pytest.mark.parametrize("is_binding", [True, False])
def test_trials_that_leave_the_record_count_where_it_binds(monkeypatch, is_binding):
    left, none = np.array([True, False, False]), np.zeros(3, dtype=bool)
    columns = {"out.arrived": ~left, "total.duration_s": np.array([600.0, 1199.0, 1201.0])}
    limits = [{"left_record": each} for each in (none, left)]
    run = SimpleNamespace(
        columns=lambda: columns, success=~left, phases=[SimpleNamespace(limits=each) for each in (*limits, {})]
    )
    monkeypatch.setattr(cells, "run_trials", lambda *_, **__: run)
    current = SimpleNamespace(is_binding=is_binding)
    means = SimpleNamespace(mission=MISSION, current=current, sampled_from=lambda *_: None)
    monkeypatch.setattr(MissionTask, "scenario", lambda *_: means)
    found = MissionTask([MISSION], [None], 1, ("total.duration_s",))((0, 0, 3)).columns
    assert found["total.success"].tolist() == [False, True, True]
    assert [flags.tolist() for name, flags in found.items() if name.startswith("requirement")] == [
        [False, True, True],
        [True, True, False],
    ]
    assert [found[name].tolist() for name in ("left_record",) if name in found] == (
        [left.tolist()] if is_binding else []
    )


def test_blocks_are_joined_in_their_order_and_numbered_apart():
    found = _joined([CellTrials({"a": np.array([1.0, 2.0])}), CellTrials({"a": np.array([3.0])})])
    assert found.columns["a"].tolist() == [1.0, 2.0, 3.0]
    assert _joined([CellTrials({"a": np.ones(1)}), CellTrials({}, "first"), CellTrials({}, "second")]).reason == "first"
    numbers = [_numbered((cell, block, 7))[0] for cell in range(3) for block in range(4)]
    assert len(set(numbers)) == 12
    assert _numbered((2, 3, 7))[1] == 7


def test_steps_reach_their_end_up_and_down():
    assert steps(1.0, 2.0, 0.25) == [1.0, 1.25, 1.5, 1.75, 2.0]
    assert steps(0.1, 0.3, 0.1) == pytest.approx([0.1, 0.2, 0.3])
    assert steps(2.0, 1.0, -0.4) == pytest.approx([2.0, 1.6, 1.2])
    assert steps(5.0, 5.0, 1.0) == [5.0]


def test_the_first_start_is_the_earliest_of_all_axes():
    moments = [datetime(2026, 6, day, tzinfo=UTC) for day in (3, 1, 2)]
    starts = Axis(("start",), ("c", "a", "b"), ("c", "a", "b"), tuple(each.timestamp() for each in moments), "UTC")
    assert first_start((SPEED, starts)) == moments[1]
    assert first_start((SPEED,)) is None
    assert starts.exact(0) == "2026-06-03T00:00:00+00:00"
    assert (starts.shown(0), SPEED.exact(2)) == ("c UTC", "3 m/s")


def test_starts_are_counted_from_the_mission_s_own_and_go_on():
    mission = MISSION.model_copy(update={"start": datetime(2026, 6, 1, 9, 30, tzinfo=UTC)})
    hours = [(each - mission.start.timestamp()) / 3600.0 for each in _times(mission, "1 h:4 h:90 min").numbers]
    assert hours == [1.0, 2.5, 4.0]
    with pytest.raises(InputError, match="the last time is before the first"):
        _times(mission, "12:00:04:00:10 min")


def test_what_turns_an_answer():
    def turns(worth, success, *missed):
        return Assumption("", "", worth, success, missed).turns

    assert turns(-0.1, 0.45)
    assert turns(-0.1, 0.95, "out.arrived")
    assert not turns(-0.09, 0.5)
    assert turns(-0.11, 0.8)  # failures that cost as much as the mission
    assert not turns(0.1, 0.45)  # it worked less often than not before
    assert not turns(-0.05, 0.4)


def test_members_and_explanations_differ_beyond_chance():
    def of(*spans):
        return [Probability(0.5 * (low + high), low, high) for low, high in spans]

    apart, alike = of((0.8, 0.9), (0.5, 0.79)), of((0.8, 0.9), (0.5, 0.81))
    assert [differ(spans) for spans in (apart, alike, [])] == [True, False, False]
    assert label(("compass-bias", "fix-error")) == "compass bias and fix error"
    assert label(()) == "none of them"


@pytest.mark.parametrize(
    ("least", "greatest", "inside"), [(2.0, 5.0, True), (1.0, 6.0, True), (0.9, 5.0, False), (2.0, 6.1, False)]
)
def test_what_was_checked_holds_all_of_a_mission_or_not(least, greatest, inside):
    assert CheckedRange("depth", 1.0, 6.0, "m", (), least, greatest).is_inside == inside


def tried(speed, energy, *slack, trials=900):
    return Tried({"out.speed": speed}, NOT_RUN, energy, 2000.0 - energy, {f"q {k + 1}": each for k, each in enumerate(slack)}, all(each >= 0.0 for each in slack), False, trials)  # fmt: skip


@pytest.mark.parametrize(
    ("others", "found"),
    [
        ([tried("b", 8.0, 0.1, -0.2)], ("q", 2.0, "b")),
        ([tried("b", 8.0, 0.1, -0.2), tried("c", 7.0, -0.2, 0.0)], ("q", 3.0, "c")),
        ([tried("b", 8.0, -0.1, -0.2)], None),  # two are missed
        ([tried("b", 11.0, 0.1, -0.2)], None),  # it costs more
        ([tried("b", 8.0, 0.1, -0.005)], None),  # by no more than chance: 0.9 of 900 has a standard error of 0.01
        ([tried("b", 8.0, 0.1, -0.2, trials=1)], None),
    ],
)
def test_the_requirement_that_rules_out_the_cheapest(others, found):
    result = Optimised.__new__(Optimised)
    needs = [SimpleNamespace(required=0.5), SimpleNamespace(required=0.9)]
    for name, value in {"aim": "energy", "chosen": {"out.speed": "a"}, "checked": SimpleNamespace(requirements=needs),
                        "tried": (tried("a", 10.0, 0.1, 0.1), *others)}.items():  # fmt: skip
        object.__setattr__(result, name, value)
    expected = None if found is None else RuledOut(found[0], found[1], {"out.speed": found[2]})
    assert result.ruled_out == expected
    object.__setattr__(result, "aim", "duration")  # where less energy takes more time it rules out nothing
    assert result.ruled_out is None or min(each.energy for each in others) > 10.0


def test_where_every_cell_misses_a_requirement_all_that_run_may_still_be_the_best():
    missing = SimpleNamespace(met=False, undecided=False)
    open_ = SimpleNamespace(met=False, undecided=True)
    bad, maybe = (SimpleNamespace(reason="", requirements=(each,), meets_all=False) for each in (missing, open_))
    failed = SimpleNamespace(reason="too long", requirements=(), meets_all=False)
    assert _last([bad, failed, bad], [None] * 3, [0, 1, 2], "success") == [0, 2]
    assert _last([bad, failed, maybe], [None] * 3, [0, 1, 2], "success") == [2]
