"""Trials that have arrived are dropped from the arrays: the others, and their effects, have the numbers of the whole."""

from dataclasses import fields

import numpy as np
import pytest
from transit_examples import plan

from missionplan.effects import effects_of
from missionplan.montecarlo.streams import BlockStreams
from missionplan.phases.currents import LayeredCurrent, Leeway
from missionplan.phases.hooks import TrialState
from missionplan.phases.transit import transit
from missionplan.phases.transit.plan import Environment, TransitNormals, VelocityError

TRIALS = 1024
STREAMS = BlockStreams(3, 0)
CURRENT = LayeredCurrent(np.array([100.0]), np.linspace(0.0, 0.2, TRIALS)[None], np.full((1, TRIALS), 0.1))


def strong(info):
    """An effect of other sizes in every trial."""
    rng = np.random.default_rng(7)
    sizes = {name: each.scale * rng.uniform(0.5, 1.5, TRIALS) for name, each in info.parameters.items() if each.scale}
    return info.make({"dof": rng.uniform(3.0, 8.0, TRIALS)} if info.id == "heavy-tails" else sizes)


EFFECTS = {info.id: strong(info) for info in effects_of("transit")}
EFFECTS["leeway"] = Leeway(CURRENT, 0.03, *(np.linspace(0.0, size, TRIALS) for size in (0.01, 0.02, 0.02)))


@pytest.mark.parametrize("name", EFFECTS)
def test_a_trial_is_what_it_is_beside_those_that_have_arrived(name):
    legs = STREAMS.legs
    normals = TransitNormals(legs("v"), legs("a"), legs("b"), [legs("effect")])
    error = VelocityError.isotropic(0.08)
    given = plan(d_max=150.0, fix_error=4.0, latitude=0.8, depth=20.0, velocity_error=error, max_legs=60)
    environment = Environment(current=CURRENT, effects=(EFFECTS[name],))
    state = TrialState.at(np.zeros(2), TRIALS)
    (dropped, with_drops), (kept, whole) = (
        transit(given, state, normals, environment, tracked=tracked) for tracked in (0, 1)
    )
    assert len(np.unique(whole.surfacings)) > 3
    for each in fields(dropped):
        np.testing.assert_array_equal(getattr(dropped, each.name), getattr(kept, each.name), err_msg=each.name)
    for one in ("duration", "surfacings", "distance", "arrival_error", "energy", "arrived", "outrun", "left_record"):
        np.testing.assert_array_equal(getattr(with_drops, one), getattr(whole, one), err_msg=one)
