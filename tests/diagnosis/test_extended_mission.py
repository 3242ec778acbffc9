"""Whatever a diagnosis estimates, the mission that it writes can be read, and draws what is physically possible."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.diagnosis.extended_mission import extended_mission, quantity
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission, load
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.montecarlo.distributions import Distribution
from missionplan.results.learned.evidence import ParameterEstimate

MISSION = Path(__file__).parents[2] / "missions" / "chesapeake.yaml"
PARAMETERS = [
    (effect, name)
    for effect, info in CATALOGUE.items()
    if info.phase != "tank"
    for name in info.parameters
    if not name.startswith("phase")
]


def estimate(effect, name, value, sd):
    return ParameterEstimate(effect, name, value, sd, value - sd, value + sd, CATALOGUE[effect].parameters[name].unit)


@given(
    st.sampled_from(PARAMETERS),
    st.floats(0.01, 3.0),
    st.floats(1e-3, 3.0),
)
def test_what_is_written_can_be_read_and_draws_inside_the_range(of, size, spread):
    effect, name = of
    parameter = CATALOGUE[effect].parameters[name]
    usual = parameter.median or parameter.scale or 1.0
    top = parameter.high if np.isfinite(parameter.high) else usual
    value = size * top
    written = quantity(estimate(effect, name, value, spread * value))
    read = QuantityParser(parameter.unit, parameter.low, parameter.high).parse(written)
    assert isinstance(read, Distribution)
    drawn = read.from_normal(np.linspace(-3.0, 3.0, 7))
    assert np.all((drawn >= parameter.low) & (drawn <= parameter.high))


@pytest.mark.parametrize(
    ("effect", "name", "value", "sd"),
    [
        ("inertial-current", "modulation", 1.8, 1.5),
        ("inertial-current", "modulation", 2.6, 1.0),
        ("trapped-gas", "lift", -0.01, 0.05),
    ],
)
def test_a_value_at_the_edge_of_what_is_possible_does_not_spoil_the_mission(effect, name, value, sd):
    base = load(MISSION).raw
    amplitudes = [("amplitude", 0.1), ("phase", 0.0)] if effect == "inertial-current" else []
    found = [estimate(effect, each, at, 0.01) for each, at in amplitudes] + [estimate(effect, name, value, sd)]
    mission = Mission.from_data(extended_mission(base, found, {}))
    assert effect in str(mission.raw["effects"])
