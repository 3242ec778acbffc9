"""The members of a current's ensemble one by one: what is expected stays, and all trials sail in one of them."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from missionplan.montecarlo.common_streams import CommonStreams
from missionplan.montecarlo.streams import BLOCK, block_count, block_size
from missionplan.phases.currents import Current
from missionplan.phases.fields.ensemble import Ensemble
from missionplan.scenario.currents.drawn_current import with_member


def members_of(recorded: Current | None) -> tuple[tuple[str, float], ...]:
    """Names and probabilities of the members of an ensemble; none where the current is none."""
    if not isinstance(recorded, Ensemble):
        return ()
    return tuple(zip(recorded.names, recorded.weights.tolist(), strict=True))


def under_each_member(recorded: Current | None) -> Iterator[tuple[str, float, Ensemble]]:
    """Yield name and probability of each member, and the ensemble whose trials all sail in it."""
    if isinstance(recorded, Ensemble):
        for number, (name, weight) in enumerate(members_of(recorded)):
            yield name, weight, replace(recorded, given=number)


def trials_of_each(trials: int, members: int) -> int:
    """Trials of each member that together take about as long as the trials of the mission; at least one block."""
    return min(trials, max(trials // members, BLOCK))


def members_drawn(recorded: Current | None, seed: int, trials: int) -> NDArray[np.intp] | None:
    """Return which member each trial of a run sails in, shape (n,); None where there is no ensemble."""
    if not isinstance(recorded, Ensemble):
        return None
    streams, found = CommonStreams(seed), []
    for block in range(block_count(trials)):
        drawn = with_member(recorded, streams.of_block(block), block_size(trials, block))
        if isinstance(drawn, Ensemble) and drawn.chosen is not None:
            found.append(drawn.chosen)
    return np.concatenate(found)
