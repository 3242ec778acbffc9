"""What `compare` reads of reports, by summaries made by hand: each number to its own place."""

import math
from pathlib import Path

import pytest

from missionplan.errors import InputError
from missionplan.studies.comparison.reported_choices import aim_of, check_kinds, estimates_of, reported_alternative

FOLDER = Path("somewhere")
SUCCESS = {"value": 0.91, "low": 0.89, "high": 0.93}
QUANTITIES = {
    "duration_s": {"mean": 1234.0, "standard_error": 5.6},
    "energy_wh": {"mean": None},
    "surfacings": {"mean": 3.0, "standard_error": 0.1},
}
REQUIREMENTS = [
    {
        "quantity": "moor.offset",
        "at_most": 9.5,
        "required": 0.95,
        "probability": {"value": 0.97, "low": 0.96, "high": 0.98},
        "met": True,
        "undecided": False,
    },
    {
        "quantity": "moor.lowest_altitude",
        "at_least": 0.3,
        "required": 0.99,
        "probability": {"value": 0.98, "low": 0.97, "high": 0.995},
        "met": False,
        "undecided": True,
    },
    {"quantity": "out.arrived", "required": 0.9, "probability": SUCCESS, "met": True, "undecided": False},
]
SIMULATED = {
    "command": "simulate",
    "seed": 7,
    "trials": 4000,
    "total": {"events": {"success": SUCCESS}, "quantities": QUANTITIES},
    "requirements": REQUIREMENTS,
}


def cell(values, met, success=SUCCESS):
    items = [{**item, "met": item["met"] and met} for item in REQUIREMENTS[::2]]
    return {
        "values": values,
        "trials": 500,
        "success": success,
        "requirements": items,
        "quantities": {
            "total.duration_s": QUANTITIES["duration_s"],
            "out.duration_s": {"mean": 1.0, "standard_error": 1.0},
        },
    }


EXPLORED = {
    "command": "explore", "seed": 8, "aim": "energy", "vary": [{"keys": ["out.speed", "back.speed"]}, {"keys": ["moor.hold"]}],
    "best": cell({"out.speed+back.speed": "1.5 m/s", "moor.hold": "9 min"}, met=True), "windows": [{"from": "1 m/s", "to": "2 m/s"}],
    "cells": [cell({"a": "1"}, met=True), cell({"a": "2"}, met=False), {"values": {"a": "3"}, "reason": "no"}],
}  # fmt: skip
OBSTACLES = [{"quantity": "total.duration", "required": 0.9, "reached": {"value": 0.4, "low": 0.3, "high": 0.5}}]
OPTIMISED = {
    **SIMULATED,
    "command": "optimise",
    "aim": "energy",
    "chosen": {"out.speed": "1.5 m/s"},
    "combinations": 77,
}


def test_a_simulation_is_read_with_its_requirements():
    found = reported_alternative("one", FOLDER, SIMULATED)
    assert (found.name, found.source, found.trials, found.seed, found.chosen) == ("one", "somewhere", 4000, 7, None)
    assert (found.success.value, found.success.low, found.success.high) == (0.91, 0.89, 0.93)
    assert found.quantities == {"duration_s": (1234.0, 5.6)}  # the energy is not known
    told = [
        (
            item.quantity,
            item.bound,
            item.limit,
            item.required,
            item.probability.value,
            item.met,
            item.undecided,
            item.trials,
        )
        for item in found.requirements
    ]
    assert told == [
        ("moor.offset", "at_most", 9.5, 0.95, 0.97, True, False, 4000),
        ("moor.lowest_altitude", "at_least", 0.3, 0.99, 0.98, False, True, 4000),
        ("out.arrived", None, None, 0.9, 0.91, True, False, 4000),
    ]


def test_of_an_exploration_its_best_cell_counts_and_what_it_was_chosen_from():
    found = reported_alternative("two", FOLDER, EXPLORED)
    assert (found.trials, found.seed) == (500, 8)
    assert found.quantities == {"duration_s": (1234.0, 5.6)}  # of the whole mission, not of a phase
    assert found.chosen.values == {"out.speed+back.speed": "1.5 m/s", "moor.hold": "9 min"}
    assert found.chosen.windows == (("1 m/s", "2 m/s"),)
    one, two, three = found.chosen.cells
    assert [(each.values, each.meets_all) for each in (one, two, three)] == [
        (("1",), True),
        (("2",), False),
        (("3",), False),
    ]
    assert one.success.value == 0.91
    assert math.isnan(three.success.value)


def test_of_an_optimisation_the_choice_or_what_stands_against_one():
    found = reported_alternative("three", FOLDER, OPTIMISED)
    assert (found.chosen.values, len(found.requirements)) == ({"out.speed": "1.5 m/s"}, 3)
    assert 77 in vars(found.chosen).values()
    none = reported_alternative("four", FOLDER, {**OPTIMISED, "requirements": [], "obstacles": OBSTACLES})
    ((item),) = none.requirements
    assert (item.quantity, item.probability.value, item.required, item.met, item.undecided) == (
        "total.duration",
        0.4,
        0.9,
        False,
        False,
    )
    with pytest.raises(InputError, match="was made by tide"):
        reported_alternative("five", FOLDER, {"command": "tide"})


def test_unlike_things_are_not_compared():
    def kinds(*summaries):
        return check_kinds([(Path(f"{number}"), each) for number, each in enumerate(summaries)])

    assert kinds(SIMULATED, {}) == "simulate"
    assert kinds(EXPLORED, EXPLORED) == "explore"
    assert kinds(OPTIMISED, OPTIMISED) == "optimise"
    with pytest.raises(InputError, match=r"1 was made by optimise[\s\S]*1/mission-optimised\.yaml"):
        kinds(SIMULATED, OPTIMISED)
    with pytest.raises(InputError, match="1 is a mission"):
        kinds(EXPLORED, {})
    other = {**EXPLORED, "vary": EXPLORED["vary"][::-1]}
    with pytest.raises(InputError, match=r"0 varies out\.speed\+back\.speed\+moor\.hold, 1 varies moor\.hold"):
        kinds(EXPLORED, other)
    assert aim_of([OPTIMISED, EXPLORED]) == "energy"
    assert aim_of([OPTIMISED, SIMULATED]) == "success"
    assert aim_of([{"aim": "beauty"}]) == "success"
    assert estimates_of({"energy_wh": {"mean": 5.0, "standard_error": 0.25}}) == {"energy_wh": (5.0, 0.25)}
