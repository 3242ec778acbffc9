import hashlib
import pickle

import numpy as np
import pytest

from missionplan.montecarlo import streams
from missionplan.montecarlo.streams import (
    BLOCK,
    BlockStreams,
    CommonStreams,
    LegNormals,
    block_count,
    block_size,
    stream,
)


def test_a_draw_depends_on_seed_name_and_block_only():
    reference = stream(1, "ingress.velocity_error", 3).standard_normal(8)
    stream(1, "something.else", 3).standard_normal(100)
    assert np.array_equal(stream(1, "ingress.velocity_error", 3).standard_normal(8), reference)
    for other in (
        stream(2, "ingress.velocity_error", 3),
        stream(1, "egress.velocity_error", 3),
        stream(1, "ingress.velocity_error", 4),
    ):
        assert not np.any(other.standard_normal(8) == reference)


def test_draws_stay_what_they_were():
    """A seed printed in an old report must still give that report's trials."""
    drawn = stream(1, "ingress.velocity_error", 0).standard_normal(3)
    assert drawn == pytest.approx([-1.789988300235136, -0.6543872003570455, 1.5668695786459872], abs=1e-15)


@pytest.mark.parametrize("seed", [0, 1, 2**32 - 1, 2**32, 2**127, 2**128 + 3])
@pytest.mark.parametrize("block", [0, 2**32 - 1, 2**41])
def test_name_and_block_are_the_spawn_key_of_the_seed(seed, block):
    name = np.frombuffer(hashlib.sha256(b"moor.offset").digest(), dtype="<u4").tolist()
    sequence = np.random.SeedSequence(seed, spawn_key=(*name, block))
    expected = np.random.Generator(np.random.SFC64(sequence)).standard_normal(5)
    assert np.array_equal(stream(seed, "moor.offset", block).standard_normal(5), expected)


def test_two_quantities_are_uncorrelated():
    blocks = range(16)
    first = np.concatenate([stream(5, "moor.release_time", block).standard_normal(BLOCK) for block in blocks])
    second = np.concatenate([stream(5, "moor.galvanic_release", block).standard_normal(BLOCK) for block in blocks])
    limit = 4.0 / np.sqrt(first.size)
    assert abs(np.corrcoef(first, second)[0, 1]) < limit
    assert abs(np.corrcoef(first[BLOCK:], first[:-BLOCK])[0, 1]) < limit
    assert abs(first.mean()) < limit


def test_leg_normals_do_not_depend_on_the_order_of_asking():
    forwards, jumping = LegNormals(1, "ingress.velocity_error", 0), LegNormals(1, "ingress.velocity_error", 0)
    last = jumping.leg(5).copy()
    for number in range(6):
        assert np.array_equal(forwards.leg(number), jumping.leg(number))
    assert np.array_equal(forwards.leg(5), last)
    assert forwards.leg(0).shape == (2, BLOCK)
    with pytest.raises(ValueError, match="read-only"):
        forwards.leg(0)[0, 0] = 1.0


@pytest.mark.parametrize(("trials", "sizes"), [(1, [1]), (BLOCK, [BLOCK]), (BLOCK + 1, [BLOCK, 1]), (0, [])])
def test_blocks_hold_all_trials(trials, sizes):
    assert [block_size(trials, block) for block in range(block_count(trials))] == sizes


def test_a_negative_seed_is_refused():
    with pytest.raises(ValueError):
        stream(-1, "a", 0)
    with pytest.raises(ValueError):
        stream(1, "a", -1)


def test_streams_that_are_kept_give_what_those_drawn_anew_give(monkeypatch):
    monkeypatch.setattr(streams, "MOST_KEPT", 6)
    common = CommonStreams(seed=5)
    for _ in range(3):  # what is kept is given up in between
        for block in (0, 2):
            kept, anew = pickle.loads(pickle.dumps(common)).of_block(block), BlockStreams(5, block)
            for source in (common.of_block(block), kept):
                assert np.array_equal(source.once("moor.hold"), anew.once("moor.hold"))
                legs, fresh = source.legs("ingress.fix_on_diving"), anew.legs("ingress.fix_on_diving")
                for number in (2, 0, 1):
                    assert np.array_equal(legs.leg(number), fresh.leg(number))
    assert common.of_block(0).once("moor.hold") is common.of_block(0).once("moor.hold")
