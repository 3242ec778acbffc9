"""Sections that mission and vehicle may both hold: one value is in force of each key, and it is the one that runs."""

import copy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import missionplan
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.mission.quantity_paths import SHARED, values_in_force
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.mission.validation_errors import keys_of, section_in
from missionplan.report.planned import planned_sections
from missionplan.studies.simulation.simulate import simulate, simulate_block
from missionplan.studies.validate import validate

MISSIONS = Path(__file__).parents[2] / "missions"
CHESAPEAKE = dict(missionplan.load(MISSIONS / "chesapeake.yaml").raw)
VALUES = {
    "energy": {
        "hotel": st.sampled_from(["8 W", "0 W", "300 W", {"mean": "8 W", "sd": "1 W"}, {"low": "5 W", "high": "9 W"}]),
        "propulsive_efficiency": st.sampled_from([0.45, 0.3, {"low": 0.3, "high": 0.6}]),
        "surfacing": st.sampled_from(["0 J", "400 J", {"median": "1 kJ", "factor": 2}]),
        "capacity": st.sampled_from(["60 W*h", "25 W*h", {"mean": "30 W*h", "sd": "3 W*h"}]),
    }
}
"""Of every key of every shared section, some values of which each changes what a mission does."""


def mission_of(of_mission, of_vehicle, *, hold=None):
    """The mission with these sections in its files, without its mooring where that is not to hold."""
    data = copy.deepcopy(CHESAPEAKE)
    data["phases"][1]["moor"]["hold"] = hold or "0 s"
    if hold is None:
        del data["phases"][1], data["requirements"]
    for name in SHARED:
        for holder, sections in ((data, of_mission), (data["vehicle"], of_vehicle)):
            holder.pop(name, None)
            if sections.get(name) is not None:
                holder[name] = copy.deepcopy(sections[name])
    return Mission.from_data(data)


def numbers(mission):
    block = simulate_block(mission, seed=3, block=0, trials=4)
    columns = {f"{phase.name}.{key}": value for phase in block.phases for key, value in phase.quantities.items()}
    return {**block.draws, **columns, **block.total, "success": block.success}


def assert_same_bits(one, other):
    assert one.keys() == other.keys()
    for key, value in one.items():
        assert np.array_equal(value, other[key], equal_nan=True), key


def sections():
    return st.fixed_dictionaries(
        {}, optional={name: st.fixed_dictionaries({}, optional=values) for name, values in VALUES.items()}
    )


def test_every_section_of_two_files_is_shared_and_tried_here():
    both = keys_of(Mission).keys() & keys_of(Vehicle).keys()
    assert {name for name in both if section_in(keys_of(Mission)[name].annotation)} == set(SHARED)
    assert {name: set(values) for name, values in VALUES.items()} == {
        name: set(section.model_fields) for name, section in SHARED.items()
    }


@settings(max_examples=15)
@given(sections(), sections())
def test_a_value_in_force_may_stand_in_either_file_to_the_bit(of_mission, of_vehicle):
    mission = mission_of(of_mission, of_vehicle)
    force = {}
    for each in mission.values_in_force():
        if each.value is not None:  # a capacity that no file gives has nothing to write
            force.setdefault(each.path[0], {})[each.path[1]] = each.value
    expected = numbers(mission)
    for upper, lower in ((force, of_vehicle), (of_mission, _under(of_mission, of_vehicle, force)), ({}, force)):
        assert_same_bits(numbers(mission_of(upper, lower)), expected)


def _under(of_mission, of_vehicle, force):
    """The vehicle's sections with every value in force."""
    return {name: {**(of_vehicle.get(name) or {}), **section} for name, section in force.items()}


@pytest.mark.parametrize("energy", [{"hotel": "8 W"}, {"capacity": "60 W*h"}, {}])
def test_a_mission_that_repeats_a_value_of_its_vehicle_runs_out_of_energy_as_without_it(energy):
    vehicle = {"energy": CHESAPEAKE["vehicle"]["energy"]}
    plain, repeated = (numbers(mission_of(each, vehicle, hold="20 h")) for each in ({}, {"energy": energy}))
    assert not plain["success"].any()
    assert_same_bits(plain, repeated)


def test_validate_and_the_report_say_what_is_in_force_and_where_it_is_from():
    mission = mission_of({"energy": {"hotel": "9 W"}}, {"energy": {"hotel": "8 W", "capacity": "60 W*h"}})
    assert [str(each) for each in validate(mission)[0].values] == [
        "energy.hotel: 9 W (mission, not the vehicle's 8 W)",
        "energy.propulsive_efficiency: 0.45 (default)",
        "energy.surfacing: 0 J (default)",
        "energy.capacity: 60 W*h (vehicle)",
    ]
    sections = planned_sections(simulate(mission, trials=2, seed=1, sheet=False).provenance)
    planned = next(section for section in sections if section.heading == "What was planned")
    rows = dict(planned.blocks[-1].rows)
    assert rows["Hotel load"] == "9 W (mission, not the vehicle's 8 W)"
    assert rows["Energy of a surfacing"] == "0 J (default)"
    assert rows["Energy in the battery"].endswith("(vehicle)")


def test_a_key_of_the_vehicle_that_changes_nothing_is_refused_with_the_one_that_does():
    both = mission_of({"energy": {"hotel": "9 W"}}, {"energy": {"hotel": "8 W", "capacity": "60 W*h"}})
    with pytest.raises(InputError, match=r"vehicle.energy.hotel: changes nothing.*did you mean energy.hotel"):
        both.with_({"vehicle.energy.hotel": "7 W"})
    with pytest.raises(InputError, match="changes nothing"):
        missionplan.explore(both, "vehicle.energy.hotel=7 W,9 W", trials=4)
    assert both.with_(hotel="7 W").budget.hotel == 7.0
    assert both.with_(capacity="50 W*h").raw["vehicle"]["energy"]["capacity"] == "50 W*h"
    found = missionplan.explore(both, "energy.capacity=20 W*h,60 W*h", trials=4)
    assert [cell.success.value for cell in found.cells] == [0.0, 1.0]


def test_correlations_name_a_quantity_in_either_file():
    varied = {"energy": {"hotel": {"mean": "8 W", "sd": "1 W"}}}
    data = copy.deepcopy(dict(mission_of({}, varied).raw))
    data["navigation"]["surfacing_time"] = {"mean": "90 s", "sd": "9 s"}
    tied = [
        {"between": [name, "navigation.surfacing_time"], "rho": 0.9}
        for name in ("vehicle.energy.hotel", "energy.hotel")
    ]
    one, other = (numbers(Mission.from_data({**data, "correlations": [each]})) for each in tied)
    assert_same_bits(one, other)
    with pytest.raises(AssertionError):
        assert_same_bits(one, numbers(Mission.from_data(data)))


def test_nothing_is_in_force_where_neither_file_has_the_section():
    assert list(values_in_force(mission_of({}, {}).raw)) == []
