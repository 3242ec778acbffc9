"""What the report of two runs says of noise, and of requirements that only one run has."""

from dataclasses import replace

import pytest

from missionplan.report.page import Table
from missionplan.results import Provenance
from missionplan.studies.comparison.changes_page import answer, page
from missionplan.studies.comparison.result import ChangedValue, ComparedNumber, ComparedRun, Comparison, ListItem


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
    two = replace(swept, differences=(cost(("one_leg",)), cost(("one_leg",), 0.07)))
    assert "mean cost in one leg (σ_v = 0.07\u00a0m/s)" in rows(two)
