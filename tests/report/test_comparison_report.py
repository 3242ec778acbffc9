"""What the report of two runs says of noise, and of requirements that only one run has."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from missionplan.montecarlo.statistics import wilson
from missionplan.report.page import Table
from missionplan.results import Provenance
from missionplan.results.simulation import RequirementOutcome
from missionplan.studies.comparison import _contrasts, alternatives_page
from missionplan.studies.comparison.changes_page import answer, page
from missionplan.studies.comparison.result import (
    Alternative,
    Alternatives,
    ChangedValue,
    ComparedNumber,
    ComparedRun,
    Comparison,
    Contrast,
    ListItem,
)


def mission(limit):
    return {"requirements": [{"quantity": "moor.offset", "at_most": limit, "probability": 0.9}]}


def compared(group, key, *numbers):
    """A number where it stands in a summary, by default in that of a phase."""
    *values, place = numbers if isinstance(numbers[-1], tuple) else (*numbers, ())
    section = {"total": "total"}.get(group, "phases")
    return ComparedNumber(group, key, *values, place or (section, group, key))


def required(quantity, limit, *numbers):
    item = ListItem(quantity, limit, "at_most")
    return compared("requirement", str(item), *numbers, ("requirements", item, "probability"))


@pytest.fixture
def comparison():
    run = ComparedRun("report", "Bay", "0.1", "2026-01-01T00:00:00+00:00", 1, 1000)
    return Comparison(
        provenance=Provenance(
            command="compare",
            mission="Bay",
            file="report report",
            seed=1,
            trials=1000,
            elapsed_s=0.1,
            data={"first": mission("75 ft"), "second": mission("10 m")},
        ),
        compared="simulate",
        runs=(run, run),
        mission_changes=(),
        option_changes=(),
        differences=(
            compared("moor", "lowest_altitude_m", "mean", 1.5, 0.8, 4e-18, 0.0, "changed"),
            compared("moor", "offset_m", "mean", 4.0, 6.0, 0.1, 1e-9, "changed"),
            required("moor.offset", 22.86, "probability", 0.99, None, None, None, "only first"),
        ),
        requirement_changes=(ChangedValue("total.success", "met", ""), ChangedValue("egress.arrived", "", "not met")),
    )


def rows(comparison):
    tables = (block for section in page(comparison).sections for block in section.blocks if isinstance(block, Table))
    return {row[0]: row[1:] for table in tables for row in table.rows}


def test_rounding_is_no_noise(comparison):
    assert "most clearly the offset of the anchor (moor)" in answer(comparison)
    assert rows(comparison)["lowest altitude of the nose (moor)"][-1] == "−0.7\u00a0m"
    assert "the clearest is that of the offset of the anchor (moor) at 20.0" in page(comparison).figure.alt


def test_a_limit_that_the_mission_does_not_show_has_its_unit(comparison):
    added = required("total.energy", 162_000.0, "probability", 0.9, 0.8, 0.01, 0.0, "changed")
    assert "total energy at most 162\u202f000\u00a0J (requirement)" in rows(replace(comparison, differences=(added,)))


def test_a_requirement_on_a_phase_of_any_name_is_named_as_the_mission_has_it(comparison):
    data = {"second": {"requirements": [{"quantity": "moor, first.offset", "at_most": "75 ft", "probability": 0.9}]}}
    there = replace(comparison, provenance=replace(comparison.provenance, data=data))
    one = required("moor, first.offset", 22.86, "probability", 0.9, 0.8, 0.01, 0.0, "changed")
    assert "offset of the anchor (moor, first) at most 75 ft (requirement)" in rows(replace(there, differences=(one,)))


def test_what_decides_comes_first_then_the_clearest_change(comparison):
    success = compared("total", "success", "probability", 0.9, 0.8, 0.005, 1e-9, "changed")
    weak = compared("moor", "duration_s", "mean", 600.0, 603.0, 1.0, 1e-3, "changed")
    shown = replace(comparison, differences=(weak, *comparison.differences, success))
    assert answer(shown).startswith(
        "The probability of success was 90.0\u00a0% and is now 80.0\u00a0% (−10.0\u00a0±\u00a00.5\u00a0%)."
    )
    names = [row[0] for row in page(shown).table()[1]]
    assert names == [
        "success of the mission",
        "offset of the anchor (moor) at most 75 ft (requirement)",
        "offset of the anchor (moor)",  # 20 standard errors
        "duration (moor)",  # 3
        "lowest altitude of the nose (moor)",  # without noise
    ]
    alt = page(replace(comparison, differences=(weak, *comparison.differences))).figure.alt
    assert alt.startswith("Changes of 2 numbers")
    assert alt.endswith("the clearest is that of the offset of the anchor (moor) at 20.0.")


def test_missions_that_are_not_alike_are_said_so_in_one_line(comparison):
    first = {"phases": [{"transit": {"name": "in"}}, {"moor": {}}]}
    second = {"phases": [{"transit": {"name": "out"}}]}
    changes = tuple(ChangedValue(f"key {number}", "", "1") for number in range(90))
    data = {"first": first, "second": second}
    unlike = replace(comparison, provenance=replace(comparison.provenance, data=data), mission_changes=changes)
    assert answer(unlike).startswith("The two missions are not alike: the first has in, moor, the second out; ")
    assert not any(row[0].startswith("key") for row in page(unlike).table()[1])
    assert not any(name.startswith("key") for name in rows(unlike))
    same = replace(comparison, mission_changes=changes)
    assert answer(same).startswith("The two missions are not alike: 90 values of their files differ; ")


def test_requirements_of_one_run_are_named_as_that_run_has_them(comparison):
    assert "offset of the anchor (moor) at most 75 ft (requirement)" in rows(comparison)
    assert "The requirement on the success of the mission, which was met, has been dropped." in answer(comparison)
    assert "The new requirement on the arrival (egress) is not met." in answer(comparison)


def test_numbers_of_a_sweep_are_named_in_words(comparison):
    def cost(place, sigma=0.035):
        return compared(
            "sweep", "cost", "mean", 0.2, 0.3, 0.001, 0.0, "changed", ("sweep", ListItem(number=sigma), *place, "cost")
        )

    swept = replace(
        comparison, compared="sweep-dmax", differences=(cost(("curve", ListItem(number=48.0))), cost(("recommended",)))
    )
    assert rows(swept)["mean cost at d_max = 48\u00a0m"][-1] == "+10.00\u00a0±\u00a00.10\u00a0%"
    assert "the mean cost at d_max = 48\u00a0m (+10.00\u00a0±\u00a00.10\u00a0%)" in answer(swept)
    assert "mean cost at the recommended d_max" in rows(swept)
    assert swept.deciding == swept.differences[1:]
    two = replace(swept, differences=(cost(("one_leg",)), cost(("one_leg",), 0.07)))
    assert "mean cost in one leg (σ_v = 0.07\u00a0m/s)" in rows(two)


def alternative(name, successes, energy, error, trials, met=True, **contrasts):
    requirement = RequirementOutcome(
        "out.arrived", None, None, "", 0.9, wilson(successes, trials), met, undecided=False
    )
    found = {key: Contrast(*each, paired=True) for key, each in contrasts.items()}
    quantities = {"energy_wh": (energy, error), "duration_s": (7200.0, 60.0)}
    return Alternative(name, f"{name}.yaml", wilson(successes, trials), quantities, (requirement,), trials, 3, found)


def test_independent_runs_differ_by_their_numbers_with_both_errors_beyond_chance_for_all_together():
    """Of two others each at 2.5 %: z of 2.2 (0.028) is chance, 2.3 (0.021) is none. One of 90 of 100 and of 320 of 400."""
    best = alternative("best", 90, 20.0, 0.3, 100)
    for z, differs in ((2.2, False), (2.3, True)):
        other = alternative("other", 320, 20.0 + 0.5 * z, 0.4, 400)
        found = _contrasts([best, other, other], [{}, {}, {}], 1, 0)
        energy, success = found["energy_wh"], found["success"]
        assert (energy.difference, energy.error) == pytest.approx((0.5 * z, 0.5))
        assert (energy.differs, energy.paired) == (differs, False)
        assert (success.difference, success.error) == pytest.approx((-0.1, (0.09 / 100 + 0.16 / 400) ** 0.5))
    same = _contrasts(
        [best, other], [{"total.energy_wh": np.array([1.0, 4.0])}, {"total.energy_wh": np.array([2.0, 7.0])}], 1, 0
    )
    assert (same["energy_wh"].difference, same["energy_wh"].paired) == (2.0, True)


def alternatives(*others, aim="success", **given):
    made = (alternative("near", 960, 24.0, 0.1, 1000), *others)
    data = {each.name: {"phases": [{"transit": {"name": "out"}}]} for each in made}
    provenance = Provenance("compare", "near and far", "a b", 3, 1000, elapsed_s=0.1, data=data)
    return Alternatives(provenance, made, 0, aim=aim, **given)


def plain(text):
    return text.replace("\u00a0", " ").replace("\u202f", " ")


def test_which_is_better_is_told_with_the_nearest_and_what_costs_less():
    far = alternative(
        "far",
        900,
        21.0,
        0.2,
        1000,
        success=(-0.06, 0.01, True),
        energy_wh=(-3.0, 0.2, True),
        duration_s=(60.0, 40.0, False),
    )
    farther = alternative("farther", 700, 30.0, 0.2, 1000, success=(-0.26, 0.02, True))
    alike = alternative("alike", 958, 23.0, 0.2, 1000, success=(-0.002, 0.004, False), energy_wh=(-1.0, 0.2, True))
    words = plain(alternatives_page.answer(alternatives(farther, far, alike)))
    assert words == (
        "near is better than farther and far: it succeeds with 96.0 ± 1.2 %, 6.0 ± 1.0 % more often than far. "
        "alike cannot be told from it by P(success) (alike differs by −0.2 ± 0.4 %). alike takes less energy, by 1.0 ± 0.2 W h, than near."
    )
    rows = {row[0]: [plain(cell) for cell in row[1:]] for row in alternatives_page._table(alternatives(far)).rows}
    assert rows == {
        "requirements": ["1 of 1 met", "1 of 1 met"], "P(success)": ["96.0 ± 1.2 %", "90.0 ± 1.9 %"],
        "energy": ["24.00 ± 0.10 W h", "21.0 ± 0.2 W h"], "duration": ["120.0 ± 1.0 min", "120.0 ± 1.0 min"], "against the best": ["best", "−6.0 ± 1.0 %"],
    }  # fmt: skip
    by_time = plain(alternatives_page.answer(alternatives(far, aim="duration")))
    assert by_time == "near and far cannot be told apart by their duration."
    assert (
        plain(alternatives_page._cells(alternatives(far, aim="duration"))[1][1][-1]) == "+1.0 ± 0.7 min: not told apart"
    )
    misses = alternative("misses", 950, 20.0, 0.1, 1000, met=False, success=(-0.01, 0.01, False))
    assert "misses misses the requirement on the arrival (out)" in plain(alternatives_page.answer(alternatives(misses)))


def test_alternatives_are_drawn_with_intervals_of_95_percent():
    axes = Figure().add_subplot()
    alternatives_page.draw_alternatives(axes, alternatives(alternative("far", 900, 21.0, 0.2, 1000)), "energy_wh")
    spans = [bar.get_segments()[0][:, 0] for bar in axes.collections]
    assert np.array(spans) == pytest.approx(np.array([[24.0 - 0.196, 24.0 + 0.196], [21.0 - 0.392, 21.0 + 0.392]]))
    assert [label.get_text() for label in axes.get_yticklabels()] == ["near", "far"]
    assert [container.lines[0].get_ydata()[0] for container in axes.containers] == [0, 1]
    assert axes.yaxis_inverted()
