"""Every effect in an explanation: in the trials in which it holds as if it always did, else as if it were not there."""

import copy
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.diagnosis.dives.forward import SubsetEffect
from missionplan.effects import CATALOGUE
from missionplan.effects.info import EffectInfo
from missionplan.mission import Mission
from missionplan.phases.hooks import DescentEffect, TransitEffect
from missionplan.studies.simulation.simulate import simulate_block

MISSIONS = Path(__file__).parents[2] / "missions"
IN_PLAN = [info.id for info in CATALOGUE.values() if info.changes_plan and info.phase != "tank"]
TRIALS = 12


def data_for(phase):
    data = copy.deepcopy(dict(missionplan.load(MISSIONS / "chesapeake.yaml").raw))
    data["phases"] = data["phases"][:1] if phase == "transit" else data["phases"][1:2]
    data["navigation"] |= {"drift_compensation": "filter"}
    if phase == "descent":
        data["phases"][0]["moor"] |= {"line_length": "3 m"}
        data["phases"].insert(0, {"transit": {"from": ["0 m", "0 m"], "to": ["100 m", "0 m"], "speed": "1.5 m/s",
                                              "d_max": "200 m", "arrival_radius": "50 m"}})  # fmt: skip
    return {key: value for key, value in data.items() if key != "requirements"}


def parameters(info: EffectInfo):
    """Plausible values: the neutral parameters uncertain, the others fixed."""
    found = {}
    for name, parameter in info.parameters.items():
        size = 0.3 * parameter.scale if parameter.scale > 0.0 else parameter.median
        if name == "moment":  # in the mission's first leg, or under way to the seafloor
            size = 60.0 if info.phase == "transit" else 3.0
        if size > 0.0:
            value = {"mean": size, "sd": 0.1 * size} if name in info.neutral else size
            found[name] = _written(value, parameter.unit)
    return found


def _written(value, unit):
    if isinstance(value, dict):
        return {key: _written(each, unit) for key, each in value.items()}
    return f"{value} {unit}" if unit else value


def columns(data, effects):
    trials = simulate_block(Mission.from_data({**data, "effects": effects}), seed=2, block=0, trials=TRIALS)
    found = {f"{phase.name}.{key}": value for phase in trials.phases for key, value in phase.quantities.items()}
    return {**found, **trials.total, "success": trials.success}, trials.draws


@cache
def without_effects(phase, compensation):
    data = data_for(phase)
    data["navigation"]["drift_compensation"] = compensation
    return columns(data, [])[0]


def assert_same_bits(one, other, trials=slice(None)):
    for key, value in one.items():
        assert np.array_equal(value[trials], other[key][trials], equal_nan=True), key


@pytest.mark.parametrize("name", IN_PLAN)
def test_an_effect_in_doubt_acts_in_the_trials_in_which_it_holds_and_in_no_other(name):
    info = CATALOGUE[name]
    data, effect = data_for(info.phase), {name: parameters(info)}
    certain = {"one-of": [{"probability": 1.0, "effects": [effect]}]}
    if info.phase == "transit":
        assert_same_bits(columns(data, [certain])[0], columns(data, [effect])[0])
    data["navigation"]["drift_compensation"] = "last-leg"  # the filter's prior allows for the doubt
    (always, _), never = columns(data, [effect]), without_effects(info.phase, "last-leg")
    assert any(not np.array_equal(never[key], value, equal_nan=True) for key, value in always.items())
    if name in ("drag-bias", "line-payout"):  # of dives
        assert_same_bits(columns(data, [certain])[0], always)
    doubtful, draws = columns(data, [{"one-of": [{"probability": 0.5, "effects": [effect]}]}])
    holds = draws["effects[0].one-of"] == 0.0
    assert 0 < holds.sum() < TRIALS
    assert_same_bits(doubtful, always, holds)
    assert_same_bits(doubtful, never, ~holds)


@pytest.mark.parametrize("name", IN_PLAN)
def test_neutral_parameters_leave_an_effect_without_any(name):
    """Whatever the shapes are, no hook does anything."""
    info = CATALOGUE[name]
    shapes = {key: parameter.median for key, parameter in info.parameters.items() if parameter.median > 0.0}
    made = info.make({**shapes, **info.neutral})
    base = TransitEffect() if info.phase == "transit" else DescentEffect()
    arguments = {"drag_factor": (1.0, 1.5), "wet_weight_factor": (1.0,), "lift": (8.0,), "delay": (5.0,),
                 "error_scale": (np.full((2, 3), 0.4),)}  # fmt: skip
    plain = ("lone_drag_factor", "mass_factor", "water_velocity", "fix_variance", "position_variance_rate", "tail_dof")
    for hook in (*arguments, *plain):
        if hasattr(base, hook):
            given = arguments.get(hook, ())
            assert np.all(getattr(made, hook)(*given) == getattr(base, hook)(*given)), hook


def test_the_wrapper_of_the_diagnosis_repeats_every_hook_of_a_descent():
    hooks = {name for name in vars(DescentEffect) if not name.startswith("_")}
    assert hooks <= vars(SubsetEffect).keys()


def test_a_walk_of_the_position_in_doubt_costs_what_it_costs_always():
    """Each leg's walk is drawn anew: of 512 trials nearly all have it where its probability is 0.999."""
    data = copy.deepcopy(dict(missionplan.load(MISSIONS / "fig8.yaml").raw))
    data["phases"][0]["transit"]["d_max"] = "2 km"
    walk = {"position-random-walk": {"rate": "8 m/s^0.5"}}
    durations = []
    for effects in ([], [walk], [{"one-of": [{"probability": 0.999, "effects": [walk]}]}]):
        mission = Mission.from_data({**data, "effects": effects})
        durations.append(simulate_block(mission, seed=1, block=0, trials=512).total["duration_s"].mean())
    without, always, likely = durations
    assert always > 1.1 * without
    assert likely == pytest.approx(always, rel=2e-3)


def test_of_two_doubts_about_one_effect_each_has_its_own_numbers():
    walk = {"random-walk": {"rate": "1e-3 m/s^1.5"}}
    doubt = {"one-of": [{"probability": 1.0, "effects": [walk]}]}
    listed = Mission.from_data({**data_for("transit"), "effects": [doubt, doubt, walk]}).effect_list
    assert listed.streams() == {
        "effects.random-walk": "effects.random-walk",
        "effects[0].one-of[0].random-walk": "effects[0].one-of[0].random-walk",
        "effects[1].one-of[0].random-walk": "effects[1].one-of[0].random-walk",
    }
    alone = Mission.from_data({**data_for("transit"), "effects": [doubt, doubt]}).effect_list.streams()
    assert alone["effects[0].one-of[0].random-walk"] == "effects.random-walk"
    assert len(set(alone.values())) == 2
