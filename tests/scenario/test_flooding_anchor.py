"""Flooding of the anchor as vehicle files give it."""

import copy
from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.errors import InputError
from missionplan.mission import Mission
from missionplan.studies.judgement import doubts_of
from missionplan.studies.simulation.simulate import simulate_block

MISSIONS = Path(__file__).parents[2] / "missions"


def chesapeake(**anchor):
    data = copy.deepcopy(dict(missionplan.load(MISSIONS / "chesapeake.yaml").raw))
    data["vehicle"]["anchor"].update(anchor)
    return Mission.from_data(data)


def mooring(mission, trials=300):
    found = simulate_block(mission, seed=1, block=0, trials=trials)
    return found, found.phases[1]


def test_flooding_takes_time_and_leaves_other_draws_alone():
    (_, plain), (_, slow) = (
        mooring(chesapeake(**keys)) for keys in ({}, {"flooding_time": {"low": "2 s", "high": "8 s"}})
    )
    assert np.array_equal(plain.quantities["release_time_s"], slow.quantities["release_time_s"], equal_nan=True)
    later = slow.quantities["descent_time_s"] - plain.quantities["descent_time_s"]
    later = later[np.isfinite(later)]
    assert ((later > 0.2) & (later < 4.0)).all()
    assert np.std(later) > 0.1


def test_a_vehicle_file_without_a_time_is_told_what_it_would_cost():
    silent, told = (
        {doubt.what: doubt.otherwise for doubt in doubts_of(mission)}
        for mission in (chesapeake(), chesapeake(flooding_time="0 s"))
    )
    assert silent.keys() - told.keys() == {"the anchor is full of water at once"}
    assert silent["the anchor is full of water at once"] == "10 s of flooding"


def test_an_anchor_that_floods_early_fails_the_trial_with_its_probability():
    trials, found = mooring(chesapeake(premature_flooding=0.2), 2000)
    early = found.failures["anchor flooded before its release"]
    reached = np.count_nonzero(np.isfinite(found.start))
    assert np.count_nonzero(early) / reached == pytest.approx(0.2, abs=0.04)
    assert not np.any(trials.success & early)
    assert np.isnan(found.quantities["offset_m"][early]).all()
    _, plain = mooring(chesapeake(), 2000)
    assert "anchor flooded before its release" not in plain.failures
    kept = ~early & np.isfinite(plain.quantities["offset_m"])
    assert np.array_equal(found.quantities["offset_m"][kept], plain.quantities["offset_m"][kept])


@pytest.mark.parametrize(
    ("anchor", "words"),
    [
        ({"flooding_time": 5}, "flooding_time"),
        ({"premature_flooding": 1.5}, "premature_flooding"),
        ({"flooding_time": "2 h"}, "impossible"),
    ],
)
def test_what_cannot_be_is_refused(anchor, words):
    with pytest.raises(InputError, match=words):
        chesapeake(**anchor)
